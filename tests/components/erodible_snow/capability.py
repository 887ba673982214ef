"""How a scene asks for snow cover as particles, and what shows that a flow takes it up."""

import pytest

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach


def cover(dim, start, end, bottom=0.0, ahead=0.4):
    shape = given.box(dim, (start, bottom), (end, bottom + given.SIDE))
    return given.body(shape, "cover", laid_ahead=ahead)


def into_snow(method):
    """A block that runs into snow at rest, of which the part beyond 0.4 m waits."""
    dim = given.least_dimension(method)
    side = given.SIDE
    return Simulation(given.scene(method, bodies=[given.block(dim, (15.0, 0.0)), cover(dim, side + 0.06, 4.0 * side)]))


def takes_it_up(simulation):
    whole = len(simulation.model.population.volumes)
    before, present = simulation.audit(), simulation.n_particles
    assert present < whole and before["entrained_mass"] == 0.0
    row = reach(simulation, 0.06).audit()
    assert present < simulation.n_particles <= whole
    assert row["cover_mass"] > 0.0 and row["entrained_mass"] > 0.1 * before["mass"]
    assert row["mass"] == pytest.approx(before["mass"] + row["entrained_mass"] - row["removed_mass"], rel=1e-9)
    assert row["momentum_residual"] < 1e-9


def part(method):
    """What a scene needs for it, beside other components: a cover behind the block, of which a part waits."""
    return {"bodies": [cover(given.least_dimension(method), -2.5 * given.SIDE, -0.35, ahead=0.6)]}


ASKED = into_snow, takes_it_up
