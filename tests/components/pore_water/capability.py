"""How a scene asks for water in the pores, and what shows that they hold it."""

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def part(method):
    """What a scene needs for it, beside other components: moist snow, or pores that are full where steps are solved."""
    water = {"split": "monolithic"} if method == "implicit" else {"suction": 0.0, "saturation": 0.1}
    return {"precision": "f64", "gravity": given.G, "water": {"permeability": 1e-9, **water}}


def soaked(method):
    """Full pores, below a water table if the method has one."""
    tables = part(method)
    if method != "implicit":
        tables["water"] |= {"table": 0.2, "saturation": 0.3}
    return Simulation(given.scene(method, **tables))


def holds_water(simulation):
    steps(simulation, 3)
    fields, row = simulation.particles, simulation.audit()
    if simulation.scene.water.solved:
        assert fields["saturation"].min() > 0.999
    else:  # it falls, so that water has no weight in it, but what is full stays nearly so
        low = fields["position"][:, -1] < 0.19
        assert fields["saturation"][low].min() > 0.99 and fields["saturation"][~low].max() < 0.35
    assert row["water_mass"] > 0.0 and row["water_residual"] < 1e-12
    assert row["momentum_residual"] < (1e-10 if simulation.scene.water.solved else 1e-11)


ASKED = soaked, holds_water
