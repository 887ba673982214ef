"""Numerics that a scene leaves open are chosen from what is in it; one key overrides a choice."""

import pytest

from snowmpm.measured.borders import shipped
from snowmpm.scenes import load_scene
from snowmpm.scenes.choices import BENT, GRAINS_AT_RANDOM, GRAINS_CALM, THIN_BEAM
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.schema import Scene

BEAM = {
    "name": "beam", "dimension": 2, "end_time": 1.0, "gravity": 9.81, "solver": {"dx": 0.01},
    "domain": {"min": [0.0, -1.0], "max": [1.5, 0.5], "boundary": {"x_min": "stick"}},
    "materials": {"rubber": {"kind": "elastic", "density": 1000.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
    "bodies": [{"name": "beam", "material": "rubber", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [1.0, 0.1]}}]}


def beam(shape=None, solver=None, **tables):
    body = {**BEAM["bodies"][0], "shape": {**BEAM["bodies"][0]["shape"], **(shape or {})}}
    return Scene.model_validate({**BEAM, **tables, "bodies": [body], "solver": {**BEAM["solver"], **(solver or {})}})


def test_a_column_of_grains():
    scene = load_scene("column_collapse_2d")
    assert scene.choices == (GRAINS_AT_RANDOM, GRAINS_CALM)
    assert (scene.solver.sampling, scene.solver.transfer, scene.solver.flip_ratio) == ("poisson", "aflip", 0.99)


def test_a_thin_beam():
    scene = beam()
    assert scene.choices == (THIN_BEAM,)
    assert (scene.solver.kernel, scene.solver.gradient) == ("cubic", "shape")
    assert shipped()["bent_beam", "quadratic"].value == BENT


@pytest.mark.parametrize("scene", [
    beam({"max": [1.0, 0.4]}), beam(gravity=0.1), beam({"min": [0.2, 0.0], "max": [1.2, 0.1]}),
    beam({"min": [0.0, -1.0], "max": [1.0, -0.9]}), beam(solver={"method": "sph"})],
    ids=["thick", "hardly bent", "free", "lying", "sph"])
def test_bodies_that_are_no_thin_beams(scene):
    assert scene.choices == () and scene.solver.kernel == "quadratic"


@pytest.mark.parametrize("changes", [
    {"materials.sand.cohesion": 100.0}, {"domain.max": [0.3, 2.0]}, {"terrain.angle": 10.0}, {"solver.method": "sph"},
    {"obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [0.5, 0.0], "max": [0.6, 0.3]}}]}], ids=str)
def test_grains_that_are_no_columns(changes):
    scene = load_scene("column_collapse_2d", changes)
    assert scene.choices == () and scene.solver.sampling == "regular"


def test_one_key_overrides_a_choice():
    scene = load_scene("column_collapse_2d", {"solver.sampling": "regular"})
    assert scene.choices == (GRAINS_CALM,) and scene.solver.sampling == "regular"
    scene = load_scene("column_collapse_2d", {"solver.transfer": "apic"})
    assert scene.choices == (GRAINS_AT_RANDOM,) and scene.solver.transfer == "apic"
    assert beam(solver={"gradient": "affine"}).solver.kernel == "quadratic"


def test_a_resolved_scene_is_the_same_scene(tmp_path):
    scene = load_scene("column_collapse_2d")
    path = tmp_path / "resolved.toml"
    path.write_text(scene.to_toml())
    assert load_scene(path).solver == scene.solver == with_overrides(scene, {"end_time": 0.5}).solver


def test_a_choice_says_what_and_why():
    assert str(THIN_BEAM).startswith('solver.kernel = "cubic", solver.gradient = "shape": a thin elastic body')
