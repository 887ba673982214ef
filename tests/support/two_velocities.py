"""Scenes of grains and water with a velocity each, in a few cells, which share their kernels."""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

DX = 0.05
MEDIUM = {"kind": "elastic", "density": 1600.0, "youngs_modulus": 1e7, "poisson_ratio": 0.0}
WATER = {"scheme": "v_w", "permeability": 1e-9, "grain_density": 1600.0 / 0.6, "bulk_modulus": 1e7}


def scene(size, water=None, solver=None, **changes):
    """`Scene` of a box of saturated soil from the origin, `size` [m] along x and z."""
    corner = list(size)
    tables = {"name": "mixture", "dimension": 2, "end_time": 10.0, "gravity": 0.0,
              "solver": {"dx": DX, "precision": "f64", "transfer": "aflip", **(solver or {})},
              "materials": {"soil": MEDIUM}, "water": {**WATER, **(water or {})},
              "bodies": [{"name": "block", "material": "soil",
                          "shape": {"kind": "box", "min": [0.0, 0.0], "max": corner}}]}
    return Scene.model_validate({**tables, **changes})


def around(water=None, **changes):
    """`Simulation` of soil without an end: periodic along both axes, one block of cells each."""
    side = 8 * DX
    sides = dict.fromkeys(("x_min", "x_max", "z_min", "z_max"), "periodic")
    return Simulation(scene((side, side), water, domain={"min": [0.0, 0.0], "max": [side, side], "boundary": sides},
                            **changes))


def in_tub(size, tub, water=None, sides=None, **changes):
    """`Simulation` of a block in a tub [m] with slippery walls and floor."""
    walls = dict.fromkeys(("x_min", "x_max", "z_min"), "slip")
    return Simulation(scene(size, water, domain={"min": [0.0, 0.0], "max": list(tub),
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
