"""Avalanches of ours beside thirteen programs (ISeeSnow, doi:10.5194/egusphere-2025-6053): run-out, peaks.

    python tests/benchmarks/iseesnow.py FOLDER [--case CoulombOnly IdealizedTopo] [--dx 5] [--mpm 3] [-o OUT]

FOLDER: the study's cases, each with Inputs/ and peaks/ (5 m rasters). Writes iseesnow.csv, and iseesnow.png with a row
for each case: run-out, areas above 1 m/s and 0.1 m, percentiles of peak speed and depth of every program. --dx: cells
of depth-averaged runs; --mpm: cells of runs in three dimensions by MPM, of snow without cohesion and with more inner
friction than the ground, whose Coulomb friction is the same: only for CoulombOnly. Runs that are complete in OUT are
read, not made again.
"""

import argparse
import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np

import snowmpm
from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support.iseesnow import CASES, of_program, of_run, scene, scene_3d

DRAWN = {"runout": ("run-out s [m]", 1.0), "speed_area": ("area above 1 m/s [ha]", 1e-4),
         "depth_area": ("area above 0.1 m [ha]", 1e-4), "speed_95": ("peak speed, 95 % [m/s]", 1.0),
         "speed_99": ("peak speed, 99 % [m/s]", 1.0), "depth_95": ("peak depth, 95 % [m]", 1.0),
         "depth_99": ("peak depth, 99 % [m]", 1.0)}
"""Title and factor of each number."""


def made(given, folder):
    """The run in a folder, or a new one."""
    if (folder / "summary.json").exists() and Run(folder).complete:
        return Run(folder)
    return snowmpm.run(given, folder)


def ours(data, case, chosen, out):
    """{name: numbers} of our runs of a case."""
    found = {}
    for dx in chosen.dx:
        run = made(scene(data, case, dx), out / f"{case}_{dx:g}")
        found[f"snowmpm depth, {dx:g} m"] = of_run(data, case, run)
    for dx in chosen.mpm if CASES[case]["law"] == "coulomb" else []:
        run = made(scene_3d(data, case, dx), out / f"{case}_mpm_{dx:g}")
        found[f"snowmpm mpm, {dx:g} m"] = of_run(data, case, run)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--case", nargs="*", default=list(CASES))
    parser.add_argument("--dx", nargs="*", type=float, default=[5.0])
    parser.add_argument("--mpm", nargs="*", type=float, default=[])
    parser.add_argument("-o", default="iseesnow")
    chosen = parser.parse_args()
    out = Path(chosen.o)
    out.mkdir(parents=True, exist_ok=True)
    rows, cases = [], {}
    for case in chosen.case:
        cases[case] = found = {**of_program(chosen.folder, case), **ours(chosen.folder, case, chosen, out)}
        rows += [{"case": case, "program": name, **{k: round(float(v), 3) for k, v in values.items()}}
                 for name, values in found.items()]
        for row in rows:
            if row["case"] == case:
                print(f"{row['program']:24s} s {row['runout']:5.0f} m, v95 {row['speed_95']:5.1f},"
                      f" v99 {row['speed_99']:5.1f},"
                      f" h99 {row['depth_99']:5.2f}, {row['speed_area'] / 1e4:5.1f} ha fast,"
                      f" {row['depth_area'] / 1e4:5.1f} ha deep")
    with open(out / "iseesnow.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    draw(cases, out / "iseesnow.png")


def draw(cases, path):
    """A row of panels for each case: the programs of the study in order of their value, ours among them, the median."""
    figure, axes = plt.subplots(len(cases), len(DRAWN), figsize=(2.9 * len(DRAWN), 4.6 * len(cases)), squeeze=False,
                                constrained_layout=True)
    for row, (case, found) in zip(axes, cases.items(), strict=True):
        for axis, (key, (title, factor)) in zip(row, DRAWN.items(), strict=True):
            order = sorted(found, key=lambda name: found[name][key])
            values = [factor * found[name][key] for name in order]
            own = [name.startswith("snowmpm") for name in order]
            axis.scatter(values, range(len(order)), c=["tab:red" if mine else "tab:gray" for mine in own], s=22)
            axis.axvline(factor * np.median([found[name][key] for name in order if not name.startswith("snowmpm")]),
                         color="k", linewidth=0.8)
            axis.set_yticks(range(len(order)), order, fontsize=6)
            for label, mine in zip(axis.get_yticklabels(), own, strict=True):
                label.set_color("tab:red" if mine else "black")
            axis.set_title(title, fontsize=8)
            axis.tick_params(axis="x", labelsize=7)
        row[0].set_ylabel(case)
    figure.suptitle("Thirteen programs of ISeeSnow and ours; line: median of the thirteen", fontsize=10)
    figure.savefig(path, dpi=70)


if __name__ == "__main__":
    main()
