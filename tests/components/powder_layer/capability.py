"""How a scene asks for a powder layer, and what shows that it takes snow from the flow."""

import pytest

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps

CLOUD = {"suspension": "speed", "suspension_rate": 1e-2, "fall_speed": 0.2}


def above_a_block(method):
    """A block that slides, with a cloud above it."""
    block = given.block(given.least_dimension(method), (4.0, 0.0))
    return Simulation(given.scene(method, bodies=[block], **part(method)))


def takes_snow(simulation):
    before = simulation.solver.particles.mass
    steps(simulation, 10)
    row = simulation.audit()
    assert row["cloud_ice_mass"] > 1e-3 * before and row["momentum_residual"] < 1e-11
    assert row["mass"] == pytest.approx(before - row["suspended_mass"] + row["settled_mass"], rel=1e-9)
    assert max(row[f"cloud_{name}_residual"] for name in ("ice", "air", "momentum")) < 1e-11


def part(method):
    """What a scene needs for it, beside other components."""
    solver = {"depth": {"scheme": "volumes"}} if method == "depth" else {}
    return {"gravity": given.G, "powder_layer": CLOUD, "solver": solver,
            **({"terrain": given.ground(method)} if given.able(method).terrain else {})}


ASKED = above_a_block, takes_snow
