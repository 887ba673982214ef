"""The same depth-averaged avalanche by three programs, one thread each: run-out, peaks, processor seconds.

    python tests/benchmarks/depth_peers.py DATA [--mot BINARY] [--rcf FILE] [--avaframe PYTHON] [--runs 3] [-o FOLDER]

DATA: ISeeSnow's cases (tests/benchmarks/iseesnow.py); the case is CoulombOnly on its 5 m raster. MoT-Voellmy is a
binary that was compiled from its source (cc -O3), FILE its run for this case; AvaFrame is installed in an environment
of its own (`pip install avaframe`). Seconds are processor seconds of whole programs, imports and files included, the
median of several runs in turn; of ours also those of the steps alone.
"""

import argparse
import csv
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import rasterio

import snowmpm

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support import iseesnow

HERE = Path(__file__).parent
CASE = "CoulombOnly"
ONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def spent(command, strict=True, **options):
    """Processor seconds of a command, and what it said. Raises RuntimeError when it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False,
                          env={**os.environ, **ONE}, **options)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode and strict:
        raise RuntimeError(f"{command[0]}: {(done.stderr.strip() or done.stdout.strip())[-400:]}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def ours(data, folder):
    scene = folder / "scene.toml"
    scene.write_text(iseesnow.scene(data, CASE).to_toml())
    seconds, _ = spent([sys.executable, "-m", "snowmpm", "run", scene, "-o", folder / "ours", "--overwrite",
                        "--threads", 1])
    run = snowmpm.open_run(folder / "ours")
    return {"seconds": seconds, "steps_seconds": run.summary["wall_time_of"]["steps"],
            "particle_steps": run.summary["particle_steps"], **iseesnow.of_run(data, CASE, run)}


def from_grids(data, speed, depth):
    values = []
    for path in (speed, depth):
        with rasterio.open(path) as file:
            values.append(np.nan_to_num(file.read(1), posinf=0.0, neginf=0.0))
            x = file.transform.c + (np.arange(file.width) + 0.5) * file.transform.a
            y = file.transform.f + (np.arange(file.height) + 0.5) * file.transform.e
    v, h = (np.where(value > 0.0, value, 0.0) for value in values)
    return iseesnow.numbers(iseesnow.thalweg(data, CASE), x, y, v, h)


def mot(binary, rcf, data, folder):
    """MoT-Voellmy in a folder with its rasters, whose headers name corners instead of centres."""
    inputs, here = data / CASE / "Inputs", folder / "mot"
    here.mkdir(exist_ok=True)
    for name in (f"DEM_{CASE}.asc", "release1HSField5m.asc"):
        lines = (inputs / name).read_text().splitlines()
        head = {line.split()[0].lower(): line.split()[1] for line in lines[:6]}
        head["NODATA_value"] = "-9999"
        for axis in "xy":
            if f"{axis}llcenter" in head:
                corner = float(head.pop(f"{axis}llcenter")) - 0.5 * float(head["cellsize"])
                head[f"{axis}llcorner"] = f"{corner:.6f}"
        names = ("ncols", "nrows", "xllcorner", "yllcorner", "cellsize", "NODATA_value")
        (here / name).write_text("\n".join([f"{key} {head[key]}" for key in names] + lines[6:]) + "\n")
    out = here / "Results"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    lines = [f"Output filename root                    {out}/run" if line.startswith("Output filename root")
             else line for line in Path(rcf).read_text().splitlines()]
    (here / "run.rcf").write_text("\n".join(lines) + "\n")
    seconds, _ = spent([Path(binary).resolve(), "run.rcf"], strict=False, cwd=here)
    # Not strict: it ends with a code of its own when the snow rests
    found = {kind: next(out.rglob(f"*{kind}*.asc")) for kind in ("s_max", "h_max")}
    return {"seconds": seconds, **from_grids(data, found["s_max"], found["h_max"])}


def avaframe(python, data, folder):
    inputs, here = data / CASE / "Inputs", folder / "ava"
    shutil.rmtree(here, ignore_errors=True)
    (here / "Inputs" / "REL").mkdir(parents=True)
    shutil.copy(inputs / f"DEM_{CASE}.asc", here / "Inputs" / "dem.asc")
    for file in inputs.glob("release1HS.*"):
        shutil.copy(file, here / "Inputs" / "REL" / f"release{file.suffix}")
    seconds, said = spent([python, HERE / "peers" / "avaframe_path.py", here, "0.4", "5"], cwd=folder)
    told = json.loads(next(line[4:] for line in said.splitlines() if line.startswith("ROW ")))
    found = {kind: next(path for path in told["peaks"] if kind in path) for kind in ("pfv", "pft")}
    return {"seconds": seconds, "steps_seconds": told["seconds"], **from_grids(data, found["pfv"], found["pft"])}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--mot")
    parser.add_argument("--rcf")
    parser.add_argument("--avaframe")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    data = options.data.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs = {"snowmpm depth": lambda: ours(data, folder)}
        if options.mot:
            programs["MoT-Voellmy"] = lambda: mot(options.mot, options.rcf, data, folder)
        if options.avaframe:
            programs["AvaFrame com1DFA"] = lambda: avaframe(options.avaframe, data, folder)
        found = {program: [] for program in programs}
        for _ in range(options.runs):
            for program, run in programs.items():
                found[program].append(run())
    rows = []
    for program, several in found.items():
        row = {"program": program, **several[-1]}
        for key in ("seconds", "steps_seconds"):
            if key in row:
                row[key] = statistics.median(one[key] for one in several)
        rows.append({key: round(value, 4) if isinstance(value, float | np.floating) else value
                     for key, value in row.items()})
    keys = list(dict.fromkeys(key for row in rows for key in row))
    with open(options.output / "depth_peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, keys)
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()
