"""How a scene asks for trees and snow that becomes ground, and what shows that snow stops."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def through_trees(method):
    """A block that slides into a wood; in the plane, where there is none, over ground that keeps what stops."""
    dim = given.least_dimension(method)
    wood = {"name": "wood", "region": {"x": [-9.0, 9.0]}, "drag": 0.05, "detrainment": 500.0}
    return Simulation(given.scene(method, bodies=[given.block(dim, (4.0, 0.0))], gravity=given.G, terrain={
        **given.ground(method), "forest": [wood] if dim == 3 else [], "deposition": {"time": 0.1}}))


def loses_snow(simulation):
    before = simulation.solver.particles.mass
    steps(simulation, 10)
    row = simulation.audit()
    assert row["laid_mass"] > 1e-3 * before and row["momentum_residual"] < 1e-11
    assert abs(row["mass"] + row["laid_mass"] - before) < 1e-6 * before


def part(method):
    """What a scene needs for it, beside other components."""
    return {"gravity": given.G, "terrain": {**given.ground(method), "deposition": {"time": 0.1}}}


ASKED = through_trees, loses_snow
