"""How a scene asks for water in a flow, and what shows that it takes weight off the ground."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def part(method):
    """What a scene needs for it, beside other components."""
    return {"gravity": given.G, "terrain": given.ground(method),
            "water": {"scheme": "one_phase", "level": 0.1, "excess": 0.5, "consolidation": 1e-3}}


def wet_flow(method):
    block = given.block(3, (2.0, 0.0))
    return Simulation(given.scene(method, 3, bodies=[block], **part(method)))


def presses(simulation):
    before = simulation.audit()
    assert (simulation.particles["excess_pressure"] > 0.0).all()
    steps(simulation, 5)
    fields, row = simulation.particles, simulation.audit()
    assert (fields["pore_pressure"] > 0.0).all()
    assert row["water_mass"] == before["water_mass"] > 0.0 and row["momentum_residual"] < 1e-11


ASKED = wet_flow, presses
