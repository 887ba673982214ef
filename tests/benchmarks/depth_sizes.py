"""Time of a depth-averaged step a column, for flows of 1e4 to 1e7 columns.

    python tests/benchmarks/depth_sizes.py [--sizes 1e4 1e5 1e6 1e7] [--threads 1] [--runs 3] [-o FILE]

A square sheet on a plane of 25 degrees, friction of 20, waves on it, 4 columns a cell, float32. Nanoseconds of
processor time a column and step, the median of several rounds in which the sizes take turns.
"""

import argparse
import csv
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from snowmpm.compiler import runtime
from tests.support.depth_flows import Ground, Options, coulomb, flow, lattice, slope

DX = 5.0
COLUMN_STEPS = 2e7
"""Columns times steps of a measurement."""


def sheet(count):
    """`DepthSolver` of about `count` columns, over ground twice as long."""
    side = np.sqrt(count) * DX / 2.0
    plan, area = lattice((0.0, 0.0), (side, side), DX / 2.0)
    depth = 1.0 + 0.3 * np.sin(plan[:, 0] / 40.0) * np.cos(plan[:, 1] / 30.0)
    ground = Ground(slope(25.0), (-10 * DX, -10 * DX), (2.0 * side + 200.0, side + 10 * DX), coulomb(20.0))
    return flow(plan, depth * area, ground, DX, options=Options(precision="f32"))


def a_step(solver):
    """Processor seconds of a step, after two."""
    steps = max(5, round(COLUMN_STEPS / solver.particles.count))
    for _ in range(2):
        solver.step(solver.stable_dt()[0])
    start = time.process_time()
    for _ in range(steps):
        solver.step(solver.stable_dt()[0])
    return (time.process_time() - start) / steps


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=float, nargs="+", default=[1e4, 1e5, 1e6, 1e7])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("-o", type=Path, default=Path(__file__).parent / "figures" / "depth_sizes.csv")
    arguments = parser.parse_args()
    runtime.start("cpu", threads=arguments.threads)
    found = {size: [] for size in arguments.sizes}
    counts = {}
    for _ in range(arguments.runs):
        for size in found:
            solver = sheet(size)
            counts[size] = solver.particles.count
            found[size].append(1e9 * a_step(solver) / counts[size])
    with open(arguments.o, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["columns", "ns_a_column_step", "lowest", "highest", "threads", "precision", "load"])
        for size, times in found.items():
            row = [counts[size], *(round(value, 1) for value in (statistics.median(times), min(times), max(times))),
                   arguments.threads, "f32", round(os.getloadavg()[0], 1)]
            table.writerow(row)
            print(*row)


if __name__ == "__main__":
    main()
