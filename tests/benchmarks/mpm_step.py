"""Cost of a step of the material point method, ns per particle, and the share of each of its parts.

    python tests/benchmarks/mpm_step.py [--case NAME ...] [--particles N ...] [--precision f32 f64] [--threads 1 2]
                                        [--basis quadratic cubic] [--transfer apic ...] [--gradient affine shape]
                                        [--repeat N] [--backend cpu|cuda] [--csv FILE]

Cases, each in 2-D and 3-D (`block2`, `layer3`): `block`, an elastic block with 2^dim particles a cell; `half`, the same
of cohesive Cam-Clay, about half of whose particles yield (the column `yielding` says how many); `yielding`, most of
whose particles yield; `layer`, elastic snow 1.2 cells thick on a slope of 30 degrees.

Columns: ns a particle and step, median over the repeats of the mean of a few steps, and the least, since other programs
may use the machine; medians of its parts; ns a particle of one sort, and how many steps one serves; share of particles
that yielded; particles a block; bytes a particle, grid included.

Limits, measured in the same run by as many threads, without which a figure says little: copy_GBps, bytes read and
written by NumPy's copy of 128 MiB; GFlops, chains of multiply-adds that Taichi compiles to vectors, two flops each.
`needs_B`, `needs_flop`: what a step must at least move and compute (see `needs`); `of_limit`: the longer of the two
times that this takes at those rates, over the least time. Taichi starts once in a process, so each number of threads
has a process of its own.

On a GPU (`--backend cuda`) parts are timed to their end, and the copy is a kernel's. Figures at large sizes:

    python tests/benchmarks/mpm_step.py --backend cuda --threads 1 --case half3 half2 --particles 1000000 10000000
"""

import argparse
import csv
import functools
import itertools
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, is_worker
from snowmpm.materials import CohesiveCamClay, Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.population import Population

SLAB = dict(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
CASES = {f"{name}{dim}": (name, dim) for dim in (3, 2) for name in ("block", "half", "yielding", "layer")}
DX = 0.05
PARTS = ("particles_to_grid", "update_grid", "grid_to_particles")
SLOPE = np.deg2rad(30.0)
LAYER_CELLS = 1.2
P0 = {"half": 1e5, "yielding": 3e3}
"""Initial strength [Pa]: half of the particles of a block in motion yield, those that dilate, or most of them."""
LAW_FLOPS = {2: (150, 350), 3: (300, 600)}
"""Operations of an elastic update, and of one that yields: trial state, logarithm, return map in two steps and
exponential, estimated from the sources of the straight-line laws."""
COPIED, CHAINS, LINKS, ROUNDS, GPU_ROUNDS = 1 << 27, 128, 4, 32_000, 64


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


def make_solver(case, n_particles, precision, **scheme):
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
    if kind in P0:
        law = CohesiveCamClay(**SLAB, critical_slope=0.5, cohesion=0.0, hardening=1.0, p0=P0[kind])
    size = np.ptp(positions, axis=0).max() + 5.0
    velocities = 0.3 * np.sin(5.0 * positions[:, ::-1])
    population = Population(positions, np.full(len(positions), spacing**dim), 0, velocities=velocities)
    return MpmSolver(population, [law], dx=DX, precision=precision, origin=np.zeros(dim), lower=[-size] * dim,
                     upper=[size] * dim, gravity=[0.0] * (dim - 1) + [-9.81], **options, **scheme)


def timed_step(solver, spent):
    """One step; adds the seconds of each part to `spent`."""
    def timed(name, call):
        def measured(*arguments):
            start = time.perf_counter()
            call(*arguments)
            ti.sync()
            spent[name] = spent.get(name, 0.0) + time.perf_counter() - start
        return measured

    for name in (*PARTS, "sort"):
        setattr(solver, name, timed(name, getattr(type(solver), name).__get__(solver)))
    start = time.perf_counter()
    solver.step(solver.stable_dt()[0])
    ti.sync()
    spent["step"] = spent.get("step", 0.0) + time.perf_counter() - start


def measure(case, n_particles, precision, repeat, **scheme):
    """Row of the table: ns per particle and step, median and least over the repeats."""
    solver = make_solver(case, n_particles, precision, **scheme)
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
        ti.sync()
        sort.append(1e9 * (time.perf_counter() - start) / n)
    total = [sample["step"] for sample in samples]
    row = {"case": case, "particles": n, "precision": precision, "threads": runtime.threads(),
           "basis": scheme["kernel"], "transfer": scheme["transfer"], "gradient": scheme["gradient"],
           "ns": np.median(total), "least": min(total)}
    row |= {part: np.median([sample[part] for sample in samples]) for part in PARTS}
    row |= {"one_sort": np.median(sort), "steps_per_sort": solver.steps / max(1, solver.particles.sorts - 3),
            "yielding": solver.n_plastic / n, "per_block": n / len(solver.particles.blocks),
            "bytes": solver.particles.bytes_per_particle + solver.grid.bytes / n,
            "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")}
    bandwidth, rate = machine_limits(precision)
    moved, computed = needs(solver)
    limit = max(moved / bandwidth, computed / rate)
    row |= {"copy_GBps": bandwidth, "GFlops": rate, "needs_B": moved, "needs_flop": computed,
            "of_limit": limit / row["least"], "backend": runtime.backend()}
    return row


def needs(solver):
    """Least bytes and flops of a step a particle.

    Bytes: the columns that the scatter and the gather read and the gather writes, once each, and four passes over the
    nodes of the blocks. Flops: per node of a stencil, scatter 3 (dim + 1) + 1 (linear function, weight, sum), gather
    4 dim (a sum and a moment along the last axis; the other axes add a third or a quarter of that, left out); and those
    of the law.
    """
    layout, dim = solver.particles.layout, solver.dim
    flip = solver.flip
    size = layout.sizes
    scatter = sum(size[name] for name in ("position", "velocity", "affine", "stress", "volume"))
    kept = sum(size[name] for name in ("position", "elastic", "state", "volume_ratio"))
    gather = kept + size["volume"] + flip * size["velocity"]
    written = kept + sum(size[name] for name in ("velocity", "affine", "stress"))
    nodes = 4 * 4 * (1 + flip) * len(solver.particles.blocks) * EDGE[dim] ** dim / solver.particles.count
    moved = (scatter + gather + written + nodes) * np.dtype(solver.particles.numpy_dtype).itemsize + 2
    stencil = STENCILS[solver.basis].width ** dim
    elastic, plastic = LAW_FLOPS[dim]
    share = solver.n_plastic / solver.particles.count
    return moved, stencil * (3 * (dim + 1) + 1 + 4 * dim) + (1.0 - share) * elastic + share * plastic


@functools.cache
def chain_kernel(real):
    """CHAINS chains of multiply-adds in every thread, LINKS at a time in registers, in loops that are vectorised."""

    @ti.kernel
    def multiply_add(factor: real, result: ti.types.ndarray(), work: ti.types.ndarray()):
        for i in range(chunks(work)):
            if is_worker(i):
                first, last = chunk(i, work)
                chains = ti.Vector.zero(real, CHAINS)
                for _ in range(first, last):
                    for k in range(CHAINS):
                        x = chains[k]
                        for _ in ti.static(range(LINKS)):
                            x = x * factor + 0.25
                        chains[k] = x
                for k in range(CHAINS):
                    result[first] += chains[k]

    return multiply_add


@ti.kernel
def copy(source: ti.types.ndarray(), target: ti.types.ndarray()):
    for i in range(source.shape[0]):
        target[i] = source[i]


@functools.cache
def machine_limits(precision):
    """-> (bytes, flops) per ns: the best of a few, by as many threads as the step has."""
    real = runtime.DTYPES[precision][0]
    threads, kernel = runtime.threads(), chain_kernel(real)
    rounds = ROUNDS * (GPU_ROUNDS if runtime.backend() == "cuda" else threads)
    result, work = ti.ndarray(real, rounds), int_array(chunk_bounds(np.ones(rounds)))
    with ThreadPoolExecutor(threads) as pool, runtime.precision(precision):
        copied = least_time(copies(pool, threads))
        computed = least_time(lambda: kernel(0.5, result, work))
    return 1e-9 * 2 * COPIED / copied, 1e-9 * 2 * CHAINS * LINKS * rounds / computed


def copies(pool, threads):
    """Function that copies COPIED bytes: NumPy by threads of a CPU, a kernel on a GPU."""
    if runtime.backend() == "cuda":
        arrays = [ti.ndarray(ti.i32, COPIED // 4) for _ in range(2)]
        return lambda: copy(*arrays)
    source, target = (np.full(COPIED, k, np.uint8) for k in range(2))
    cuts = np.linspace(0, COPIED, threads + 1).astype(int)
    parts = [slice(first, last) for first, last in itertools.pairwise(cuts)]
    return lambda: list(pool.map(lambda part: np.copyto(target[part], source[part]), parts))


def least_time(call, repeat=6):
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        call()
        ti.sync()
        times.append(time.perf_counter() - start)
    return min(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--particles", nargs="+", type=int, default=[250_000, 2_000_000])
    parser.add_argument("--precision", nargs="+", choices=runtime.DTYPES, default=["f32", "f64"])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--basis", nargs="+", choices=STENCILS, default=["quadratic"])
    parser.add_argument("--transfer", nargs="+", choices=["pic", "apic", "flip", "aflip"], default=["apic"])
    parser.add_argument("--gradient", nargs="+", choices=["affine", "shape"], default=["affine"])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--backend", choices=["cpu", "cuda"], default="cpu")
    parser.add_argument("--csv")
    options = parser.parse_args()
    if len(options.threads) > 1:
        for threads in options.threads:
            subprocess.run([sys.executable, __file__, *sys.argv[1:], "--threads", str(threads)], check=True)
        return
    runtime.start(options.backend, threads=options.threads[0])
    report(options)


def report(options):
    rows = []
    every = itertools.product(options.case, options.particles, options.precision, options.basis, options.transfer,
                              options.gradient)
    for case, n_particles, precision, basis, transfer, gradient in every:
        rows.append(measure(case, n_particles, precision, options.repeat, kernel=basis, transfer=transfer,
                            gradient=gradient))
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
