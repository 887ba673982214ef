"""The same depth-averaged avalanche by three programs, ours by both schemes, one thread each: run-out, peaks, processor
seconds.

    python tests/benchmarks/depth_peers.py DATA [--mot BINARY] [--rcf FILE] [--avaframe PYTHON] [--runs 3]
                                           [--cells 5] [-o FOLDER]

DATA: ISeeSnow's cases (tests/benchmarks/iseesnow.py); the case is CoulombOnly on its 5 m raster. MoT-Voellmy is a
binary that was compiled from its source (cc -O3), FILE its run for this case; AvaFrame is installed in an environment
of its own (`pip install avaframe`). Seconds are processor seconds of whole programs, imports and files included, the
median of several runs in turn; of ours also those of the steps alone. Writes depth_peers.csv.

Several cells, such as `--cells 20 10 5 2.5`, give error against seconds: depth_peers_cells.csv and .png. The error of
a program is the mean of the relative differences of run-out, areas above 1 m/s and above 0.1 m, and 95th percentiles
of peak speed and depth from its own run on the finest cells. So it is that of the numbers, not of the model: the
programs do not solve the same equations. MoT-Voellmy gets the elevation model linearly interpolated, and the release of
the nearest cell; com1DFA makes its own; ours takes the 5 m raster with any cell, and maps on cells of 5 m or more.
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

import matplotlib
import numpy as np
import rasterio
from scipy import ndimage

import snowmpm

matplotlib.use("Agg")
from matplotlib import pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support import iseesnow

HERE = Path(__file__).parent
CASE = "CoulombOnly"
COMPARED = ("runout", "speed_area", "depth_area", "speed_95", "depth_95")
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


def ours(data, folder, cell, scheme):
    scene, output = folder / "scene.toml", {"interval": 10.0, "map_cell": max(5.0, cell)}
    solver = {"method": "depth", "dx": cell, "depth": {"scheme": scheme}}
    scene.write_text(iseesnow.scene(data, CASE, cell, output=output, solver=solver).to_toml())
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


def on_cells(path, cell, order):
    """Values of a raster on square cells of another size [m] over the same rectangle, and its lower left corner."""
    with rasterio.open(path) as file:
        values, size, bounds = file.read(1), file.transform.a, file.bounds
    columns, rows = (round((high - low) / cell) for low, high in ((bounds.left, bounds.right),
                                                                  (bounds.bottom, bounds.top)))
    places = [(np.arange(n) + 0.5) * cell / size - 0.5 for n in (rows, columns)]
    found = ndimage.map_coordinates(values, np.meshgrid(*places, indexing="ij"), order=order, mode="nearest")
    return found, (bounds.left, bounds.top - rows * cell)


def mot(binary, rcf, data, folder, cell):
    """MoT-Voellmy in a folder with its rasters, whose headers name corners instead of centres."""
    inputs, here = data / CASE / "Inputs", folder / "mot"
    here.mkdir(exist_ok=True)
    for name, order in ((f"DEM_{CASE}.asc", 1), ("release1HSField5m.asc", 0)):
        values, corner = on_cells(inputs / name, cell, order)
        head = {"ncols": values.shape[1], "nrows": values.shape[0], "xllcorner": f"{corner[0]:.6f}",
                "yllcorner": f"{corner[1]:.6f}", "cellsize": cell, "NODATA_value": -9999}
        np.savetxt(here / name, values, "%.4f", header="\n".join(f"{key} {value}" for key, value in head.items()),
                   comments="")
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


def avaframe(python, data, folder, cell):
    inputs, here = data / CASE / "Inputs", folder / "ava"
    shutil.rmtree(here, ignore_errors=True)
    (here / "Inputs" / "REL").mkdir(parents=True)
    shutil.copy(inputs / f"DEM_{CASE}.asc", here / "Inputs" / "dem.asc")
    for file in inputs.glob("release1HS.*"):
        shutil.copy(file, here / "Inputs" / "REL" / f"release{file.suffix}")
    seconds, said = spent([python, HERE / "peers" / "avaframe_path.py", here, "0.4", cell], cwd=folder)
    told = json.loads(next(line[4:] for line in said.splitlines() if line.startswith("ROW ")))
    found = {kind: next(path for path in told["peaks"] if kind in path) for kind in ("pfv", "pft")}
    return {"seconds": seconds, "steps_seconds": told["seconds"], **from_grids(data, found["pfv"], found["pft"])}


def write(rows, path):
    """Rows of numbers as a table; prints them too."""
    rows = [{key: round(value, 4) if isinstance(value, float | np.floating) else value for key, value in row.items()}
            for row in rows]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(row)


def with_errors(rows):
    """The rows, each with its error against the same program on its finest cells."""
    for row in rows:
        finest = min((other for other in rows if other["program"] == row["program"]), key=lambda other: other["cell"])
        if finest is not row:
            row["error"] = statistics.mean(abs(float(row[key]) / float(finest[key]) - 1.0) for key in COMPARED)
    return rows


def draw(rows, path):
    figure, axis = plt.subplots(figsize=(7, 5), constrained_layout=True)
    for program in dict.fromkeys(row["program"] for row in rows):
        own = [row for row in rows if row["program"] == program and "error" in row]
        line = axis.loglog([row["seconds"] for row in own], [row["error"] for row in own], "o-", label=program)
        for row in own:
            axis.annotate(f"{row['cell']:g} m", (row["seconds"], row["error"]), xytext=(6, 4),
                          textcoords="offset points", fontsize=8, color=line[0].get_color())
    axis.set(xlabel="processor seconds of the whole run, one thread",
             ylabel="mean relative difference from the own run on the finest cells", title=CASE)
    axis.grid(which="both", alpha=0.3)
    axis.legend()
    figure.savefig(path, dpi=80)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--mot")
    parser.add_argument("--rcf")
    parser.add_argument("--avaframe")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--cells", type=float, nargs="+", default=[5.0], help="[m]")
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    data = options.data.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        programs = {f"snowmpm, {scheme}": lambda cell, scheme=scheme: ours(data, folder, cell, scheme)
                    for scheme in ("volumes", "columns")}
        if options.mot:
            programs["MoT-Voellmy"] = lambda cell: mot(options.mot, options.rcf, data, folder, cell)
        if options.avaframe:
            programs["AvaFrame com1DFA"] = lambda cell: avaframe(options.avaframe, data, folder, cell)
        found = {(program, cell): [] for program in programs for cell in options.cells}
        for _ in range(options.runs):
            for (program, cell), several in found.items():
                several.append(programs[program](cell))
    rows = []
    for (program, cell), several in found.items():
        row = {"program": program, "cell": cell, **several[-1]}
        for key in ("seconds", "steps_seconds"):
            if key in row:
                row[key] = statistics.median(one[key] for one in several)
        rows.append(row)
    if len(options.cells) == 1:
        write(rows, options.output / "depth_peers.csv")
    else:
        write(with_errors(rows), options.output / "depth_peers_cells.csv")
        draw(rows, options.output / "depth_peers_cells.png")


if __name__ == "__main__":
    main()
