"""How a scene asks for water that seeps, and what shows that it does while grains rest."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def part(method):
    """What a scene needs for it; no other component goes with it."""
    return {"precision": "f64", "gravity": given.G, "water": {"scheme": "seepage", "permeability": 1e-7}}


def with_seepage(method):
    return Simulation(given.scene(method, **part(method)))


def seeps_down(simulation):
    steps(simulation, 5)
    fields, row = simulation.particles, simulation.audit()
    wet = fields["material"] == fields["material"].max()
    assert (fields["velocity"][~wet] == 0.0).all() and fields["velocity"][wet, -1].mean() < 0.0
    assert row["water_mass"] > 0.0 and row["water_residual"] < 1e-12 and row["momentum_residual"] < 1e-11


ASKED = with_seepage, seeps_down
