"""How a scene asks for a layer of points, and what shows that it carries the snow above."""

import numpy as np

import snowmpm
from snowmpm.running.simulation import Simulation
from tests.contract.method_suite import steps


def on_points(method):
    """A saw test on cells five times as thick as its weak layer."""
    return Simulation(snowmpm.load_scene("pst_2d", {
        "solver.method": method, "solver.dx": 0.25, "saw_test.length": 1.2, "initial.stress": "geostatic",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05, "interface": 2}}))


def is_carried(simulation):
    steps(simulation, 5)
    np.testing.assert_allclose(simulation.solver.totals.impulse, -simulation.solver.totals.weight_impulse, rtol=0.1,
                               atol=1.0)


ASKED = on_points, is_carried
