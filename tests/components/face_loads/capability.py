"""How a scene asks for loads on surfaces, and what shows that they act."""

import numpy as np

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import momentum, steps


def pulled(method):
    """A body that is pulled by its own surface."""
    pull = {"kind": "traction", "name": "pull", "body": "one",
            "value": given.point(given.least_dimension(method), 30.0, 0.0)}
    return Simulation(given.scene(method, forces=[pull]))


def follows_its_surface(simulation):
    """It gains what its surface got."""
    before = momentum(simulation)
    steps(simulation, 3)
    pull = simulation.solver.adapters["face_loads"].impulses()[0]
    assert pull[0] > 0.0 and np.allclose(momentum(simulation) - before, pull, rtol=0.0, atol=1e-9 * pull[0])


def part(method):
    """What a scene needs for it, beside other components."""
    return {"forces": [{"kind": "traction", "name": "pull", "body": "one",
                        "value": given.point(given.least_dimension(method), 30.0, 0.0)}]}


ASKED = pulled, follows_its_surface
