"""The same problem by other programs on the same machine: error and time on one chart, CSV and PNG.

    python tests/benchmarks/peers.py [-o FOLDER] [--newton PYTHON] [--pysph PYTHON] [--grids 3] [--repeat 1] [--draw]

The free bar of `peers/free_bar.py`, solved in this run by snowmpm and by every peer whose interpreter is given, each
installed from its registry into an environment of its own:

    python -m venv newton && newton/bin/pip install newton          # implicit MPM on Warp, here on its CPU device
    python -m venv pysph && pysph/bin/pip install numpy cython setuptools pysph      # needs a C++ compiler to run
    python tests/benchmarks/peers.py --newton newton/bin/python --pysph pysph/bin/python

A peer that is not given, or does not start, is left out; `--draw` draws the table that is there. Times are processor
seconds of the steps on one thread, without set-up and compilation, the least over `--repeat` runs.

What the programs are for differs: Newton takes long implicit steps in 3-D and damps by them, which stiff granular
scenes want and a wave does not; PySPH's scheme for solids damps by artificial viscosity; both run as their examples do.
"""

import argparse
import csv
import itertools
import json
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.materials import Elastic
from snowmpm.render.work_precision_plot import Curve, Panel, render_work_precision
from snowmpm.running.device import device_name
from snowmpm.study.measurement import TimedScheme
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, free_solver

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "peers"))
import free_bar  # noqa: E402

PEERS = {"newton": "newton_bar.py", "pysph": "pysph_bar.py"}
COLUMNS = ("program", "choice", "dimension", "cells", "particles", "steps", "seconds", "error")
OWN = {"quadratic": Scheme("apic", precision="f32", cfl=0.4),
       "cubic": Scheme("apic", kernel="cubic", precision="f32", cfl=0.4),
       "SPH": Scheme("apic", method="sph", precision="f32", cfl=0.3)}
"""Choices of snowmpm."""


def own_rows(grids):
    """Rows of snowmpm: the program's own choice and cubic splines, in plane strain and 3-D."""
    law = Elastic(density=free_bar.DENSITY, youngs_modulus=free_bar.YOUNGS_MODULUS, poisson_ratio=0.0)
    for (choice, scheme), dim, cells in itertools.product(OWN.items(), (2, 3), free_bar.CELLS[:grids]):
        dx = free_bar.LENGTH / cells
        x = free_bar.lattice(0.5 * dx, dim)
        velocities = np.zeros_like(x)
        velocities[:, 0] = free_bar.start(x[:, 0])
        timed = TimedScheme(**{field.name: getattr(scheme, field.name) for field in fields(scheme)})
        volumes = np.full(len(x), (0.5 * dx) ** dim)
        solver = free_solver(x, volumes, law, timed, dx, velocities=velocities, reach=4 * dx)
        states = ParticleStates(solver)
        wide = 0.5 * dx if scheme.method == "sph" else dx
        steps = int(np.ceil(free_bar.PERIOD * free_bar.SPEED / (scheme.cfl * wide)))
        for _ in range(steps):
            solver.step(free_bar.PERIOD / steps)
        found = free_bar.error(states.reference[:, 0], states.column("velocity")[:, 0])
        yield dict(zip(COLUMNS, ("snowmpm", choice, dim, cells, len(x), steps,
                                 float(f"{timed.watch.seconds:.4g}"), float(f"{found:.4g}")), strict=True))


def peer_rows(name, interpreter, grids):
    """Rows that a peer's script prints, run by its own interpreter; none, with a word, when it does not start."""
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run([interpreter, str(HERE / "peers" / PEERS[name]), str(grids)], capture_output=True, text=True,
                          env={**os.environ, **one, "PYTHONPATH": ""}, check=False)
    if done.returncode:
        print(f"{name}: left out: {(done.stderr.strip().splitlines() or ['no word'])[-1]}", file=sys.stderr)
    return [json.loads(line[4:]) for line in done.stdout.splitlines() if line.startswith("ROW ")]


def least(rows):
    """One row of each choice and grid, with its least time."""
    best = {}
    for row in rows:
        key = row["program"], row["choice"], row["dimension"], row["cells"]
        if key not in best or row["seconds"] < best[key]["seconds"]:
            best[key] = row
    return list(best.values())


def draw(rows, file, machine):
    """Error against time, a line a choice."""
    curves = []
    for key, line in itertools.groupby(rows, key=lambda row: (row["program"], row["choice"], row["dimension"])):
        program, choice, dim = key
        line = sorted(line, key=lambda row: int(row["cells"]))
        curves.append(Curve(f"{program}, {choice}, {dim}-D", program, tuple(float(row["seconds"]) for row in line),
                            tuple(float(row["error"]) for row in line)))
    panel = Panel("free elastic bar after one period, 10, 20, 40 cells long", tuple(curves))
    render_work_precision([panel], file, x_label=f"processor seconds of all steps, one thread{machine}",
                          title="The same problem by other programs", columns=1, size=(8.0, 5.6), legend_columns=2)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures", help="folder")
    for name in PEERS:
        parser.add_argument(f"--{name}", metavar="PYTHON", help=f"interpreter that has {name}")
    parser.add_argument("--grids", type=int, default=3, choices=(1, 2, 3))
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--draw", action="store_true", help="only draw the table that is there")
    options = parser.parse_args()
    table = options.output / "peers.csv"
    if options.draw:
        with open(table, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    else:
        runtime.start("cpu", threads=1)
        rows = measured(options)
        with open(table, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    draw(rows, options.output / "peers.png", "")
    for row in rows:
        print(" ".join(f"{row[name]!s:>18s}" for name in COLUMNS))
    print(device_name("cpu", 1))


def measured(options):
    rows = []
    for _ in range(options.repeat):
        rows += own_rows(options.grids)
        for name in PEERS:
            interpreter = getattr(options, name)
            rows += peer_rows(name, interpreter, options.grids) if interpreter else []
    return least(rows)


if __name__ == "__main__":
    main()
