"""The same problems by other programs on the same machine in one run: error and time, CSV and PNG.

    python tests/benchmarks/peers.py [-o FOLDER] [--newton PYTHON] [--pysph PYTHON] [--geotaichi PYTHON SOURCES]
                                     [--matter SOURCES] [--problems bar sand] [--grids 3] [--repeat 1] [--draw]

Two problems: the free bar of `peers/free_bar.py`, which has an exact answer, and the slice of sand of
`peers/sand_slice.py`, by snowmpm and matter, which have its law. Each is solved by snowmpm and by every peer that is
given, in an environment or a checkout of its own:

    python -m venv newton && newton/bin/pip install newton          # implicit MPM on Warp, here on its CPU device
    python -m venv pysph && pysph/bin/pip install numpy cython setuptools pysph      # needs a C++ compiler to run
    git clone https://github.com/Yihao-Shi/GeoTaichi && python -m venv geo
    geo/bin/pip install taichi==1.7.4 scipy "trimesh<5" imageio matplotlib psutil pynvml shapely meshio rtree \
        scikit-image pybind11
    git clone https://github.com/larsblatny/matter                  # C++17, OpenMP and Eigen 3
    python tests/benchmarks/peers.py --newton newton/bin/python --pysph pysph/bin/python \
        --geotaichi geo/bin/python GeoTaichi --matter matter

A peer that is not given, or fails, is left out; `--draw` draws the tables that are there. Times are processor seconds
of the steps on one thread, without set-up and compilation, the least over `--repeat` runs: the median step times their
number, or all steps of matter, which compiles nothing meanwhile. Each program in the precision that is its default.

What the programs are for differs: Newton takes long implicit steps in 3-D and damps by them, which stiff granular
scenes want and a wave does not; PySPH's scheme for solids damps by artificial viscosity.
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
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import Scene
from snowmpm.study.measurement import TimedScheme
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, free_solver

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "peers"))
import free_bar  # noqa: E402
import sand_slice  # noqa: E402

PEERS = {"newton": "newton_bar.py", "pysph": "pysph_bar.py", "geotaichi": "geotaichi_bar.py", "matter": "matter_bar.py"}
SAND = {"matter": "matter_sand.py"}
"""Peers that solve the second problem."""
SAND_COLUMNS = ("program", "choice", "cells", "particles", "steps", "seconds", "middle", "front")
COLUMNS = ("program", "choice", "dimension", "cells", "particles", "steps", "seconds", "error")
OWN = {"APIC, quadratic": Scheme("apic", precision="f32", cfl=0.4),
       "0.95 AFLIP, quadratic": Scheme("aflip", 0.95, precision="f32", cfl=0.4),
       "APIC, cubic": Scheme("apic", kernel="cubic", precision="f32", cfl=0.4),
       "SPH": Scheme("apic", method="sph", precision="f32", cfl=0.3)}
"""Choices of snowmpm."""
OWN_SAND = {"as it chooses": {}, "0.95 AFLIP": {"transfer": "aflip", "flip_ratio": 0.95}, "APIC": {"transfer": "apic"}}
"""Choices of snowmpm for sand."""
FINEST = 30
"""Cells over the height of the slice on which snowmpm alone computes it, as it chooses."""


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


def sand_scene(cells, changes):
    """The slice of sand as a `Scene`: x along the slope, z away from it."""
    dx, slope = sand_slice.HEIGHT / cells, np.deg2rad(sand_slice.SLOPE)
    alpha = np.sqrt(3.0) * np.tan(np.pi / 6.0)  # q over p
    law = {"kind": "drucker_prager", "density": sand_slice.DENSITY, "youngs_modulus": sand_slice.YOUNGS_MODULUS,
           "poisson_ratio": sand_slice.POISSON_RATIO,
           "friction_angle": float(np.degrees(np.arcsin(3.0 * alpha / (6.0 + alpha))))}
    width, sides = sand_slice.ACROSS * dx, ("x_min", "y_min", "y_max")
    return Scene.model_validate({
        "name": "sand_slice", "dimension": 3, "end_time": sand_slice.TIME, "output": {"interval": sand_slice.TIME},
        "gravity": list(sand_slice.GRAVITY * np.array([np.sin(slope), 0.0, -np.cos(slope)])),
        "solver": {"dx": dx, "particles_per_cell": 8, **changes},
        "domain": {"min": [0.0, 0.0, -4 * dx], "max": [1.2, width, sand_slice.HEIGHT + 4 * dx],
                   "boundary": dict.fromkeys(sides, "symmetric")},
        "terrain": {"kind": "plane", "contact": "stick"}, "materials": {"sand": law},
        "bodies": [{"name": "slice", "material": "sand",
                    "shape": {"kind": "box", "min": [0.0, 0.0, 0.0],
                              "max": [sand_slice.LENGTH, width, sand_slice.HEIGHT]}}]})


def own_sand_rows(grids):
    """Rows of snowmpm for the slice of sand; single precision, its default."""
    wanted = [(choice, cells) for choice in OWN_SAND for cells in sand_slice.CELLS[:grids]]
    for choice, cells in [*wanted, *([("as it chooses", FINEST)] if grids == len(sand_slice.CELLS) else [])]:
        simulation, clock = Simulation(sand_scene(cells, OWN_SAND[choice])), free_bar.Clock()
        while simulation.time < sand_slice.TIME - 1e-9:
            clock.step(simulation.step)
        x = np.asarray(simulation.particles["position"])[:, 0]
        yield dict(zip(SAND_COLUMNS, ("snowmpm", choice, cells, len(x), len(clock.steps),
                                      float(f"{clock.seconds:.4g}"), float(f"{x.mean():.5g}"),
                                      float(f"{np.quantile(x, 0.99):.5g}")), strict=True))


def peer_rows(script, given, grids):
    """Rows that a peer's script prints, run by its own interpreter; none, with a word, when it fails.

    given: [PYTHON], [PYTHON, SOURCES] or [SOURCES], a folder of sources that are compiled.
    """
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    interpreter, *sources = [sys.executable, *given] if Path(given[0]).is_dir() else given
    done = subprocess.run([interpreter, str(HERE / "peers" / script), str(grids), *sources], capture_output=True,
                          text=True, env={**os.environ, **one, "PYTHONPATH": ""}, check=False)
    if done.returncode:
        print(f"{script}: left out: {(done.stderr.strip().splitlines() or ['no word'])[-1]}", file=sys.stderr)
        return []
    return [json.loads(line[4:]) for line in done.stdout.splitlines() if line.startswith("ROW ")]


def least(rows):
    """One row of each choice and grid, with its least time."""
    best = {}
    for row in rows:
        key = row["program"], row["choice"], row.get("dimension"), row["cells"]
        if key not in best or row["seconds"] < best[key]["seconds"]:
            best[key] = row
    return list(best.values())


def curves(rows, error):
    """A `Curve` of each choice of rows that follow each other."""
    for (program, choice), line in itertools.groupby(rows, key=lambda row: (row["program"], row["choice"])):
        line = sorted(line, key=lambda row: int(row["cells"]))
        yield Curve(f"{program}, {choice}", program, tuple(float(row["seconds"]) for row in line),
                    tuple(error(row) for row in line))


def draw(folder):
    """The tables that a folder has, as a picture: error against time, a line a choice."""
    panels, middle = [], 0.5 * sand_slice.LENGTH
    rows, sand = (list(csv.DictReader(path.read_text(encoding="utf-8").splitlines())) if path.exists() else []
                  for path in (folder / "peers.csv", folder / "peers_sand.csv"))
    for dim, title in (("2", "plane strain"), ("3", "3-D")):
        drawn = tuple(curves([row for row in rows if row["dimension"] == dim], lambda row: float(row["error"])))
        panels += [Panel(f"elastic bar, {title}: velocity after a period", drawn)] if drawn else []
    for finest in [float(row["middle"]) - middle for row in sand if int(row["cells"]) == FINEST]:
        drawn = tuple(curves([row for row in sand if int(row["cells"]) != FINEST],
                             lambda row, way=finest: abs(float(row["middle"]) - middle - way) / way))
        panels.append(Panel("slice of sand, 3-D: mean displacement*", drawn))
    if panels:
        render_work_precision(panels, folder / "peers.png", x_label="processor seconds of all steps, one thread",
                              title="The same problems by other programs", columns=len(panels),
                              size=(4.5 * len(panels), 6.0), legend_columns=4, dpi=90,
                              y_label=f"relative error (* from snowmpm on {FINEST} cells)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures", help="folder")
    for name in ("newton", "pysph"):
        parser.add_argument(f"--{name}", nargs=1, metavar="PYTHON", help=f"interpreter that has {name}")
    parser.add_argument("--geotaichi", nargs=2, metavar=("PYTHON", "SOURCES"), help="interpreter and checkout")
    parser.add_argument("--matter", nargs=1, metavar="SOURCES", help="checkout, which is compiled")
    parser.add_argument("--problems", nargs="+", choices=("bar", "sand"), default=["bar", "sand"])
    parser.add_argument("--grids", type=int, default=3, choices=(1, 2, 3))
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--draw", action="store_true", help="only draw the table that is there")
    options = parser.parse_args()
    for name in PEERS:
        for path in getattr(options, name) or []:
            if not Path(path).exists():
                parser.error(f"--{name}: {path}: no such file or folder")
    options.output.mkdir(parents=True, exist_ok=True)
    if not options.draw:
        runtime.start("cpu", threads=1)
        if "bar" in options.problems:
            write(measured(options, own_rows, PEERS), COLUMNS, options.output / "peers.csv")
        if "sand" in options.problems:
            write(measured(options, own_sand_rows, SAND), SAND_COLUMNS, options.output / "peers_sand.csv")
    draw(options.output)


def write(rows, columns, table):
    """Write a table, and print it."""
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(" ".join(f"{row[name]!s:>18s}" for name in columns))
    print(device_name("cpu", 1), flush=True)


def measured(options, own, scripts):
    """Rows of a problem: of snowmpm by `own`, of each peer that is given by its script."""
    rows = []
    for _ in range(options.repeat):
        rows += own(options.grids)
        for name, script in scripts.items():
            given = getattr(options, name)
            rows += peer_rows(script, given, options.grids) if given else []
    return least(rows)


if __name__ == "__main__":
    main()
