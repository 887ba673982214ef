"""Error against work with fewer particles a cell: a collapse in 3-D.

    python tests/benchmarks/particles_a_cell.py [-o FILE] [--picture FILE] [--only-picture]

`column_collapse_3d` on one thread with 2, 4, 8 and 27 particles a cell on three grids; the reference is a finer grid
with 8. Columns: dx [m]; per_cell; particles; seconds: processor time of the steps, those left out that load kernels;
front: mean over time of the difference of the front from the reference's [m]; depth: sum of the differences of mass in
plan cells of 5 cm at the end, over all.
"""

from collapse_chart import command, compared, ran, rounded

REFERENCE = 0.0125, 8
CASES = [(dx, per_cell) for dx in (0.04, 0.025, 1.0 / 60.0) for per_cell in (2, 4, 8, 27)]
CELL = 0.05


def of(dx, per_cell):
    """`collapse_chart.ran` of a case."""
    return ran({"solver.dx": dx, "solver.particles_per_cell": per_cell}, CELL)


def computed():
    reference, rows = of(*REFERENCE), []
    for dx, per_cell in CASES:
        rows.append(rounded({"dx": dx, "per_cell": per_cell, **compared(of(dx, per_cell), reference)}))
        print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    command(__doc__.splitlines()[0], "particles_a_cell", computed, "per_cell", [
        (2, "C3:^", "2 a cell"), (4, "C0--s", "4 a cell"), (8, "k-o", "8 a cell"), (27, "C2-.d", "27 a cell")])
