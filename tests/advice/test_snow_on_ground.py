"""Snow whose inner friction is below that of its ground: `check` says so, and it travels as it says."""

import math

import numpy as np
import pytest

from snowmpm import Simulation
from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build

ANGLE, MU, SECONDS = math.radians(30.0), 0.4663, 8.0
FROM = 0.81
"""Critical slope from which M / sqrt(3) is above MU."""


def sheet(critical_slope, contact="separate", cohesion=0.0):
    """60 m of snow, 3 m thick, on a plane of 30 degrees."""
    return Scene.model_validate({
        "name": "sheet", "dimension": 2, "end_time": SECONDS, "solver": {"dx": 1.5},
        "domain": {"min": [-20.0, -400.0], "max": [600.0, 60.0]},
        "terrain": {"kind": "plane", "angle": 30.0, "friction": MU, "contact": contact},
        "materials": {"snow": {"kind": "cohesive_cam_clay", "density": 200.0, "youngs_modulus": 1e6,
                               "poisson_ratio": 0.3, "critical_slope": critical_slope, "cohesion": cohesion,
                               "hardening": 3.0, "p0": 3e3}},
        "bodies": [{"name": "sheet", "material": "snow",
                    "shape": {"kind": "layer", "top": 3.0, "region": {"x": [0.0, 60.0]}}}]})


def told(scene):
    model = build(scene)
    return [one for one in cautions(SceneFacts(scene, model, model.solver())) if one.key.endswith("critical_slope")]


def mean_speed(scene):
    """Along the plane, at the end [m/s]."""
    solver, time = Simulation(scene).solver, 0.0
    while time < SECONDS:
        dt = min(solver.stable_dt()[0], SECONDS - time + 1e-9)
        solver.step(dt)
        time += dt
    along = np.array([math.cos(ANGLE), -math.sin(ANGLE)])
    return float((solver.particles.column("velocity")[:, :2] @ along).mean())


def test_check_names_the_critical_slope_from_which_snow_slides():
    found = told(sheet(0.5))
    assert len(found) == 1 and "0.29" in found[0].says and str(FROM) in found[0].cure
    for scene in (sheet(FROM), sheet(0.5, contact="stick"), sheet(0.5, cohesion=0.1)):
        assert not told(scene)


@pytest.mark.parametrize(("critical_slope", "over"), [(0.2, (1.5, 2.5)), (1.0, (0.97, 1.04))])
def test_snow_weaker_than_its_ground_travels_faster_than_the_ground_would_let_it(critical_slope, over):
    """Friction of the ground alone leaves g (sin - mu cos) t to the mean of all snow."""
    alone = 9.81 * (math.sin(ANGLE) - MU * math.cos(ANGLE)) * SECONDS
    assert over[0] < mean_speed(sheet(critical_slope)) / alone < over[1]
