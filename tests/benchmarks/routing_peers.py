"""Routing beside com4FlowPy of AvaFrame 2.1: `python tests/benchmarks/routing_peers.py PYTHON RASTER RELEASE ...`

PYTHON: of an environment with avaframe; RASTER, RELEASE: pairs of an elevation raster and polygons. 40 cells of each
release on cells of 10 m, 25 degrees, exponent 8, by both. Writes figures/routing_peers.csv.
"""

import csv
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import shapely

from snowmpm.compiler import runtime
from snowmpm.runout.routing import Routing, route
from snowmpm.seeding.regions import read_regions
from snowmpm.terrain.raster import read_raster

CELL, CELLS = 10.0, 40
THEIRS = """
import sys, time, numpy as np
from avaframe.com4FlowPy import flowCore
case = np.load(sys.argv[1])
no = dict(varUmaxBool=False, varUmaxArray=None, varAlphaBool=False, varAlphaArray=None, varExponentBool=False,
          varExponentArray=None)
names = ["zDelta", "flux", "cellCounts", "travelLengthMax", "fpTravelAngleMax", "zDeltaSum", "routFluxSum",
         "depFluxSum", "fpTravelAngleMin", "travelLengthMin", "slTravelAngle"]
started = time.time()
found = flowCore.calculation([np.where(np.isnan(case["z"]), -9999, case["z"]), None, case["release"].astype(int), 25.0,
                              8, 3e-4, 8848.0, -9999, 10.0, False, False, no, False, False, None, None, names,
                              dict(relIdArray=None, relIdBool=False)])
np.savez(sys.argv[2], energy=found[0], cells=found[2], length=found[7], seconds=time.time() - started)
"""


def main(python, *files):
    runtime.start("cpu", 2)
    rows = []
    for raster, release in zip(files[::2], files[1::2], strict=True):
        with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
            warnings.simplefilter("ignore")
            ground = read_raster(raster)
            step = max(1, round(CELL / (ground.x[1] - ground.x[0])))
            z = ground.z[::step, ::step]
            x, y = np.meshgrid(ground.x[::step], ground.y[::step])
            area = shapely.union_all([one.polygons.geometry for one in read_regions(release, "release", ground.system)])
            cells = np.argwhere(shapely.contains_xy(area, x, y))
            cells = cells[:: max(1, len(cells) // CELLS)]
            marks = np.zeros(z.shape, bool)
            marks[tuple(cells.T)] = True
            case, answer = Path(folder, "case.npz"), Path(folder, "answer.npz")
            np.savez(case, z=z, release=marks)
            subprocess.run([python, "-c", THEIRS, case, answer], check=True, cwd=folder)
            theirs = dict(np.load(answer))
        row = {"terrain": Path(raster).stem, "release_cells": len(cells), "seconds_flow_py": f"{theirs['seconds']:.1f}",
               "longest_flow_py_m": f"{theirs['length'].max():.1f}", "cells_flow_py": int((theirs["cells"] > 0).sum())}
        for name, straight in (("steps", False), ("straight", True)):
            route(z, CELL, cells[:1], Routing(straight=straight))
            started = time.perf_counter()
            own = route(z, CELL, cells, Routing(straight=straight), lists=2)
            took, here, there = time.perf_counter() - started, np.isfinite(own.energy), theirs["cells"] > 0
            both = here & there
            row |= {f"seconds_{name}": f"{took:.2f}", f"cells_{name}": int(here.sum()),
                    f"longest_{name}_m": f"{np.nanmax(own.length):.1f}",
                    f"common_area_{name}": f"{both.sum() / (here | there).sum():.4f}",
                    f"energy_difference_{name}_m":
                        f"{np.sqrt(np.mean((own.energy[both] - theirs['energy'][both]) ** 2)):.3f}"}
        rows.append(row)
        print(row, flush=True)
    output = Path(__file__).parent / "figures" / "routing_peers.csv"
    with output.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
