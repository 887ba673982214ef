"""The table saw_test of a scene: what it makes, what it refuses."""

import itertools
import math

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene


def pst(name="pst_2d", **changes):
    return load_scene(name, {key.replace("__", "."): value for key, value in changes.items()})


def test_bodies_lie_on_each_other():
    scene = pst(saw_test__base={"material": "slab", "thickness": 0.1}, saw_test__notch=0.2,
                saw_test__slab=[{"material": "slab", "thickness": 0.3}, {"material": "slab", "thickness": 0.15}])
    assert [body.name for body in scene.bodies] == ["base", "weak_layer", "slab_1", "slab_2"]
    levels = [(body.shape.min, body.shape.max) for body in scene.bodies]
    for (_, upper), (lower, _) in itertools.pairwise(levels):
        assert upper[1] == pytest.approx(lower[1])
    assert levels[1][0][0] == 0.2 and levels[0][0][0] == levels[2][0][0] == 0.0  # the notch is in the weak layer
    assert levels[-1][1] == pytest.approx((6.0, 0.6))
    dx = scene.solver.dx
    assert all(abs(side / dx - round(side / dx)) < 1e-6 for side in scene.domain.min)


@pytest.mark.parametrize("angle", [35.0, 0.0, -35.0])
def test_gravity_is_tilted(angle):
    """Positive: the saw goes up the slope, so gravity points back along x."""
    x, z = pst(saw_test__slope_angle=angle).gravity_vector
    assert x == pytest.approx(-9.81 * math.sin(math.radians(angle))) and z == pytest.approx(
        -9.81 * math.cos(math.radians(angle)))


@pytest.mark.parametrize("name", ["pst_2d", "pst"])
def test_vertical_ends_are_along_gravity(name):
    scene = pst(name, saw_test__slope_angle=30.0, saw_test__ends="vertical")
    down = scene.gravity_vector
    lower, _, _, upper = scene.bodies[-1].shape.points
    assert (upper[0] - lower[0]) / (upper[1] - lower[1]) == pytest.approx(down[0] / down[-1])


def test_width_in_3d():
    box = pst("pst", saw_test__width=0.4).bodies[0].shape
    assert box.max[1] - box.min[1] == pytest.approx(0.4)


def test_weak_layer_of_two_cells():
    """Drawn two cells thick on any grid; the scene keeps its thickness."""
    for dx in (0.025, 0.01):
        scene = pst(solver__dx=dx)
        weak, slab = (next(body.shape for body in scene.bodies if body.name == name) for name in ("weak_layer", "slab"))
        assert weak.max[1] - weak.min[1] == pytest.approx(2.0 * dx) and slab.max[1] - slab.min[1] == pytest.approx(0.5)
        assert scene.saw_test.weak_layer.thickness == 0.05
    plain = pst(saw_test__weak_layer={"material": "weak_layer", "thickness": 0.05})
    assert plain.bodies[0].shape.max[1] == pytest.approx(0.05)


def test_resolved_scene_loads_and_can_be_changed(tmp_path):
    scene = pst(saw_test__slope_angle=20.0, saw_test__ends="normal")
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    again = load_scene(path)
    assert again.bodies == scene.bodies and again.domain == scene.domain and again.saw_test == scene.saw_test
    assert load_scene(path, {"saw_test.length": 4.0}).bodies[-1].shape.max[0] == 4.0


@pytest.mark.parametrize(("changes", "message"), [
    ({"saw_test__length": -1}, "saw_test.length = -1: must be > 0"),
    ({"saw_test__slop_angle": 1}, "saw_test.slop_angle"),
    ({"saw_test__slope_angle": 95}, "must be < 90"),
    ({"saw_test__notch": 7.0}, "saw_test.notch = 7.0: must be less than length = 6"),
    ({"saw_test__saw_length": 0.1, "saw_test__notch": 0.2}, "saw_length = 0.1: must be at least notch = 0.2"),
    ({"saw_test__width": 0.3}, "width exists only in a 3-D scene"),
    ({"saw_test__slab": []}, "too few entries"),
    ({"saw_test__weak_layer__material": "slab"}, "cells = 2: needs a material that no other layer has"),
    ({"saw_test__slab__0__material": "slub"}, "must be one of the materials"),
    ({"gravity": [0.0, -9.81]}, "gravity = [0.0, -9.81]: must be a number [m/s2] beside saw_test"),
    ({"terrain": {"kind": "plane"}}, "is made by saw_test: leave it out"),
    ({"solver__dx": -1}, "solver.dx = -1: must be > 0"),
])
def test_refused(changes, message):
    with pytest.raises(InputError) as caught:
        pst(**changes)
    assert message in str(caught.value)
