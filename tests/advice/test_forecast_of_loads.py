"""What `snowmpm check` says that loads on surfaces and frameworks cost."""

import time

import numpy as np
import pytest

from snowmpm.advice.budget import WITHIN, Budget
from snowmpm.advice.calibration import speed_now
from snowmpm.advice.facts import SceneFacts
from snowmpm.measured import costs
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e6, "poisson_ratio": 0.2}
PRESSED = [{"kind": "follower_pressure", "name": "air", "body": "block", "value": 10.0}]
FENCE = {"name": "fence", "width": 0.5, "youngs_modulus": 1e9, "density": 4000.0, "feet": {"a": "fixed", "d": "fixed"},
         "joints": {"a": [-4.0, 1.0, 0.0], "b": [-4.0, 1.0, 6.0], "c": [-4.0, 6.0, 6.0], "d": [-4.0, 6.0, 0.0]},
         "members": [{"ends": ["a", "b"]}, {"ends": ["b", "c"]}, {"ends": ["c", "d"]}], "segments": 3}


def of_block(dim, side, method="mpm", **keys):
    """`Simulation` of a block of so many cells on the ground, and its `Budget`."""
    solver = {"dx": 1.0, "method": method}
    if method == "implicit":
        solver["implicit"] = {"time": "newmark", "dt": 1e-2}
    scene = Scene.model_validate({
        "name": "block", "dimension": dim, "end_time": 10.0, "solver": solver, "materials": {"snow": SNOW},
        "domain": {"min": [-8.0] * (dim - 1) + [0.0], "max": [side + 4.0] * dim, "boundary": {"z_min": "stick"}},
        "bodies": [{"name": "block", "material": "snow", "shape": {
            "kind": "box", "min": [0.0] * dim, "max": [float(side)] * dim}}], **keys})
    simulation = Simulation(scene)
    return simulation, Budget(SceneFacts(scene, simulation.model, simulation.solver))


def row(budget, what):
    return next((each for each in budget.payments() if each.what == what), None)


def test_check_tells_of_points_and_elements():
    _, budget = of_block(3, 8, forces=PRESSED, structures=[FENCE])
    found = row(budget, "loads on surfaces")
    assert found.seconds > 0.0 and found.detail == f"{5 * 16 * 16} points"  # all sides but the one on the ground
    told = row(budget, "structures")
    assert told.seconds > 0.0 and told.detail.startswith("9 elements, ")
    _, rests = of_block(3, 8, structures=[FENCE | {"response": "static", "coupling": "one_way"}])
    work = rests.facts.solver.workload.components["structures"]
    assert work["unknown"] == 6 * 8 and work["substep"] == 0
    assert row(rests, "structures").seconds > told.seconds
    assert row(rests, "loads on surfaces") is None and "face_loads" not in rests.stages()
    _, plain = of_block(3, 8)
    assert row(plain, "structures") is None


def more_than(loaded, plain, steps):
    """Median processor time by which a step of the first `Simulation` takes longer than one of the second, in turn,
    and `Budget`'s speed of Python meanwhile."""
    dt, taken, speeds = 0.5 * min(one.solver.stable_dt()[0] for one in (loaded, plain)), [], []
    for _ in range(steps):
        spent = []
        for one in (loaded, plain):
            start = time.process_time()
            one.solver.step(dt)
            spent.append(time.process_time() - start)
        taken.append(spent[0] - spent[1])
        speeds.append(speed_now())
    return float(np.median(taken[4:])), [float(np.mean([getattr(one, name) for one in speeds]))
                                         for name in ("vector", "python")]


@pytest.mark.slow
@pytest.mark.parametrize(("method", "dim", "side"), [("mpm", 2, 40), ("mpm", 3, 16), ("implicit", 2, 24)])
def test_points_cost_what_is_foretold(method, dim, side):
    """Blocks of another size than those of the table (`tests/benchmarks/costs_of_loads.py`)."""
    loaded, budget = of_block(dim, side, method, forces=PRESSED)
    more, (_, python) = more_than(loaded, of_block(dim, side, method)[0], 29)
    machine = python / costs.reference_speed()[1]
    assert budget.stages()["face_loads"] * machine == pytest.approx(more, rel=WITHIN)
