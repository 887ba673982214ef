"""Friction cards that are gone: runs that began with them still load, new scenes are told what to do."""

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene

SCENE = "avalanche_depth_averaged"


def test_a_resolved_scene_keeps_its_numbers():
    table = {"law": "voellmy", "mu": 0.32, "xi": 1200.0, "card": "ramms_s300_gully_above_1000"}
    friction = load_scene(SCENE, {"terrain.friction": table}).terrain.friction
    assert (friction.mu, friction.xi, friction.card) == (0.32, 1200.0, "ramms_s300_gully_above_1000")


def test_a_new_scene_is_told_what_to_do():
    with pytest.raises(InputError, match="was removed, since its numbers were not published: give law, mu and xi"):
        load_scene(SCENE, {"terrain.friction": {"card": "ramms_s300_gully_above_1000"}})
