"""How a scene asks for a body with mass, and what shows that the snow moves it."""

import numpy as np

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import momentum, steps


def against_crate(method):
    """A block thrown at a lighter box."""
    dim = given.least_dimension(method)
    lower, upper = given.point(dim, given.SIDE + 0.02, -0.1, -0.1), given.point(dim, given.SIDE + 0.6, 0.5, 0.5)
    return Simulation(given.scene(method, bodies=[given.block(dim, (8.0, 0.0))], obstacles=[
        {"name": "crate", "shape": {"kind": "box", "min": lower, "max": upper}, "free": {"density": 400.0}}]))


def pushes_it(simulation):
    before = momentum(simulation)
    steps(simulation, 30)
    crate, row = simulation.solver.adapters["rigid_bodies"].world.bodies[0], simulation.audit()
    gained = crate.motion.mass_properties.mass * crate.motion.velocity
    assert gained[0] > 0.02 * before[0] and crate.motion.centre[0] > given.SIDE + 0.31
    assert np.allclose(momentum(simulation) + gained, before, rtol=0.0, atol=1e-11 * before[0])
    assert row["momentum_residual"] < 1e-11 and row["rigid_momentum_residual"] < 1e-11


def part(method):
    """What a scene needs for it, beside other components: a box on the right of the block."""
    dim = given.least_dimension(method)
    lower, upper = given.point(dim, given.SIDE + 0.02, 0.06, -0.1), given.point(dim, given.SIDE + 0.6, 0.6, 0.5)
    return {"obstacles": [{"name": "crate", "shape": {"kind": "box", "min": lower, "max": upper},
                           "free": {"density": 400.0}}]}


ASKED = against_crate, pushes_it
