"""Obstacles that stand on the ground: buildings by their footprint, and shapes that are put down."""

import json

import numpy as np
import pytest
import trimesh

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene
from snowmpm.solids import Obstacle
from snowmpm.solids.footprint import BELOW
from snowmpm.terrain import load_terrain
from tests.support.tables import Table as Spec

TAN = np.tan(np.radians(30.0))


@pytest.fixture(scope="module")
def ground():
    """z = 50 - x tan 30."""
    return load_terrain(Spec(kind="plane", point=(0.0, 0.0, 50.0), angle=30.0), extent=([0, 0], [60, 60]))


def obstacle(shape, ground, folder=".", **more):
    spec = Spec(name="house", shape=Spec(**shape), motion=None, contact="separate", friction=0.0, **more)
    return Obstacle.of(spec, 3, folder, ground=ground)


def footprint(**more):
    return {"kind": "footprint", "file": None, "part": None, "polygon": None, "height": 8.0} | more


def test_a_building_with_a_yard(ground):
    """An L, whose volume and levels are known."""
    corners = [[10.0, 10.0], [30.0, 10.0], [30.0, 20.0], [20.0, 20.0], [20.0, 30.0], [10.0, 30.0]]
    shape = obstacle(footprint(polygon=corners), ground).shape
    high, low = 50.0 - 10.0 * TAN, 50.0 - 30.0 * TAN
    assert shape.surface.closed
    assert shape.surface.lower[2] == pytest.approx(low - BELOW) and shape.surface.upper[2] == pytest.approx(high + 8.0)
    assert shape.surface.volume() == pytest.approx(300.0 * (high + 8.0 - low + BELOW))
    inside = shape.query(np.array([[12.0, 12.0, 45.0], [25.0, 25.0, 45.0], [12.0, 28.0, 45.0]]))[0] < 0
    assert inside.tolist() == [True, False, True]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_buildings_of_a_file(ground, tmp_path):
    rings = [[[a, 10.0], [a + 8.0, 10.0], [a + 8.0, 16.0], [a, 16.0], [a, 10.0]] for a in (5.0, 30.0)]
    hole = [[32.0, 12.0], [34.0, 12.0], [34.0, 14.0], [32.0, 14.0], [32.0, 12.0]]
    features = [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": c}}
                for c in ([rings[0]], [rings[1], hole])]
    (tmp_path / "houses.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    shape = obstacle(footprint(file="houses.geojson"), ground, tmp_path).shape
    assert shape.surface.volume() == pytest.approx((48.0 + 44.0) * (8.0 * TAN + 8.0 + BELOW))
    places = [[7.0, 12.0, 45.0], [20.0, 12.0, 45.0], [31.0, 11.0, 32.0], [33.0, 13.0, 32.0]]
    assert (shape.query(np.array(places))[0] < 0).tolist() == [True, False, True, False]
    second = obstacle(footprint(file="houses.geojson", part=2), ground, tmp_path).shape
    assert (second.query(np.array(places))[0] < 0).tolist() == [False, False, True, False]
    # Houses that touch or overlap stay whole, and keep their numbers
    inner = [[6.0, 11.0], [8.0, 11.0], [8.0, 13.0], [6.0, 13.0], [6.0, 11.0]]
    covered = [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
               for ring in (rings[0], inner, rings[1])]
    (tmp_path / "over.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": covered}))
    volumes = [obstacle(footprint(file="over.geojson", part=n), ground, tmp_path).shape.surface.volume()
               for n in (1, 2, 3)]
    assert volumes == pytest.approx([a * (d * TAN + 8.0 + BELOW) for a, d in ((48.0, 8.0), (4.0, 2.0), (48.0, 8.0))])
    with pytest.raises(InputError, match=r"part = 3: .*holds 2 areas"):
        obstacle(footprint(file="houses.geojson", part=3), ground, tmp_path)
    # Of a scene, each is an obstacle with a load of its own
    (tmp_path / "scene.toml").write_text("""
name = "houses"
dimension = 3
end_time = 1.0
solver = { dx = 1.0 }
materials.snow = { kind = "elastic", density = 300.0, youngs_modulus = 1e6, poisson_ratio = 0.3 }
domain = { min = [0.0, 0.0, 0.0], max = [60.0, 60.0, 80.0] }
terrain = { kind = "plane", point = [0.0, 0.0, 50.0], angle = 30.0 }
[[bodies]]
name = "block"
material = "snow"
shape = { kind = "box", min = [40.0, 40.0, 40.0], max = [44.0, 44.0, 44.0] }
[[obstacles]]
name = "house"
shape = { kind = "footprint", file = "houses.geojson", height = 8.0 }
""")
    scene = load_scene(tmp_path / "scene.toml")
    assert [(one.name, one.shape.part) for one in scene.obstacles] == [("house_1", 1), ("house_2", 2)]
    (tmp_path / "resolved.toml").write_text(scene.to_toml())
    assert [one.shape.part for one in load_scene(tmp_path / "resolved.toml").obstacles] == [1, 2]


def test_a_mesh_is_put_down(ground, tmp_path):
    box = trimesh.creation.box((4.0, 4.0, 6.0))
    box.apply_translation((20.0, 20.0, 1000.0))
    box.export(tmp_path / "house.stl")
    shape = obstacle({"kind": "mesh", "file": "house.stl"}, ground, tmp_path, on_ground=True).shape
    low = 50.0 - 22.0 * TAN
    assert (shape.surface.lower[2], shape.surface.upper[2]) == pytest.approx((low, low + 6.0))
    assert shape.query(np.array([[20.0, 20.0, low + 3.0], [20.0, 20.0, 1000.0]]))[0].tolist() == pytest.approx(
        [-2.0, shape.query(np.array([[20.0, 20.0, 1000.0]]))[0][0]]) and shape.origin[2] == pytest.approx(low + 3.0)


@pytest.mark.parametrize("shape", [
    {"kind": "box", "min": [10.0, 10.0, -5.0], "max": [12.0, 12.0, -1.0]},
    {"kind": "sphere", "centre": [11.0, 11.0, 0.0], "radius": 1.0},
    {"kind": "cylinder", "base": [11.0, 11.0, 80.0], "axis": [0.0, 0.0, 1.0], "radius": 1.0, "height": 4.0}])
def test_other_shapes_are_put_down(ground, shape):
    found = obstacle(shape, ground, on_ground=True).shape
    assert found.drawing()[0][:, 2].min() == pytest.approx(50.0 - 12.0 * TAN, abs=1e-6)


def test_what_cannot_stand_is_refused(ground):
    square = [[58.0, 10.0], [80.0, 10.0], [80.0, 20.0], [58.0, 20.0]]
    with pytest.raises(InputError, match="lies partly off the terrain"):
        obstacle(footprint(polygon=square), ground)
    with pytest.raises(InputError, match=r"needs a \[terrain\] to stand on"):
        obstacle(footprint(polygon=square), None)
    far = {"kind": "box", "min": [90.0, 90.0, 0.0], "max": [92.0, 92.0, 1.0]}
    with pytest.raises(InputError, match="has no ground under it"):
        obstacle(far, ground, on_ground=True)
    with pytest.raises(InputError, match=r"on_ground = True: needs a \[terrain\]"):
        obstacle(far, None, on_ground=True)
