"""What makes a scene another one than that of a run."""

import pytest

from snowmpm.io.checkpoint import differences
from snowmpm.scenes import load_scene


@pytest.mark.parametrize(("changes", "keys"), [
    ({}, []),
    ({"solver.dx": 0.02}, ["solver.dx"]),
    ({"reference.centre": 0.1, "picture.camera": "auto", "end_time": 2.0}, []),
    ({"solver.sph.viscosity": 1.0}, []),  # MPM takes no notice of it
])
def test_keys_that_differ(changes, keys):
    before = load_scene("column_collapse_2d").to_toml()
    assert [key for key, _, _ in differences(before, load_scene("column_collapse_2d", changes))] == keys


def test_choices_of_sph_count_where_sph_solves():
    before = load_scene("column_collapse_2d", {"solver.method": "sph"})
    other = load_scene("column_collapse_2d", {"solver.method": "sph", "solver.sph.viscosity": 1.0})
    assert [key for key, _, _ in differences(before.to_toml(), other)] == ["solver.sph.viscosity"]
