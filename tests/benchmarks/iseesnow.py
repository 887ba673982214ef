"""Depth-averaged avalanches beside thirteen programs (ISeeSnow, doi:10.5194/egusphere-2025-6053): run-out, peaks.

    python tests/benchmarks/iseesnow.py FOLDER [--case CoulombOnly|IdealizedTopo] [--dx 5] [-o OUT]

FOLDER: the study's cases, each with Inputs/ and peaks/ (5 m rasters). Writes a table iseesnow.csv and a chart a case.
"""

import argparse
import csv
import sys
from pathlib import Path

import snowmpm

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support.iseesnow import CASES, of_program, of_run, scene


def main():
    """Run, table, chart."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--case", nargs="*", default=list(CASES))
    parser.add_argument("--dx", nargs="*", type=float, default=[5.0])
    parser.add_argument("-o", default="iseesnow")
    chosen = parser.parse_args()
    out = Path(chosen.o)
    out.mkdir(parents=True, exist_ok=True)
    rows = []
    for case in chosen.case:
        found = of_program(chosen.folder, case)
        for dx in chosen.dx:
            run = snowmpm.run(scene(chosen.folder, case, dx), out / f"{case}_{dx:g}")
            found[f"snowmpm depth, {dx:g} m"] = of_run(chosen.folder, case, run)
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


if __name__ == "__main__":
    main()
