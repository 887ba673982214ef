"""Error against work with fewer particles a cell: a collapse in 3-D.

    python tests/benchmarks/particles_a_cell.py [-o FILE] [--picture FILE] [--only-picture]

`column_collapse_3d` on one thread with 2, 4, 8 and 27 particles a cell on three grids; the reference is a finer grid
with 8. Columns: dx [m]; per_cell; particles; seconds: processor time of the steps, those left out that load kernels;
front: mean over time of the difference of the front from the reference's [m]; depth: sum of the differences of mass in
plan cells of 5 cm at the end, over all.
"""

import argparse
import csv
from pathlib import Path

from sleeping_chart import compared, ran, rounded

from snowmpm.compiler import runtime

FIGURES = Path(__file__).parent / "figures"
REFERENCE = 0.0125, 8
CASES = [(dx, per_cell) for dx in (0.04, 0.025, 1.0 / 60.0) for per_cell in (2, 4, 8, 27)]
CELL = 0.05


def of(dx, per_cell):
    """`sleeping_chart.ran` of a case."""
    return ran({"solver.dx": dx, "solver.particles_per_cell": per_cell}, CELL)


def computed():
    reference, rows = of(*REFERENCE), []
    for dx, per_cell in CASES:
        rows.append(rounded({"dx": dx, "per_cell": per_cell, **compared(of(dx, per_cell), reference)}))
        print(rows[-1], flush=True)
    return rows


def draw(rows, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), sharex=True, layout="constrained")
    for axis, name, label in zip(axes, ("front", "depth"), ("front [m]", "deposit, share of the mass"), strict=True):
        for per_cell, style in ((2, "C3:^"), (4, "C0--s"), (8, "k-o"), (27, "C2-.d")):
            points = sorted((float(row["seconds"]), float(row[name])) for row in rows
                            if int(row["per_cell"]) == per_cell)
            axis.loglog(*zip(*points, strict=True), style, label=f"{per_cell} a cell")
        axis.set(xlabel="processor seconds of the steps", title=f"off by: {label}")
    axes[0].legend()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=FIGURES / "particles_a_cell.csv")
    parser.add_argument("--picture", type=Path, default=FIGURES / "particles_a_cell.png")
    parser.add_argument("--only-picture", action="store_true")
    options = parser.parse_args()
    if not options.only_picture:
        runtime.start("cpu", threads=1)
        rows = computed()
        with open(options.output, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    with open(options.output, newline="", encoding="utf-8") as file:
        draw(list(csv.DictReader(file)), options.picture)


if __name__ == "__main__":
    main()
