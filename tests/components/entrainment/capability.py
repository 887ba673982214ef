"""How a scene asks for snow cover, and what shows that the flow takes it up."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach


def over_snow_cover(method):
    """A block that slides over snow."""
    cover = {"law": "rate", "growth_rate": 0.5, "thickness": 0.1}
    block = given.block(given.least_dimension(method), (4.0, 0.0))
    return Simulation(given.scene(method, bodies=[block], gravity=given.G,
                                  terrain={**given.ground(method), "entrainment": cover}))


def grows(simulation):
    before = simulation.solver.particles.mass
    row = reach(simulation, 0.1).audit()
    assert row["entrained_mass"] > 1e-3 * before and row["momentum_residual"] < 1e-11
    assert abs(row["mass"] - before - row["entrained_mass"]) < 1e-9 * before


def part(method):
    """What a scene needs for it, beside other components."""
    return {"gravity": given.G, "terrain": {**given.ground(method), "entrainment": {
        "law": "rate", "growth_rate": 0.5, "thickness": 0.1}}}


ASKED = over_snow_cover, grows
