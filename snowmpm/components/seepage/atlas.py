"""Entries: SPH of water that seeps through grains at rest."""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.study.atlas.entry import WORST, Entry
from snowmpm.water.phases import THETA

DX, TIME = 0.1, 2.0
"""Spacing [m] of grains, and how long [s] the water runs."""


def _soaked_half(stiffness):
    """A block of soil, full of water, in the left half of a tub 1 m wide."""
    return Simulation(Scene.model_validate({
        "name": "half", "dimension": 2, "end_time": TIME,
        "solver": {"method": "sph", "dx": DX, "precision": "f64"},
        "domain": {"min": [0.0, 0.0], "max": [1.0, 1.0],
                   "boundary": dict.fromkeys(("x_min", "x_max", "z_min"), "slip")},
        "materials": {"soil": {"kind": "elastic", "density": 1600.0, "youngs_modulus": 1e7, "poisson_ratio": 0.0}},
        "water": {"scheme": "seepage", "permeability": 1e-7, "grain_density": 1600.0 / 0.6, "table": 0.6,
                  "bulk_modulus": stiffness},
        "bodies": [{"name": "block", "material": "soil", "shape": {
            "kind": "box", "min": [0.0, 0.0], "max": [0.5, 0.6]}}]})).solver


def crowded(size, stiffness):
    """How much too full space is where it is fullest, the mean over the second half of TIME, by steps of C = size."""
    solver = _soaked_half(stiffness)
    dt = size * solver.stable_dt()[0] / solver.cfl
    steps, found = max(2, round(TIME / dt)), []
    try:
        for step in range(steps):
            solver.step(dt)
            if step >= steps // 2:
                found.append(float(solver.particles.column("water")[:, THETA].max()) - 1.0)
    except SimulationError:
        return WORST
    return float(np.mean(found))


ATLAS = {"water in the pores": (
    Entry(
        name="long_seepage_step", title="A step of seepage in which water falls through its spacing",
        scene="Water runs out of a soaked block into the other half of a tub, 2 s",
        seen="The room that water finds is that of the places where the step began. Where a step crosses most of a"
             " spacing, particles come to lie in each other, and burst apart",
        cure="solver.cfl at the usual 0.3", parameter="C = dt (speed + sqrt(g s)) / s", unit="",
        values=(0.15, 0.3, 0.45, 0.6, 0.8, 1.0, 1.5, 2.0), settings={"K_w 1e6": {"stiffness": 1e6},
                                                                      "K_w 1e5": {"stiffness": 1e5}},
        symptom="room that is wanting", limit=0.1, measure=crowded, shown="K_w 1e6", resolution=0.1),
)}
