"""How a scene asks for a force on all snow, and what shows that it acts."""

import pytest

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach


def blown_at(method):
    """A block in a uniform wind."""
    wind = [str(x) for x in given.point(given.least_dimension(method), 3.0, 0.0)]
    return Simulation(given.scene(method, forces=[{"kind": "acceleration", "value": wind}]))


def flies_off(simulation):
    reach(simulation, 0.005)
    v = simulation.particles["velocity"]
    assert v[:, 0].mean() == pytest.approx(3.0 * simulation.time, rel=1e-9)


def part(method):
    """What a scene needs for it, beside other components."""
    wind = [str(x) for x in given.point(given.least_dimension(method), 3.0, 0.0)]
    damped = {} if given.able(method).solves else {"damping": {"coefficient": 1.0}}
    return {"forces": [{"kind": "acceleration", "value": wind}], **damped}


ASKED = blown_at, flies_off
