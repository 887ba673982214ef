"""Scenes of a profile: their laws have the strength and the energy that was asked for, and they run."""

import math
from dataclasses import replace

import numpy as np
import pytest

from snowmpm import load_scene
from snowmpm.errors import InputError
from snowmpm.pit import mechanics, release_scenes, scenes
from snowmpm.pit.column import Plate, column_of
from snowmpm.pit.reader import read_profile
from snowmpm.pit.weak_layers import candidates
from snowmpm.saw_test import theory
from snowmpm.saw_test.prediction import column_of as slab_of
from tests.support.snow_pits import caaml, write


@pytest.fixture
def column(tmp_path):
    read = read_profile(write(tmp_path))
    return column_of(read, candidates(read)[0].index)


def _written(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return load_scene(path)


@pytest.mark.parametrize(("slope", "energy"), [(scenes.SLOPE, 0.56), (release_scenes.RUBS, 0.56), (scenes.SLOPE, 1.2)])
def test_the_law_has_the_strength_and_the_energy(column, slope, energy):
    column = replace(column, weak=replace(column.weak, strength=1500.0, energy=energy, youngs_modulus=1e6))
    law = scenes.weak_law(column, slope)
    assert law.strength == pytest.approx(1500.0, rel=1e-3)
    assert law.energy == pytest.approx(energy, rel=0.05)


def test_a_layer_that_could_not_bear_its_slab_is_made_to(column):
    column = replace(column, weak=replace(column.weak, strength=100.0))
    law = scenes.weak_law(column)
    assert law.strength == pytest.approx(scenes.BEARS * column.stresses[1], rel=1e-3)
    text = scenes.saw_test_scene(column, law, "saw_test", "here", 0.4)
    assert "its shear strength would be 100 Pa, less than 1.5 times" in text


def test_the_saw_test_has_the_layers_of_the_profile(column, tmp_path):
    law = scenes.weak_law(column)
    scene = _written(tmp_path, scenes.saw_test_scene(column, law, "saw_test", "Made-up slope", 0.4))
    assert scene.saw_test.slope_angle == 36.0
    slab, weak, thickness = slab_of(scene)
    assert (slab.thickness, slab.density) == pytest.approx((column.thickness, column.density), rel=1e-3)
    assert slab.bending_modulus == pytest.approx(column.slab.bending_modulus, rel=1e-3)
    assert thickness == pytest.approx(column.weak.thickness, rel=1e-3)
    assert theory.shear_strength(weak, column.stresses[0]) == pytest.approx(law.strength, rel=1e-3)


def test_thin_layers_are_joined_to_the_one_most_alike():
    plates = [Plate(0.2, 250.0, 8e6, "form"), Plate(0.02, 240.0, 6e6, "form"), Plate(0.2, 100.0, 1e6, "form")]
    first, second = scenes.merged(plates, 0.05)
    assert (first.thickness, second.thickness) == pytest.approx((0.22, 0.2))
    assert first.density * 0.22 == pytest.approx(0.2 * 250.0 + 0.02 * 240.0)
    assert first.youngs_modulus * 0.22 == pytest.approx(0.2 * 8e6 + 0.02 * 6e6)


def test_the_slab_tears_at_its_tensile_strength():
    """p0 of a material of the slab, from the yield surface in uniaxial tension."""
    from snowmpm.materials import CohesiveCamClay

    p0 = mechanics.tensile_strength(250.0) / release_scenes.TENSION
    law = CohesiveCamClay(kind="cohesive_cam_clay", density=250.0, youngs_modulus=2e6, poisson_ratio=0.25,
                          critical_slope=release_scenes.RUBS, cohesion=scenes.COHESION, hardening=1.0, p0=p0)
    pulled = [[mechanics.tensile_strength(250.0), 0, 0], [0, 0, 0], [0, 0, 0]]
    bears = law.yield_function(np.array(pulled, float), np.array(law.initial_state()))
    scale = p0**2
    assert abs(float(bears)) < 0.001 * scale  # 0.1 % of the strength is as much


def test_the_release_is_large_enough_to_tear(column, tmp_path):
    soft = release_scenes.of_release(column)
    law = scenes.weak_law(soft, release_scenes.RUBS)
    scene = _written(tmp_path, release_scenes.release_on_plane(soft, law, "release", "here"))
    weak = next(body for body in scene.bodies if body.name == "weak_layer")
    corners = [corner[0] for corner in weak.shape.region.polygon]
    low, high = min(corners), max(corners)
    sigma, tau = soft.stresses
    drive = (tau - release_scenes.RUBS / math.sqrt(3.0) * sigma) * (high - low)
    holds = sum(mechanics.tensile_strength(plate.density) * plate.thickness for plate in soft.plates)
    assert drive > 2.0 * holds
    assert max(law.youngs_modulus for law in scene.materials.values()) <= release_scenes.STIFFEST


def test_no_release_where_nothing_slides(column):
    flat = release_scenes.of_release(replace(column, angle=20.0))
    with pytest.raises(InputError, match="no release on 20 degrees"):
        release_scenes.release_on_plane(flat, scenes.weak_law(flat, release_scenes.RUBS), "release", "here")


def test_a_name_from_a_file_writes_no_scene(column, tmp_path):
    """A profile may be called anything; it stands in a comment, on one line."""
    text = caaml().replace("Made-up slope", "a\n[solver]\ndx = 1e-9 &quot;&#13;")
    read = read_profile(write(tmp_path, text=text))
    law = scenes.weak_law(column)
    scene = _written(tmp_path, scenes.saw_test_scene(column, law, "saw_test", read.name, 0.4))
    assert scene.name == "saw_test"
    assert scene.solver.dx > 0.01
