"""A key at the wrong level is looked up in the whole scene."""

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene

MEANT = {
    "dams": ([{}], "terrain.dams"),
    "method": ("depth", "solver.method"),
    "forest": ([{}], "terrain.forest"),
    "precision": ("f64", "solver.precision"),
    "E": (1e6, "materials.NAME.youngs_modulus"),
    "materials.slab.E": (1e6, "youngs_modulus"),
    "xi": (2000, "terrain.friction.xi"),
    "terrain.mu": (0.2, "terrain.friction.mu"),
    "solver.interval": (0.1, "output.interval"),
    "solver.end_time": (3, "end_time"),
    "terrain.dx": (1, "solver.dx"),
    "solver.dxx": (1, "dx"),
}


@pytest.mark.parametrize("key", MEANT)
def test_the_key_that_was_meant(key):
    value, meant = MEANT[key]
    with pytest.raises(InputError) as refused:
        load_scene("slab_release_2d", {key: value})
    message = str(refused.value)
    assert f"{key} = " in message and message.endswith(f"unknown key; did you mean {meant}?")
