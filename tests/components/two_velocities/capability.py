"""How a scene asks for water with a velocity of its own, and what shows that it goes with the grains when both fall."""

import numpy as np

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def part(method):
    """What a scene needs for it, beside other components."""
    return {"solver": {"transfer": "aflip"}, "precision": "f64", "gravity": given.G,
            "water": {"scheme": "v_w", "permeability": 1e-9, "bulk_modulus": 1e6}}


def with_moving_water(method):
    return Simulation(given.scene(method, **part(method)))


def falls_together(simulation):
    before = simulation.audit()
    steps(simulation, 5)
    fields, row = simulation.particles, simulation.audit()
    np.testing.assert_allclose(fields["velocity"][:, -1], -given.G * simulation.time, rtol=1e-9)
    assert row["water_mass"] == before["water_mass"] > 0.0
    assert row["water_residual"] < 1e-12 and row["momentum_residual"] < 1e-11


ASKED = with_moving_water, falls_together
