"""Heaps of round columns over the distance from their middle, by MPM and SPH, beside what is published of them.

    python tests/benchmarks/round_profiles.py [--runs FOLDER] [-o FOLDER]

Columns of height 0.55 and 0.9 radii (`tests/support/round_columns.py`). Minutes on one core. With
--runs the runs are kept in FOLDER. Writes round_profiles.csv and .png.
"""

import argparse
import csv
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1]))

from tests.support.round_columns import RADIUS, SPACING, collapsed, depths, disc, heap, published  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    parser.add_argument("--runs", type=Path)
    options = parser.parse_args()
    figure, axes = plt.subplots(2, 1, figsize=(7, 5.2), sharex=True, constrained_layout=True)
    rows = []
    for a, axis in zip((0.55, 0.9), axes, strict=True):
        reach, height = published(a)
        axis.plot([0.0, 1.0, 1.0], [a, a, 0.0], ":", color="0.5", label="column at the start")
        for method, color in (("mpm", "C0"), ("sph", "C1")):
            with tempfile.TemporaryDirectory() as scratch:
                case = collapsed(a, method, (options.runs or Path(scratch)) / f"{method}_{a:g}")
                found = heap(case)
                r, depth = depths(case)
            axis.plot(r / RADIUS, depth / RADIUS, color=color, label=f"{method.upper()}, {RADIUS / SPACING[method]:.0f}"
                      " particles over the radius")
            rows.append({"a": a, "method": method, "spacing_m": round(SPACING[method], 5),
                         "run_out_m": round(found.front, 4), "published_run_out_m": round(reach, 4),
                         "height_m": round(float(found.top[0]), 4), "published_height_m": round(height, 4),
                         "disc_m": round(disc(found, case), 4)})
            print(*rows[-1].values(), flush=True)
        axis.plot([0.0, reach / RADIUS], [height / RADIUS, 0.0], "k^", clip_on=False,
                  label="height, run-out, published")
        axis.set(ylabel="depth over d0", title=f"column of {a:g} radii", aspect="equal", ylim=(0.0, 1.0))
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    axes[1].set_xlabel("distance from the middle over d0")
    figure.savefig(options.output / "round_profiles.png", dpi=80)
    with open(options.output / "round_profiles.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
