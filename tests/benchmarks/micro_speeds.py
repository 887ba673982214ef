"""Speed of the flow through pores (LBM) and of grains (DEM), beside the copy bandwidth of the machine.

    python tests/benchmarks/micro_speeds.py [--voxels N] [--grains N] [--threads 1 2] [--precision f32 f64]
                                            [--repeat N] [-o FILE]

Flow: a simple cubic packing of solid fraction 0.343, N voxels a cell, periodic; both steps of the scheme in turn.
Grains: a jammed cell of N grains, and one of 200, as `snowmpm grains` tests them; looks for new pairs are counted in,
and only contacts with a force. Each number of threads runs in a process of its own; the copy of `mpm_step.py` in the
same one. Best and median of the repeats, compilation left out.

Columns: what; precision; threads; points: pore voxels, or contacts; pairs: watched, of grains; million_s: updates of a
point a second by the clock [1e6 / s], best, and median; a_core: best of those a second of the processor, all threads
together; copy_GBps: bytes read and written; needs_B: least bytes of an update; of_copy: bytes needed at the best speed
over those copied; load: of the machine.

    flow needs: 19 numbers read and written in each step, and 18 places read in every second one
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import mpm_step
import numpy as np
from mpm_step import copies, least_time

from snowmpm.compiler import runtime, ti
from snowmpm.draft import write_table
from snowmpm.micro.grains.assembly import Assembly, loose_cell
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.drive import compress
from snowmpm.micro.pore_lattice import pore_lattice
from snowmpm.micro.stokes_flow import StokesFlow
from tests.support.spheres import simple_cubic

TABLE = Path(__file__).parent / "figures" / "micro_speeds.csv"
NAMES = ["what", "precision", "threads", "points", "pairs", "million_s", "median", "a_core", "copy_GBps", "needs_B",
         "of_copy", "load"]
AT_LEAST = 0.5
"""Seconds of a repeat."""


def speeds(advance, repeat):
    """Updates a second of the clock and of the processor (repeat, 2) of `advance(count)`, which makes that many."""
    advance(2)
    count, spent = 2, 0.0
    while spent < AT_LEAST:
        count *= 2
        spent = timed(advance, count)[1]
    return np.array([count / timed(advance, count) for _ in range(repeat)])


def timed(advance, count):
    """Seconds of the clock and of the processor."""
    start = np.array([time.perf_counter(), time.process_time()])
    advance(count)
    ti.sync()
    return np.array([time.perf_counter(), time.process_time()]) - start


def flow_row(options, precision):
    ice, _ = simple_cubic(options.voxels, 0.343)
    lattice = pore_lattice(~ice)
    flow = StokesFlow(lattice, [1e-5, 0.0, 0.0], tau=3.0, precision=precision)
    found = 2.0 * lattice.count * speeds(flow.advance, options.repeat)
    width = np.dtype(runtime.DTYPES[precision][1]).itemsize
    return ["flow", precision, lattice.count, 0, found, 2 * 19 * width + 9 * lattice.table.itemsize]


def grains_row(options, count):
    positions, radii, box = loose_cell(count, 5e-4, solid=0.55)
    cell = Assembly(positions, radii, ContactLaw(5e3, 2.5e3, friction=0.2, damping=0.2), box=box)
    cell.damping = 0.005 / cell.dt
    compress(cell, 5e4, fastest=1e-4 / cell.dt, tolerance=0.05)
    cell.step(8)
    contacts = len(cell.forces()[0])
    found = contacts * speeds(cell.step, options.repeat)
    return [f"{count} grains", "f64", contacts, cell._pairs.count, found, float("nan")]


def measure(options):
    threads = options.threads[0]
    runtime.start("cpu", threads=threads)
    made = [flow_row(options, precision) for precision in options.precision]
    made += [grains_row(options, count) for count in (200, options.grains)]
    rows = []
    with mpm_step.ThreadPoolExecutor(threads) as pool:
        copied = 1e-9 * 2 * mpm_step.COPIED / least_time(copies(pool, threads))
    for what, precision, points, pairs, found, needed in made:
        best, core = found.max(axis=0)
        rows.append([what, precision, threads, points, pairs, *(f"{value:.4g}" for value in (
            1e-6 * best, 1e-6 * np.median(found[:, 0]), 1e-6 * core, copied, needed, 1e-9 * best * needed / copied)),
            f"{os.getloadavg()[0]:.2f}"])
        print(" ".join(f"{value!s:>12}" for value in rows[-1]), flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--voxels", type=int, default=96)
    parser.add_argument("--grains", type=int, default=20_000)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--precision", nargs="+", choices=["f32", "f64"], default=["f32", "f64"])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    options = parser.parse_args()
    if len(options.threads) == 1:
        write_table(options.output, NAMES, measure(options))
        return
    print(" ".join(f"{name:>12}" for name in NAMES))
    lines = []
    for threads in options.threads:
        part = options.output.with_suffix(f".{threads}.csv")
        subprocess.run([sys.executable, __file__, *sys.argv[1:], "--threads", str(threads), "-o", str(part)],
                       check=True)
        lines += [line.split(",") for line in part.read_text().splitlines()[1:]]
        part.unlink()
    write_table(options.output, NAMES, lines)


if __name__ == "__main__":
    main()
