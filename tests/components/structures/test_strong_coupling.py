"""Masts that answer within the step: by the methods whose adapter does that."""

import pytest

from snowmpm.components.structures.declare import STRONG
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, METHODS
from tests.components.structures.capability import against_mast
from tests.contract.method_suite import steps


@pytest.mark.parametrize("method", STRONG)
def test_a_light_mast_gives_way(method):
    simulation = against_mast(method, density=50.0, coupling="strong")
    steps(simulation, 30)
    row = simulation.audit()
    assert row["mast_top_x"] != 0.0 and row["structure_rounds"] > 0 == row["structure_unsettled"]
    assert row["momentum_residual"] < 1e-11 and row["structure_momentum_residual"] < 1e-9


@pytest.mark.parametrize("method", [method for method in METHODS if COMPONENTS["structures"].supports(method)])
def test_other_methods_refuse_it(method):
    if method not in STRONG:
        words = r'structures\.0\.coupling = .strong.: needs solver\.method = "mpm" in place of'
        with pytest.raises(InputError, match=words):
            against_mast(method, coupling="strong")
