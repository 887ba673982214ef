"""How a scene asks for bodies that part, and what shows that they do."""

import numpy as np

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach


def two_bodies(method):
    """Side by side, going away from each other."""
    dim = given.least_dimension(method)
    one = given.block(dim, (-1.0, 0.0))
    other = given.block(dim, (1.0, 0.0), start=given.SIDE, name="two", contact="separate")
    return Simulation(given.scene(method, bodies=[one, other]))


def have_parted(simulation):
    reach(simulation, 0.005)
    v, own = simulation.particles["velocity"][:, 0], simulation.particles["body"]
    np.testing.assert_allclose(v, np.where(own == 1, 1.0, -1.0), atol=1e-9)


def part(method):
    """What a scene needs for it, beside other components: a body under the block."""
    dim = given.least_dimension(method)
    shape = given.box(dim, (0.0, -given.SIDE - 0.06), (given.SIDE, -0.06))
    return {"bodies": [given.body(shape, "two", contact="separate")]}


ASKED = two_bodies, have_parted
