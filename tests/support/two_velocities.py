"""Scenes of grains and water with a velocity each, in a few cells, which share their kernels."""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

DX = 0.05
MEDIUM = {"kind": "elastic", "density": 1600.0, "youngs_modulus": 1e7, "poisson_ratio": 0.0}
WATER = {"scheme": "v_w", "permeability": 1e-9, "grain_density": 1600.0 / 0.6, "bulk_modulus": 1e7}


def scene(size, water=None, solver=None, **changes):
    """`Scene` of a box of saturated soil from the origin, `size` [m] along x and z, or x, y and z."""
    corner = list(size)
    tables = {"name": "mixture", "dimension": len(corner), "end_time": 10.0, "gravity": 0.0,
              "solver": {"dx": DX, "precision": "f64", "transfer": "aflip", **(solver or {})},
              "materials": {"soil": MEDIUM}, "water": {**WATER, **(water or {})},
              "bodies": [{"name": "block", "material": "soil",
                          "shape": {"kind": "box", "min": [0.0] * len(corner), "max": corner}}]}
    return Scene.model_validate({**tables, **changes})


def around(water=None, dimension=2, **changes):
    """`Simulation` of soil without an end: periodic along all axes, one block of cells each."""
    side = 8 * DX
    sides = {f"{axis}_{end}": "periodic" for axis in ("xz" if dimension == 2 else "xyz") for end in ("min", "max")}
    return Simulation(scene([side] * dimension, water, domain={
        "min": [0.0] * dimension, "max": [side] * dimension, "boundary": sides}, **changes))


def in_tub(size, tub, water=None, sides=None, **changes):
    """`Simulation` of a block in a tub [m] with slippery walls and floor."""
    walls = {f"{axis}_{end}": "slip" for axis in ("x" if len(tub) == 2 else "xy") for end in ("min", "max")}
    walls["z_min"] = "slip"
    return Simulation(scene(size, water, domain={"min": [0.0] * len(tub), "max": list(tub),
                                                 "boundary": {**walls, **(sides or {})}}, **changes))


def phases(simulation):
    """Whether each particle is water."""
    return simulation.particles["material"] == 1


def set_velocities(simulation, grains, water):
    """Give all grains and all water a velocity (2,) [m/s]."""
    store = simulation.solver.particles
    wet = store.labels()[:, 0] == 1
    gain = np.where(wet[:, None], np.asarray(water), np.asarray(grains)) - store.column("velocity")
    store.accelerate(gain)


def run_to(simulation, time):
    while simulation.time < time:
        simulation.step(until=time)
    return simulation
