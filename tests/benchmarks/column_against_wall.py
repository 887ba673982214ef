"""BM-1: a column of grains against a flexible wall, by two couplings on three grids; a table, and a chart of the tip.

    python tests/benchmarks/column_against_wall.py [--grids 5 2.5 2] [--couplings one_body parts] [-o FOLDER]

One body: soil and wall share the velocities of the grid, and stick to each other. Parts: the wall is a chain of
segments with strong coupling, which the soil may leave. Of each run: the first peak of the tip's displacement, its mean
after 0.8 s, half of its range and its period after the first peak, the gap between soil and wall and the mass of soil
in the upper left that has moved by more than 5 mm, both at 0.5 s.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.components.structures.column_against_wall import measure

COLUMNS = ("coupling", "dx", "particles", "steps", "first_peak", "late", "half_range", "period", "gap", "upper_left",
           "unsettled", "seconds")


def chart(curves, path):
    """Displacement of the tip over time, by coupling and grid."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for (times, found, row) in curves:
        panel = panels[0 if row["coupling"] == "one body" else 1]
        panel.plot(times, 1e3 * found, label=f"{1e3 * row['dx']:g} mm")
        panel.set_title("one body: soil and wall stick" if row["coupling"] == "one body" else "parts: soil may leave")
    for panel in panels:
        panel.set_xlabel("time [s]")
        panel.legend(title="grid")
    panels[0].set_ylabel("displacement of the tip [mm]")
    figure.savefig(path, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--grids", type=float, nargs="+", default=[5.0, 2.5, 2.0], help="[mm]")
    parser.add_argument("--couplings", nargs="+", choices=["one_body", "parts"], default=["one_body", "parts"])
    parser.add_argument("--until", type=float, default=1.0)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures")
    options = parser.parse_args()
    curves = []
    for coupling in options.couplings:
        for grid in options.grids:
            curves.append(measure(1e-3 * grid, coupling == "one_body", options.until))
            print({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in curves[-1][2].items()},
                  flush=True)
            write([row for _, _, row in curves], options.output / "column_against_wall.csv")
    np.savez_compressed(options.output / "column_against_wall.npz", **{
        f"{row['coupling']} {1e3 * row['dx']:g}": np.stack([times, found]) for times, found, row in curves})
    chart(curves, options.output / "column_against_wall.png")


def write(rows, path):
    """The table."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
                         for row in rows)


if __name__ == "__main__":
    main()
