"""Error against processor time of the ways to couple pore water: Terzaghi's column of ten cells, at t = 0.1 s.

    python tests/benchmarks/water_splits.py [--repeat N] [-o FOLDER]

semi_implicit and explicit are the splits of `[water]`; two velocities the one-dimensional column of
`snowmpm.study.problems.two_velocity_column`, in NumPy, whose time compares with nothing but itself. Each is run with
several steps; the least processor time of the repeats counts, all of them in turn. Writes water_splits.csv and .png.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.compiler import runtime
from snowmpm.study.problems.soaked_column import pressure_error, soaked_column
from snowmpm.study.problems.two_velocity_column import TwoVelocityColumn

END = 0.1


def of_scene(split, share):
    """(steps, seconds, error) of a scene, by steps of `share` of the critical one."""
    simulation = soaked_column(split=split)
    solver = simulation.solver
    n = int(np.ceil(END / (share * solver.critical_dt()[0])))
    start = time.process_time()
    for _ in range(n):
        solver.step(END / n)
    return n, time.process_time() - start, pressure_error(simulation)


def of_two_velocities(share):
    """The same of two velocities."""
    column = TwoVelocityColumn(10)
    n = int(np.ceil(END / (share * column.longest_step)))
    start = time.process_time()
    for _ in range(n):
        column.step(END / n)
    return n, time.process_time() - start, column.pressure_error()


CASES = [*(("semi_implicit", share, of_scene) for share in (0.9, 0.7, 0.5, 0.25, 0.1)),
         ("explicit", 0.9, of_scene),
         *(("two velocities", share, None) for share in (0.9, 0.5, 0.25))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("-o", "--out", type=Path, default=Path("."))
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    of_scene("semi_implicit", 0.9)  # compiles
    found = {}
    for _ in range(options.repeat):
        for name, share, measure in CASES:
            n, seconds, error = measure(name, share) if measure else of_two_velocities(share)
            least = min(seconds, found.get((name, share), (0, np.inf, 0))[1])
            found[name, share] = n, least, error
            print(f"{name:15s} {share:5.2f} {n:7d} steps {least:8.3f} s  error {error:.4f}", flush=True)
    with open(options.out / "water_splits.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["way", "share_of_critical_step", "steps", "processor_seconds", "pressure_error"])
        writer.writerows([name, share, n, f"{seconds:.4g}", f"{error:.4g}"]
                         for (name, share), (n, seconds, error) in found.items())
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for way in dict.fromkeys(name for name, _ in found):
        points = [(seconds, error) for (name, _), (_, seconds, error) in found.items() if name == way]
        axes.loglog(*zip(*points, strict=True), "o-", label=way)
    axes.set(xlabel="processor time [s]", ylabel="largest error of the pressure, over its start",
             title="Terzaghi's column, 10 cells, t = 0.1 s")
    axes.legend()
    axes.grid(True, which="both", alpha=0.3)
    figure.savefig(options.out / "water_splits.png", dpi=120)


if __name__ == "__main__":
    main()
