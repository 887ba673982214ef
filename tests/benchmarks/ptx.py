"""Kernels compiled for CUDA where there is no card: registers, spills, atomics, double precision.

    pip install nvidia-cuda-nvcc nvidia-cuda-nvdisasm     # ptxas and nvdisasm; a C compiler besides
    python tests/benchmarks/ptx.py [-o FILE] [--arch sm_90] [--keep FOLDER] [--case NAME ...]

Taichi is given a driver that has memory and runs no kernel (`no_card/cuda_driver.c`). It compiles what a few steps
launch, and the driver keeps the text (PTX). ptxas, which is part of a card's driver too, makes machine code of it for
`--arch`. Cases: the solvers of `gpu.py` and the scenes of `tests/gpu/steps.py`, in single precision.

A row is a loop of a kernel that runs on more than one thread; `loop` numbers the parts that Taichi makes of a kernel,
serial ones included. `warps`: how many of 64 fit on a multiprocessor by their registers. Counts are of the text (PTX):
what is in a loop of a thread counts once. `pointers` are addresses of arrays, loaded anew for each access; `loaded` and
`stored` are bytes of numbers. `machine`: instructions that ptxas makes of it. `reductions`: the same for a text whose
atomics say that memory is the card's, and give nothing back.

Nothing is timed, and no kernel is known to be right by this: see tests/gpu.
"""

import argparse
import csv
import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TABLE = HERE / "figures" / "ptx.csv"
SOLVERS = ("mpm", "sph", "depth")
PARTICLES = 30_000
STEPS = 2
REGISTERS, WARPS, GRAIN = 65536, 64, 256
"""Of a multiprocessor (compute capability 8.0, 9.0): registers, most warps, registers given to a warp at a time."""
COLUMNS = ("case", "kernel", "loop", "threads", "registers", "stack", "spilled", "warps", "instructions", "machine",
           "reductions", "atomics", "exchanges", "flops", "double", "pointers", "loaded", "stored")

ENTRY = re.compile(r"^\.visible \.entry (\w+)\([^)]*\)[^{]*\{(.*?)^\}", re.M | re.S)
FUNCTION = re.compile(r"^\.func\s+(?:\([^)]*\)\s*)?([\w$]+)\([^)]*\)\s*\{(.*?)^\}", re.M | re.S)
INSTRUCTION = re.compile(r"^\s+(?:@!?%p\d+\s+)?([a-z][\w.]*)\s", re.M)
TASK = re.compile(r"^(\w+?)_c\d+_\d+_kernel_(\d+)_(\w+)$")
OWN_COPIES = re.compile(r"ext_arr_to|ndarray_|fill_ndarray")
"""Taichi's own kernels, between arrays of NumPy and its own."""
PLAIN_ADD = re.compile(r"atom\.add\.(f32|f64)\s+%\w+, \[(%\w+)(?:\+(-?\d+))?\], (%\w+);")


def compile_case(case, folder):
    """In a process of its own, with the driver: build `case`, make some steps. The driver writes to `folder`."""
    from snowmpm.compiler import probe, runtime

    probe.probe = lambda *_: None  # it runs kernels and reads what they found
    np.empty, np.empty_like = np.zeros, np.zeros_like  # what a kernel would have filled is read
    runtime.start("cuda", threads=1)
    if case in SOLVERS:
        import gpu

        solver = gpu.solver_of(case, PARTICLES)
    else:
        import snowmpm
        from tests.gpu.steps import CASES

        scene, changes, _ = CASES[case]
        solver = snowmpm.Simulation(snowmpm.load_scene(scene, {**changes, "solver.precision": "f32"})).solver
    for _ in range(STEPS):
        solver.step(1e-4)


def driver(folder):
    """Path of a folder with the driver, compiled. Raises SystemExit without a C compiler."""
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if not shutil.which(compiler[0]):
        raise SystemExit(f"{compiler[0]}: no such program; a C compiler is needed: cc, or the one that CC names")
    tried([*compiler, "-shared", "-fPIC", "-w", "-o", str(Path(folder) / "libcuda.so"),
           str(HERE / "no_card" / "cuda_driver.c")])
    return Path(folder)


def tried(command):
    """Run a command; -> what it ended with. Raises SystemExit with its last words where it fails."""
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode:
        raise SystemExit(f"{Path(command[0]).name}: {ended.stderr.strip()[-2000:]}")
    return ended


def tool(name):
    """Path of ptxas or nvdisasm: of the installed wheel, or on PATH; None without."""
    found = importlib.util.find_spec("nvidia")
    inside = [file for place in (found.submodule_search_locations if found else ()) for file in
              sorted(Path(place).glob(f"*/bin/{name}"))]
    return str(inside[-1]) if inside else shutil.which(name)


def texts_of(case, libraries, folder):
    """{name of a file: PTX} of all kernels that a case launches, and {kernel: threads a block}."""
    folder.mkdir(parents=True, exist_ok=True)
    surroundings = {**os.environ, "PTX_FOLDER": str(folder), "TI_OFFLINE_CACHE_FILE_PATH": str(folder / "cache"),
                    "LD_LIBRARY_PATH": os.pathsep.join([str(libraries), os.environ.get("LD_LIBRARY_PATH", "")]),
                    "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    ended = subprocess.run([sys.executable, "-W", "ignore", str(HERE / "ptx.py"), "--compile", case, str(folder)],
                           env=surroundings, capture_output=True, text=True)
    if ended.returncode:
        raise SystemExit(f"{case}: {ended.stderr.strip()[-2000:]}")
    threads = {name: int(count) for name, _, count in map(str.split, (folder / "launches").open(encoding="ascii"))}
    return {file.name: file.read_text(encoding="ascii") for file in sorted(folder.glob("*.ptx"))}, threads


def counted(body, functions):
    """Counts of the instructions of a kernel and of the functions that it calls."""
    called = [name for name in functions if name in body]
    text = "\n".join([body, *(functions[name] for name in called)])
    found = Counter(op for op in INSTRUCTION.findall(text) if not op.startswith("."))
    pointers = len(re.findall(r"^\s+ld(?:\.global)?\.u64", text, re.M))

    def number(start, *ends):
        return sum(count for op, count in found.items() if re.match(start, op) and (not ends or op.endswith(ends)))

    def bytes_of(start):
        wide = {"32": 4, "64": 8, "u8": 1, "s8": 1, "16": 2}
        return sum(count * next(size for end, size in wide.items() if op.endswith(end))
                   for op, count in found.items() if re.match(start, op) and ".param" not in op and ".local" not in op)

    single = Counter({op: count for op, count in found.items() if op.endswith("f32") and not op.startswith("cvt")})
    flops = sum(count * (2 if op.startswith("fma") else 1) for op, count in single.items()
                if re.match(r"fma|add|sub|mul|div|rcp|sqrt|rsqrt|ex2|lg2|sin|cos", op))
    double = sum(count for op, count in found.items() if op.endswith("f64")
                 and re.match(r"fma|add|sub|mul|div|rcp|sqrt|rsqrt", op))
    return {"instructions": sum(found.values()), "atomics": number(r"(atom|red)\..*add"),
            "exchanges": number(r"atom\..*cas"), "flops": flops, "double": double, "pointers": pointers,
            "loaded": bytes_of(r"ld\.") - 8 * pointers, "stored": bytes_of(r"st\.")}


def known_memory(ptx):
    """The same text with sums to memory that is said to be the card's, which gives nothing back."""
    return PLAIN_ADD.sub(lambda m: f"{{ .reg .u64 a; add.u64 a, {m[2]}, {m[3] or 0}; cvta.to.global.u64 a, a;"
                                   f" red.global.add.{m[1]} [a], {m[4]}; }}", ptx)


def assembled(ptx, arch, folder):
    """{kernel: registers, stack, spilled bytes} by ptxas, and {kernel: machine instructions} by nvdisasm."""
    source, code = folder / "one.ptx", folder / "one.cubin"
    source.write_text(ptx, encoding="ascii")
    said = tried([tool("ptxas"), "-v", f"-arch={arch}", str(source), "-o", str(code)]).stderr
    found = {}
    for name, rest in re.findall(r"Compiling entry function '(\w+)'(.*?)(?=Compiling entry|\Z)", said, re.S):
        stack, *spilled = map(int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill.*?(\d+)", rest).groups())
        found[name] = {"registers": int(re.search(r"Used (\d+) registers", rest)[1]), "stack": stack,
                       "spilled": sum(spilled)}
    parts = re.split(r"^//-+ \.text\.", tried([tool("nvdisasm"), str(code)]).stdout, flags=re.M)[1:]
    return found, {re.match(r"[\w$]+", part)[0]: len(re.findall(r"^\s+/\*[0-9a-f]{4,}\*/", part, re.M))
                   for part in parts}


def resident(registers, threads):
    """Warps of a kernel that fit on a multiprocessor by their registers."""
    each = -(-registers * 32 // GRAIN) * GRAIN
    block = -(-threads // 32)
    return min(WARPS, REGISTERS // each) // block * block


def rows_of(case, libraries, arch, keep):
    """Rows of a case, by kernel and loop."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(keep) / re.sub(r"\W+", "_", case) if keep else Path(folder) / "texts"
        texts, threads = texts_of(case, libraries, place)
        rows = []
        for ptx in texts.values():
            bare = re.sub(r"//.*", "", ptx)
            functions = dict(FUNCTION.findall(bare))
            entries = [(name, body) for name, body in ENTRY.findall(bare) if name in threads and threads[name] > 1]
            entries = [one for one in entries if (task := TASK.match(one[0])) and not OWN_COPIES.match(task[1])]
            if not entries:
                continue
            found, machine = assembled(ptx, arch, Path(folder))
            _, reduced = assembled(known_memory(ptx), arch, Path(folder))
            for name, body in entries:
                kernel, loop, _ = TASK.match(name).groups()
                rows.append({"case": case, "kernel": kernel, "loop": int(loop), "threads": threads[name], **found[name],
                             "warps": resident(found[name]["registers"], threads[name]),
                             "machine": machine[name], "reductions": reduced[name],
                             **counted(body, functions)})
    return sorted(rows, key=lambda row: (row["kernel"], row["loop"]))


def main():
    from tests.gpu.steps import CASES

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--compile", nargs=2, metavar=("CASE", "FOLDER"), help=argparse.SUPPRESS)
    parser.add_argument("--case", nargs="+", choices=[*SOLVERS, *CASES], default=[*SOLVERS, *CASES], metavar="NAME")
    parser.add_argument("--arch", default="sm_90", help="of the machine code; sm_90 by default, as of an H100 or H200")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where the texts of the kernels are kept")
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    options = parser.parse_args()
    if options.compile:
        compile_case(*options.compile)
        return
    if missing := [name for name in ("ptxas", "nvdisasm") if not tool(name)]:
        parser.error(f"{', '.join(missing)}: not found; pip install nvidia-cuda-nvcc nvidia-cuda-nvdisasm")
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        libraries = driver(folder)
        found = pool.map(lambda case: rows_of(case, libraries, options.arch, options.keep), options.case)
        rows = [row for some in found for row in some]
    with options.output.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    for row in rows:
        print(" ".join(f"{row[name]!s:>9s}" for name in COLUMNS))


if __name__ == "__main__":
    sys.path[:0] = [str(ROOT), str(HERE)]
    main()
