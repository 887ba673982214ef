"""The free bar by GeoTaichi (github.com/Yihao-Shi/GeoTaichi, GPL-3.0), one thread, double precision, its default.

    python geotaichi_bar.py GRIDS SOURCES       # SOURCES: a checkout; taichi 1.7.4 and what its requirements.sh names

Quadratic B-splines with Taylor PIC (`alphaPIC` 1), and FLIP (0), by its order of updates (`USF`), as its examples have
them; the length of a step is the user's there: 0.4 cells of a wave here, as for snowmpm. Open3D and a part of Trimesh
that is no longer are imported by it and not used here: an empty module stands for each that is not installed.
"""

import contextlib
import importlib
import io
import itertools
import os
import subprocess
import sys
import tempfile
import types

import numpy as np
from free_bar import CELLS, DENSITY, LENGTH, PERIOD, SECTION, SPEED, YOUNGS_MODULUS, Clock, error, start, tell

CHOICES = {"Taylor PIC": {"velocity_projection": "Taylor", "alphaPIC": 1.0},
           "FLIP": {"velocity_projection": "PIC/FLIP", "alphaPIC": 0.0}}
BETWEEN = 0.4
"""Cells of a wave in a step."""
APART = 4
"""Empty cells around the bar."""

sys.path.insert(0, os.path.abspath(sys.argv[2]))
for name in ("open3d", "trimesh.interfaces.gmsh"):
    try:
        importlib.import_module(name)
    except ImportError:
        sys.modules[name] = types.ModuleType(name)


def solve(dim, cells, choice):
    import geotaichi
    import taichi as ti

    dx, clock = LENGTH / cells, Clock()
    steps = int(np.ceil(PERIOD * SPEED / (BETWEEN * dx)))
    size = np.array([LENGTH, *[SECTION] * (dim - 1)])
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        geotaichi.init(dim=dim, arch="cpu", cpu_max_num_threads=1, log=False)
        from src.mpm import MPMBase  # its types are made by what init said

        step = MPMBase.Solver.core
        MPMBase.Solver.save_file = lambda *_: None  # its writer fails where numbers of a plane are of two kinds
        MPMBase.Solver.core = lambda self, *given: clock.step(step, self, *given)
        mpm = geotaichi.MPM(log=False)
        mpm.set_configuration(domain=ti.Vector(list(size + (2 * APART + 1e-9) * dx)), background_damping=0.0,
                              mapping="USF", gravity=ti.Vector([0.0] * dim), shape_function="QuadBSpline", log=False,
                              **CHOICES[choice])
        # One step is made while it compiles. Domain and region are larger than what they hold: it rounds down
        mpm.set_solver({"Timestep": PERIOD / steps, "SimulationTime": PERIOD * (1 - 1.5 / steps), "CFL": 1.0,
                        "SaveInterval": 10 * PERIOD, "SavePath": folder}, log=False)
        mpm.memory_allocate({"max_material_number": 1, "max_particle_number": 2**dim * cells**dim,
                             "max_constraint_number": {}}, log=False)
        mpm.add_material(model="LinearElastic", material={"MaterialID": 1, "Density": DENSITY, "PoissonRatio": 0.0,
                                                          "YoungModulus": YOUNGS_MODULUS})
        mpm.add_element({"ElementType": "Q4N2D" if dim == 2 else "R8N3D", "ElementSize": ti.Vector([dx] * dim)})
        mpm.add_region({"Name": "bar", "Type": f"Rectangle{'2D' if dim == 2 else ''}",
                        "BoundingBoxPoint": ti.Vector([APART * dx] * dim),
                        "BoundingBoxSize": ti.Vector(list(size + 0.1 * dx))})
        mpm.add_body({"Template": {"RegionName": "bar", "nParticlesPerCell": 2, "BodyID": 0, "MaterialID": 1,
                                   "ParticleStress": {"GravityField": False}, "InitialVelocity": ti.Vector([0.0] * dim),
                                   "FixVelocity": ["Free"] * dim}})
        mpm.select_save_data()
        count = int(mpm.scene.particleNum[0])
        x = mpm.scene.particle.x.to_numpy()[:count] - APART * dx
        v = mpm.scene.particle.v.to_numpy()
        v[:count, 0] = start(x[:, 0])
        mpm.scene.particle.v.from_numpy(v)
        mpm.run()
        found = mpm.scene.particle.v.to_numpy()[:count, 0]
    tell("GeoTaichi", choice, dim, cells, count, len(clock.steps), clock.seconds, error(x[:, 0], found))


if len(sys.argv) > 3:
    solve(int(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
else:
    for dim, choice, cells in itertools.product((2, 3), CHOICES, CELLS[: int(sys.argv[1])]):
        subprocess.run([sys.executable, __file__, *sys.argv[1:3], str(dim), str(cells), choice], check=True)
