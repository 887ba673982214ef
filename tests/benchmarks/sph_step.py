"""Speed of an SPH step: particle-steps per second, ns per pair of neighbours, from 1e4 to 1e6 particles.

    python tests/benchmarks/sph_step.py [--threads N] [--sizes 1e4 1e5 1e6] [--dimension 2 3] [--pysph PYTHON]

An elastic block with small random velocities, free on all sides, or with --bed a granular one on rough ground, which
has dummies. --pysph names a Python that has PySPH (https://pysph.readthedocs.io): the block at 1e4 particles then runs
there too, by PySPH's own scheme for elastic solids (cubic spline, h = 1.3 dx, artificial stress), on one thread.
A pair is a particle and a neighbour within 2 h of it, seen from one of them; each step meets every pair twice.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.materials import DruckerPrager, Elastic
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.sph.solver import SphSolver

DX = 0.01
ELASTIC = Elastic(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3)
SAND = DruckerPrager(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3, friction_angle=30.0)


def block(dim, count, bed):
    """Solver of about `count` particles."""
    n = round(count ** (1.0 / dim))
    axis = DX * (np.arange(n) + 0.5)
    x = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    velocity = np.random.default_rng(1).normal(0.0, 1e-3, x.shape)
    gravity, lower, sides = np.zeros(dim), np.full(dim, -n * DX), [["open", "open"]] * dim
    if bed:
        gravity[-1], lower[-1], sides = -9.81, 0.0, [["open", "open"]] * (dim - 1) + [["stick", "open"]]
    return SphSolver(Population(x, np.full(len(x), DX**dim), 0, velocity), [SAND if bed else ELASTIC], dx=DX,
                     precision="f32", origin=lower, lower=lower, upper=np.full(dim, 2.0 * n * DX), gravity=gravity,
                     sides=sides, scheme=Sph())


def pairs(solver):
    """Neighbours within the support of a particle, on average."""
    from scipy.spatial import cKDTree

    x = solver.particles.positions()
    some = np.random.default_rng(2).choice(len(x), min(2000, len(x)), replace=False)
    found = cKDTree(x).query_ball_point(x[some], solver.radius * solver.dx, return_length=True)
    return float(found.mean() - 1.0)


def measure(solver, seconds):
    """Seconds per step, over about so many seconds and at least three steps."""
    dt = solver.stable_dt()[0]
    for _ in range(3):
        solver.step(dt)
    began, steps = time.perf_counter(), 0
    while steps < 3 or time.perf_counter() - began < seconds:
        solver.step(solver.stable_dt()[0])
        steps += 1
    return (time.perf_counter() - began) / steps


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--sizes", type=float, nargs="+", default=[1e4, 1e5, 1e6])
    parser.add_argument("--dimension", type=int, nargs="+", default=[2, 3])
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--bed", action="store_true")
    parser.add_argument("--pysph")
    chosen = parser.parse_args()
    runtime.start("cpu", chosen.threads)
    ours = {}
    for dim in chosen.dimension:
        for size in chosen.sizes:
            solver = block(dim, size, chosen.bed)
            step, n = measure(solver, chosen.seconds), solver.particles.count
            near = pairs(solver)
            ours[dim, size] = step / n
            print(f"{dim}-D {n:8d} particles, {chosen.threads} thread(s): {n / step / 1e6:6.2f} M particle-steps/s,"
                  f" {1e9 * step / n:7.0f} ns a particle, {1e9 * step / n / (2 * near):5.2f} ns a pair ({near:.0f}"
                  " neighbours)", flush=True)
    if not chosen.pysph:
        print("PySPH: not asked for (--pysph PYTHON)")
        return
    for dim in chosen.dimension:
        with tempfile.TemporaryDirectory() as folder:
            said = subprocess.run([chosen.pysph, str(Path(__file__).with_name("pysph_block.py")), str(dim),
                                   str(int(chosen.sizes[0])), "25", folder], text=True, capture_output=True)
        if said.returncode:
            print(f"PySPH {dim}-D: did not run: {said.stderr.strip().splitlines()[-1]}")
            continue
        found = json.loads(said.stdout.splitlines()[-1])
        theirs = found["seconds_per_step"] / found["particles"]
        print(f"PySPH {dim}-D {found['particles']} particles: {1e-6 / theirs:.3f} M particle-steps/s;"
              f" here {theirs / ours[dim, chosen.sizes[0]]:.1f} times as fast")


if __name__ == "__main__":
    main()
