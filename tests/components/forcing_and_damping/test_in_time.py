"""Damping and gravity that changes: by the methods whose steps take them."""

import numpy as np
import pytest

from snowmpm.components.forcing_and_damping.declare import IN_TIME
from snowmpm.errors import InputError
from snowmpm.registry import METHODS
from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import reach

TILTED = {"times": [0.0, 1.0], "values": [given.G, given.G], "tilts": [30.0, 30.0]}


@pytest.mark.parametrize("method", IN_TIME)
def test_snow_slides_along_as_gravity_tilts(method):
    simulation = Simulation(given.scene(method, gravity=TILTED))
    reach(simulation, 0.005)
    v = simulation.particles["velocity"].mean(axis=0)
    assert np.linalg.norm(v) == pytest.approx(given.G * simulation.time, rel=1e-6) and abs(v[0]) > 0.4 * abs(v[-1])


@pytest.mark.parametrize("key", ["gravity", "damping"])
@pytest.mark.parametrize("method", [name for name in METHODS if name not in IN_TIME])
def test_other_methods_refuse_it(method, key):
    tables = {"gravity": TILTED} if key == "gravity" else {"damping": {"coefficient": 1.0}}
    with pytest.raises(InputError, match=rf'{key}.*needs solver\.method = "mpm" or "sph"'):
        Simulation(given.scene(method, **tables))
