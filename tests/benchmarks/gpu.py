"""Every figure of a GPU, by one command: steps of all methods, memory, agreement with the CPU.

    python tests/benchmarks/gpu.py [-o FILE]
    python tests/benchmarks/gpu.py --rehearse [-o FILE]      # the same kernels and this program, small, on a CPU

Cases, all f32: `mpm`, cohesive Cam-Clay in 3-D of which half yields (Z1); `sph`, an elastic block in 3-D; `depth`, a
sheet of columns. `way`: "cuda"; "fine", the kernels of a GPU on a CPU; "packs", those of a CPU, beside it at the
smallest size. Each row has a process of its own.

Columns: ns a particle (or column) and step, median and least of a few rounds, launches and reports included; bytes a
particle, of particles and grid, of `mpm` only; copy_GBps, bytes read and written by a copy in the same process; device.
Last row: `apart`, the largest difference from the CPU's kernels in the scenes of tests/gpu/steps.py, over the largest
number in each. Z1 asks for 1 ns at 1e7 particles.

The kernels are compiled first, small and side by side. Beside FILE is `FILE_kernels.csv`, by Taichi's profiler: each
kernel of a step at the second size, its launches and ns a particle, registers a thread and threads a block.
"""

import argparse
import csv
import json
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve()
sys.path.insert(0, str(HERE.parents[2]))
sys.path.insert(0, str(HERE.parent))

SIZES = {"mpm": [1_000_000, 10_000_000, 50_000_000], "sph": [1_000_000, 7_000_000], "depth": [1_000_000, 10_000_000]}
REHEARSED = {"mpm": [30_000], "sph": [10_000], "depth": [30_000]}
WORK = 4e7
"""Particles times steps of a round."""
ROUNDS = 5
SORTED = 26
"""Steps of a round on a GPU at least: dense snow in motion is sorted after 13, and that belongs to the step."""
TABLE = HERE.parent / "figures" / "gpu.csv"


def solver_of(case, count):
    """Solver of about `count` particles or columns."""
    if case == "mpm":
        from mpm_step import make_solver

        return make_solver("half3", count, "f32", kernel="quadratic", transfer="apic", gradient="affine")
    if case == "sph":
        from sph_step import block

        return block(3, count, bed=False)
    from depth_sizes import sheet

    return sheet(count)


def measured(case, count, way, work):
    """A row of the table, by the Taichi of this process."""
    import taichi as ti
    from mpm_step import machine_limits

    from snowmpm.compiler import runtime
    from snowmpm.running.device import device_name

    backend = runtime.start("cuda" if way == "cuda" else "cpu", threads=1, fine_grained=way == "fine")
    solver = solver_of(case, count)
    n = solver.particles.count
    steps, times = max(SORTED if way == "cuda" else 3, round(work / n)), []
    for _ in range(3):
        solver.step(solver.stable_dt()[0])
    for _ in range(ROUNDS):
        ti.sync()
        began = time.perf_counter()
        for _ in range(steps):
            solver.step(solver.stable_dt()[0])
        ti.sync()
        times.append(1e9 * (time.perf_counter() - began) / steps / n)
    size = solver.particles.bytes_per_particle + solver.grid.bytes / n if case == "mpm" else float("nan")
    return {"case": case, "way": way, "particles": n, "ns": statistics.median(times), "least": min(times),
            "bytes": size, "copy_GBps": machine_limits("f32")[0], "device": device_name(backend, 1)}


def profiled(case, count, way, steps=5):
    """Rows of the kernels of a step, the longest first, by a Taichi that was started with its profiler."""
    from taichi.profiler.kernel_profiler import get_default_kernel_profiler

    from snowmpm.compiler import runtime, settings

    settings.OWN["kernel_profiler"] = True
    runtime.start("cuda" if way == "cuda" else "cpu", threads=1, fine_grained=way == "fine")
    solver = solver_of(case, count)
    for _ in range(3):
        solver.step(solver.stable_dt()[0])
    profiler = get_default_kernel_profiler()
    profiler.clear_info()
    for _ in range(steps):
        solver.step(solver.stable_dt()[0])
    profiler.get_total_time()
    found = {}
    for record in profiler._traced_records:
        row = found.setdefault(record.name, {"case": case, "way": way, "particles": solver.particles.count,
                                             "kernel": record.name, "launches": 0, "ns": 0.0,
                                             "registers": record.register_per_thread, "block": record.block_size})
        row["launches"] += 1 / steps
        row["ns"] += 1e6 * record.kernel_time / steps / row["particles"]
    return sorted(found.values(), key=lambda row: -row["ns"])


def apart(way):
    """Row with the largest difference between this way's kernels and the CPU's."""
    steps, found = HERE.parents[1] / "gpu" / "steps.py", {}
    with tempfile.TemporaryDirectory() as folder:
        for one in ("packs", way):
            path = Path(folder) / f"{one}.npz"
            subprocess.run([sys.executable, str(steps), one, "f32", str(path)], check=True)
            found[one] = dict(np.load(path))
    expected = {name: values for name, values in found["packs"].items() if not name.endswith(("plastic", "paired"))}
    worst = max(np.abs(values - found[way][name]).max() / np.abs(values).max() for name, values in expected.items())
    return {"case": "agreement", "way": way, "apart": float(worst)}


def in_a_process(*arguments, what="--one"):
    """What a process of its own found, or a row that says why it found nothing."""
    ended = subprocess.run([sys.executable, str(HERE), what, *map(str, arguments)], text=True, capture_output=True)
    if ended.returncode:
        case, count, way = arguments[:3]
        said = (ended.stderr.strip() or "nothing said").splitlines()[-1]
        return {"case": case, "way": way, "particles": count, "device": f"failed: {said}"}
    return json.loads(ended.stdout.splitlines()[-1])


def prepared(ways):
    """Row of the agreement, found while the kernels of all ways are compiled."""
    from snowmpm.cores import available_cores

    with ThreadPoolExecutor(available_cores()) as pool:
        agreement = pool.submit(apart, ways[1])
        every = [(case, counts[0], way, 1) for case, counts in REHEARSED.items() for way in ways]
        for row in pool.map(lambda one: in_a_process(*one), every):
            print("compiled", row["case"], row["way"], row["device"], flush=True)
        return agreement.result()


def write(rows, path):
    """Write a table with every column that a row has."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        columns = dict.fromkeys(name for row in rows for name in row)
        table = csv.DictWriter(file, list(columns), restval="", lineterminator="\n")
        table.writeheader()
        table.writerows({name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()}
                        for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rehearse", action="store_true")
    parser.add_argument("--one", nargs=4, metavar=("CASE", "COUNT", "WAY", "WORK"))
    parser.add_argument("--kernels", nargs=3, metavar=("CASE", "COUNT", "WAY"))
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    if options.one:
        case, count, way, work = options.one
        print(json.dumps(measured(case, int(count), way, float(work))))
        return
    if options.kernels:
        case, count, way = options.kernels
        print(json.dumps(profiled(case, int(count), way)))
        return
    from snowmpm.compiler.runtime import _has_cuda

    if not options.rehearse and not _has_cuda():
        sys.exit("no GPU here: --rehearse runs the same on a CPU, small")
    way, sizes, work = ("fine", REHEARSED, 2e5) if options.rehearse else ("cuda", SIZES, WORK)
    output = options.output or (None if options.rehearse else TABLE)
    agreement = prepared(["packs", way])
    rows, kernels = [], []
    for case, counts in sizes.items():
        plan = [(counts[0], "packs"), *((count, way) for count in counts)]
        for count, one in plan:
            rows.append(in_a_process(case, count, one, work if one == way else min(work, 5e6)))
            print(rows[-1], flush=True)
        found = in_a_process(case, counts[:2][-1], way, what="--kernels")
        kernels += found if isinstance(found, list) else [found]
        if output:
            write([*rows, agreement], output)
            write(kernels, output.with_name(f"{output.stem}_kernels.csv"))
    print(agreement, flush=True)
    if any("failed" in str(row.get("device", "")) for row in [*rows, *kernels]):
        sys.exit(1)


if __name__ == "__main__":
    main()
