"""How a scene asks for pressure panels, and what shows that they measure."""

import pytest

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach


def wall(dim, ahead=True):
    """Ahead of the block, or behind it."""
    x = (given.SIDE + 0.02, given.SIDE + 0.5) if ahead else (-0.6, -0.12)
    shape = given.box(dim, (x[0], -0.2), (x[1], 1.0))
    return {"name": "gauge", "shape": shape, "panels": {"size": 0.2, "direction": given.point(dim, 1.0, 0.0),
                                                        "interval": 0.002}}


def against_a_wall(method):
    """A block that hits a wall with panels."""
    dim = given.least_dimension(method)
    return Simulation(given.scene(method, bodies=[given.block(dim, (3.0, 0.0))], obstacles=[wall(dim)]))


def have_measured(simulation):
    reach(simulation, 0.02)
    _, rows = simulation.solver.adapters["pressure_panels"].take_series()["face_pressure"]["gauge"]
    assert rows["pressure"][0].max() > 100.0
    row = simulation.solver.obstacle_totals[0]
    area, span = 0.2 * 1.0, 0.002  # of all panels of a height, per metre of width
    measured = (rows["pressure"][0].sum() * area + rows["force_beside"][0].sum()) * span
    assert measured == pytest.approx(row[0], rel=0.1)


def part(method):
    """What a scene needs for it, beside other components."""
    return {"obstacles": [wall(given.least_dimension(method), ahead=False)]}


ASKED = against_a_wall, have_measured
