"""How far a sheet of snow runs by friction alone, beside a depth-averaged program: error and time, CSV and PNG.

    python tests/benchmarks/run_out_peers.py --avaframe PYTHON [-o FOLDER]

The ground of `energy_line`: a slope of 20 degrees, an arc, the flat; Coulomb friction 0.2. Exact: the way of a mass
point, which has no scale. snowmpm solves it as the problem has it, a strip of 1.5 m in plane strain, 0.2 m thick;
AvaFrame's com1DFA at twenty times the size, a sheet of 30 m by 40 m, 1 m thick, on a raster, at its defaults but for
the friction. AvaFrame is installed from its registry into an environment of its own (`pip install avaframe`). Error: of
the mean way of all particles. Times are processor seconds of the steps on one thread.
"""

import argparse
import csv
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import shapefile

from snowmpm.compiler import runtime
from snowmpm.render.work_precision_plot import Curve, Panel, render_work_precision
from snowmpm.study.measurement import measure
from snowmpm.study.problems.catalogue import CATALOGUE
from snowmpm.study.problems.energy_line import DIP, LONG, MU, SLOPE, HockeyStick, exact_way
from snowmpm.study.variation import BY_NAME

HERE = Path(__file__).parent
COLUMNS = ("program", "choice", "cells", "particles", "steps", "seconds", "error")
SCALE, WIDE = 20.0, 40.0
"""Of AvaFrame's ground over that of the problem; width of its sheet [m]."""
CELLS = (10.0, 5.0, 2.5)
"""Of AvaFrame's raster [m]."""
OWN = ("program", "C = 0.4")


def own_rows():
    problem = CATALOGUE["energy_line"]
    for name in OWN:
        for cells in problem.cells:
            row = measure(problem, BY_NAME[name], cells)
            yield dict(zip(COLUMNS, ("snowmpm, plane strain", name, cells, row.particles, row.steps, row.seconds,
                                     row.error), strict=True))


def write_ground(folder, cell):
    """The raster and the release polygon as AvaFrame wants them."""
    ground, rows = HockeyStick(), round(4.0 * WIDE / cell)
    top = ground.start - SLOPE * ground.along
    x = np.arange(SCALE * top[0] - 4.0 * cell, SCALE * 14.0, cell)
    line = " ".join(f"{z:.4f}" for z in SCALE * ground.height(x / SCALE))
    (folder / "Inputs" / "REL").mkdir(parents=True)
    (folder / "Inputs" / "dem.asc").write_text(
        f"ncols {len(x)}\nnrows {rows}\nxllcenter {x[0]}\nyllcenter 0\ncellsize {cell}\nNODATA_value -9999\n"
        + (line + "\n") * rows)
    low, high = SCALE * top[0], SCALE * (top[0] + LONG * np.cos(DIP))
    with shapefile.Writer(str(folder / "Inputs" / "REL" / "release.shp"), shapeType=shapefile.POLYGON) as writer:
        writer.field("name", "C")
        corners = [(low, 1.5), (low, 2.5), (high, 2.5), (high, 1.5), (low, 1.5)]
        writer.poly([[[a, b * WIDE] for a, b in corners]])
        writer.record("release")


def avaframe_row(interpreter, cell):
    """Row of AvaFrame on a raster of `cell` [m]. Raises RuntimeError when it does not run."""
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    with tempfile.TemporaryDirectory() as folder:
        write_ground(Path(folder), cell)
        done = subprocess.run([interpreter, str(HERE / "peers" / "avaframe_line.py"), folder, f"{MU:g}", f"{cell:g}"],
                              capture_output=True, text=True, env={**os.environ, **one, "PYTHONPATH": ""}, check=False)
    told = [line[4:] for line in done.stdout.splitlines() if line.startswith("ROW ")]
    if not told:
        raise RuntimeError(f"avaframe: {done.stderr.strip()[-400:]}")
    found, ground = json.loads(told[0]), HockeyStick()
    begin, end = (np.mean(ground.way(np.column_stack([x, ground.height(x)]))) for x in (
        np.array(found[when]) / SCALE for when in ("begin", "end")))
    error = (end - begin) / (exact_way(begin, 0.0) - begin) - 1.0
    return dict(zip(COLUMNS, ("AvaFrame com1DFA", "depth-averaged", cell, len(found["begin"]), found["steps"],
                              float(f"{found['seconds']:.4g}"), float(f"{abs(error):.4g}")), strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures", help="folder")
    parser.add_argument("--avaframe", metavar="PYTHON", required=True, help="interpreter that has AvaFrame")
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    rows = [*own_rows(), *(avaframe_row(options.avaframe, cell) for cell in CELLS)]
    with open(options.output / "run_out_peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    curves = []
    for program, choice in dict.fromkeys((row["program"], row["choice"]) for row in rows):
        line = [row for row in rows if (row["program"], row["choice"]) == (program, choice)]
        curves.append(Curve(f"{program}, {choice}", program, tuple(row["seconds"] for row in line),
                            tuple(row["error"] for row in line)))
    panel = Panel("way of a sheet of snow to its stop, friction 0.2", tuple(curves))
    render_work_precision([panel], options.output / "run_out_peers.png", columns=1, size=(7.5, 4.8), legend_columns=2,
                          x_label="processor seconds of all steps, one thread", title="Beside a depth-averaged program")
    for row in rows:
        print(" ".join(f"{row[name]!s:>22s}" for name in COLUMNS))


if __name__ == "__main__":
    main()
