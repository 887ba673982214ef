"""Failure of voxel snow with breaking ice in pull, shear, push and between, and its envelope (E16).

    python tests/benchmarks/voxel_snow.py [--draw]

Five made samples along seven paths (`tests.support.voxel_snow`), sheared both ways, and for the first of them pull,
shear and push at half the rate of the load, on finer cells, and in a larger cube. Half an hour on one core. Writes
figures/voxel_snow.csv and docs/figures/voxel_snow.png; with --draw the picture only. Columns: m, Pa/s, Pa and s; sigma
and tau are those of the foot at its peak, `applied` is the load on the head then.
"""

import argparse
import csv
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1]))

import snowmpm  # noqa: E402
from snowmpm.draft import write_table  # noqa: E402
from tests.support.mede import MEDE  # noqa: E402
from tests.support.voxel_snow import CHECKED, DX, PATHS, RATE, SEEDS, SIDE, VARIANTS, broken, made  # noqa: E402

TABLE = HERE / "figures" / "voxel_snow.csv"
NAMES = ["case", "seed", "mirrored", "side", "dx", "rate", "path", "sigma", "tau", "applied", "time", "shortening",
         "shear", "fell"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draw", action="store_true")
    if not parser.parse_args().draw:
        measure()
    draw()


def measure():
    snowmpm.start("cpu", threads=1)
    cases = [("base", seed, mirrored, path, {}) for seed in SEEDS for path, (_, shear) in PATHS.items()
             for mirrored in ((False, True) if shear else (False,))]
    cases += [(name, SEEDS[0], False, path, options) for name, options in VARIANTS.items() for path in CHECKED
              if (name, path) != ("larger cube", "push")]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, seed, mirrored, path, options in cases:
            all_of = {"side": SIDE, "dx": DX, "rate": RATE, **options}
            peak = broken(path, made(Path(folder), seed, all_of["side"], mirrored), **all_of)
            numbers = (peak.sigma, peak.tau, peak.applied, peak.time, peak.shortening, peak.shear)
            rows.append([name, seed, int(mirrored), *(f"{all_of[key]:g}" for key in ("side", "dx", "rate")), path,
                         *(f"{value:.4g}" for value in numbers), int(peak.fell)])
            print(*rows[-1], flush=True)
            write_table(TABLE, NAMES, rows)


def draw():
    """Envelopes over the strength in push; dashed: sheared the other way."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["case"] == "base"]
    figure = Figure(figsize=(7.4, 3.6), layout="constrained")
    panel = figure.subplots()
    for style, (name, fit) in zip(("-", "--", ":"), MEDE.items(), strict=True):
        steep = np.linspace(0.0, 20.0, 400)
        points = [fit.on((slope, 1.0)) for slope in steep]
        sigma, tau = np.array([[-fit.apex, 0.0], *points, [fit.compression, 0.0]]).T / fit.compression
        panel.plot(sigma, tau, style, color="0.4", lw=1.0, label=f"{name}, fit of Mede et al. (2018)")
    for colour, seed in zip(("C0", "C1", "C2", "C3", "C4"), SEEDS, strict=True):
        of = {(row["path"], row["mirrored"]): np.array([float(row["sigma"]), float(row["tau"])])
              for row in rows if row["seed"] == str(seed)}
        push = of["push", "0"][0]
        for way, line in (("0", "o-"), ("1", "s--")):
            points = np.array([of.get((path, way), of[path, "0"]) for path in PATHS]) / push
            panel.plot(*points.T, line, color=colour, ms=3, lw=0.8, label=None if way == "1" else f"sample {seed}")
    panel.axhline(0.0, color="k", lw=0.5)
    panel.set(xlabel="normal stress over strength in push", ylabel="shear stress over it", aspect="equal")
    figure.legend(fontsize=7, loc="outside right upper")
    figure.savefig(HERE.parents[1] / "docs" / "figures" / "voxel_snow.png", dpi=90)


if __name__ == "__main__":
    main()
