"""Cost of a step of the material point method, ns per particle, and the share of each of its parts.

    python tests/benchmarks/mpm_step.py [--case NAME ...] [--particles N ...] [--precision f32 f64] [--threads 1 2]
                                        [--repeat N] [--csv FILE]

Cases, each in 2-D and 3-D (`block2`, `layer3`): `block`, an elastic block with 2^dim particles a cell; `yielding`, the
same of cohesive Cam-Clay, half or more of whose particles yield; `layer`, elastic snow 1.2 cells thick on a slope of 30
degrees.

Columns: ns a particle and step, median over the repeats of the mean of a few steps, and the least, since other programs
may use the machine; medians of its parts; ns a particle of one sort, and how many steps one serves; share of particles
that yielded; particles a block; bytes a particle, grid included. Load and the speed of a plain memory copy are measured
in the same run: without them a figure says little. Taichi starts once in a process, so each number of threads has a
process of its own.
"""

import argparse
import csv
import os
import subprocess
import sys
import time

import numpy as np

from snowmpm import runtime
from snowmpm.materials import CohesiveCamClay, Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population

SLAB = dict(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
CASES = {f"{name}{dim}": (name, dim) for dim in (3, 2) for name in ("block", "yielding", "layer")}
DX = 0.05
PARTS = ("particles_to_grid", "update_grid", "grid_to_particles")
SLOPE = np.deg2rad(30.0)
LAYER_CELLS = 1.2


class Slope:
    """Plane through the origin that dips towards +x, as the solver asks for terrain."""

    def query(self, points):
        normal = np.zeros(points.shape[1])
        normal[0], normal[-1] = np.sin(SLOPE), np.cos(SLOPE)
        return points @ normal, np.broadcast_to(normal, points.shape)


def box(shape, spacing):
    """Positions of a regular lattice of points (n, dim)."""
    axes = [(np.arange(n) + 0.5) * spacing for n in shape]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def make_solver(case, n_particles, precision):
    """Solver of about that many particles, in motion."""
    kind, dim = CASES[case]
    spacing = DX / 2
    options = dict(sides=[["open", "open"]] * (dim - 1) + [["stick", "open"]])
    if kind == "layer":
        spacing = LAYER_CELLS * DX / 2  # two points over the thickness
        shape = [round((n_particles / 2) ** (1 / (dim - 1)))] * (dim - 1) + [2]
        flat = box(shape, spacing)
        positions = flat.copy()
        positions[:, 0] = flat[:, 0] * np.cos(SLOPE) + flat[:, -1] * np.sin(SLOPE)
        positions[:, -1] = flat[:, -1] * np.cos(SLOPE) - flat[:, 0] * np.sin(SLOPE)
        options = dict(terrain=Slope(), terrain_contact="separate", terrain_friction=0.3)
    else:
        positions = box([round(n_particles ** (1 / dim))] * dim, spacing) + 0.013
    law = Elastic(**SLAB)
    if kind == "yielding":
        law = CohesiveCamClay(**SLAB, critical_slope=0.5, cohesion=0.0, hardening=1.0, p0=3e3)
    size = np.ptp(positions, axis=0).max() + 5.0
    velocities = 0.3 * np.sin(5.0 * positions[:, ::-1])
    population = Population(positions, np.full(len(positions), spacing**dim), 0, velocities=velocities)
    return MpmSolver(population, [law], dx=DX, precision=precision, origin=np.zeros(dim), lower=[-size] * dim,
                     upper=[size] * dim, gravity=[0.0] * (dim - 1) + [-9.81], **options)


def timed_step(solver, spent):
    """One step; adds the seconds of each part to `spent`."""
    def timed(name, call):
        def measured(*arguments):
            start = time.perf_counter()
            call(*arguments)
            spent[name] = spent.get(name, 0.0) + time.perf_counter() - start
        return measured

    for name in (*PARTS, "sort"):
        setattr(solver, name, timed(name, getattr(type(solver), name).__get__(solver)))
    start = time.perf_counter()
    solver.step(solver.stable_dt()[0])
    spent["step"] = spent.get("step", 0.0) + time.perf_counter() - start


def measure(case, n_particles, precision, repeat):
    """Row of the table: ns per particle and step, median and least over the repeats."""
    solver = make_solver(case, n_particles, precision)
    n = solver.particles.count
    for _ in range(3):
        solver.step(solver.stable_dt()[0])
    steps = max(2, 400_000 // n)
    samples = []
    for _ in range(repeat):
        spent = {}
        for _ in range(steps):
            timed_step(solver, spent)
        samples.append({part: 1e9 * seconds / steps / n for part, seconds in spent.items()})
    sort = []
    for _ in range(3):
        start = time.perf_counter()
        with runtime.precision(precision):
            solver.sort()
        sort.append(1e9 * (time.perf_counter() - start) / n)
    total = [sample["step"] for sample in samples]
    row = {"case": case, "particles": n, "precision": precision, "threads": runtime.threads(),
           "ns": np.median(total), "least": min(total)}
    row |= {part: np.median([sample[part] for sample in samples]) for part in PARTS}
    row |= {"one_sort": np.median(sort), "steps_per_sort": solver.steps / max(1, solver.sorts - 3),
            "yielding": solver.n_plastic / n, "per_block": n / len(solver.blocks),
            "bytes": solver.particles.bytes_per_particle + solver.grid.bytes / n,
            "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan"), "copy_GBps": copy_bandwidth()}
    return row


def copy_bandwidth(size=1 << 26, repeat=5):
    """Bytes read and written per second by a plain copy [GB/s], one thread, best of a few."""
    source, target = np.ones(size, np.uint8), np.zeros(size, np.uint8)
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        np.copyto(target, source)
        times.append(time.perf_counter() - start)
    return 2e-9 * size / min(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--particles", nargs="+", type=int, default=[64_000, 250_000])
    parser.add_argument("--precision", nargs="+", choices=runtime.DTYPES, default=["f32", "f64"])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--csv")
    options = parser.parse_args()
    if len(options.threads) > 1:
        for threads in options.threads:
            subprocess.run([sys.executable, __file__, *sys.argv[1:], "--threads", str(threads)], check=True)
        return
    runtime.start("cpu", threads=options.threads[0])
    report(options)


def report(options):
    rows = []
    for case in options.case:
        for n_particles in options.particles:
            for precision in options.precision:
                rows.append(measure(case, n_particles, precision, options.repeat))
                print_row(rows[-1], header=len(rows) == 1)
    if options.csv:
        new = not os.path.exists(options.csv)
        with open(options.csv, "a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            if new:
                writer.writeheader()
            writer.writerows(rows)


def print_row(row, header):
    shown = {name: f"{value:.2f}" if isinstance(value, float) and abs(value) < 10 else
             f"{value:.0f}" if isinstance(value, float) else str(value) for name, value in row.items()}
    widths = {name: max(len(name), 9) for name in row}
    if header:
        print(" ".join(f"{name:>{widths[name]}}" for name in row))
    print(" ".join(f"{shown[name]:>{widths[name]}}" for name in row), flush=True)


if __name__ == "__main__":
    main()
