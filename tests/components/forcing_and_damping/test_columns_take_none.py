"""Depth-averaged flow has no forces and no damping of particles."""

import pytest

import snowmpm
from snowmpm.errors import InputError


@pytest.mark.parametrize(("changes", "key"), [
    ({"forces": [{"kind": "acceleration", "value": ["0.1", "0.0", "0.0"]}]}, "forces.0.kind"),
    ({"damping": {"coefficient": 1.0}}, "damping.coefficient"),
])
def test_columns_take_none(changes, key):
    with pytest.raises(InputError, match=key.replace(".", r"\.")) as refused:
        snowmpm.Simulation(snowmpm.load_scene("avalanche_depth_averaged", changes))
    assert "depth" in str(refused.value) and len(str(refused.value).splitlines()) <= 2
