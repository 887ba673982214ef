"""The scene format: what it holds, what it fills in, and what it refuses."""

import copy

import pytest
from pydantic import ValidationError

from snowmpm.errors import InputError
from snowmpm.materials import LAWS
from snowmpm.scenes import Scene, load_scene

MATERIAL = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.2}


def smallest(dimension=2, **more):
    """The shortest scene there is."""
    corner = [1.0] * dimension
    return {
        "name": "smallest",
        "dimension": dimension,
        "end_time": 1.0,
        "solver": {"dx": 0.1},
        "materials": {"snow": dict(MATERIAL)},
        "bodies": [
            {"name": "block", "material": "snow", "shape": {"kind": "box", "min": [0.0] * dimension, "max": corner}}
        ],
        **copy.deepcopy(more),
    }


def layer(**keys):
    return [{"name": "slab", "material": "snow", "shape": {"kind": "layer", "top": 0.5, **keys}}]


def test_contract_example_is_read_as_written(scene_file):
    scene = load_scene(scene_file)
    assert (scene.name, scene.dimension, scene.end_time, scene.gravity, scene.seed) == ("slab_release", 2, 6.0, 9.81, 1)
    assert scene.output.fields == ("velocity", "density")
    assert scene.output.checkpoint_interval == 1.0
    assert (scene.solver.dx, scene.solver.dt, scene.solver.flip_ratio) == (0.1, 1e-4, 0.97)
    assert scene.domain.max == (60.0, 40.0)
    assert scene.terrain.points == ((0.0, 30.0), (40.0, 5.0), (60.0, 5.0))
    assert type(scene.materials["slab"]) is LAWS["cohesive_cam_clay"]
    assert type(scene.materials["weak_layer"]) is LAWS["anticrack_cam_clay"]
    assert (scene.bodies[0].shape.bottom, scene.bodies[0].shape.top) == (0.1, 0.6)
    assert scene.bodies[0].shape.region.x == (5.0, 35.0)
    assert scene.obstacles[0].motion.stop == 1.0
    assert scene.events[0].path[1] == (8.0, 26.0)
    assert scene.initial.stress == "geostatic"
    assert scene.base_dir == scene_file.parent.resolve()
    assert scene.source == str(scene_file)


@pytest.mark.parametrize(("dimension", "per_cell", "down"), [(2, 4, (0.0, -9.81)), (3, 8, (0.0, 0.0, -9.81))])
def test_defaults_follow_the_dimension(dimension, per_cell, down):
    scene = Scene.model_validate(smallest(dimension))
    assert scene.solver.particles_per_cell == per_cell
    assert scene.bodies[0].velocity == (0.0,) * dimension
    assert scene.gravity_vector == down
    assert (scene.solver.method, scene.solver.kernel, scene.solver.transfer) == ("mpm", "quadratic", "apic")
    assert (scene.domain, scene.terrain, scene.obstacles, scene.events) == (None, None, (), ())


def test_gravity_may_be_a_vector():
    assert Scene.model_validate(smallest(gravity=[1.0, -2])).gravity_vector == (1.0, -2.0)


TERRAINS_2D = [
    {"kind": "plane", "angle": 30.0},
    {"kind": "plane", "point": [1.0, 2.0], "angle": -5, "contact": "stick"},
    {"kind": "profile", "points": [[0, 1], [1, 0]], "fillet": 2.0, "contact": "slip", "friction": 0.0},
]
TERRAINS_3D = [
    {"kind": "plane", "angle": 30.0, "azimuth": 90.0},
    {"kind": "profile", "points": [[0, 1], [1, 0]]},
    {"kind": "mesh", "file": "slope.stl"},
    {"kind": "dem", "file": "alps.asc", "region": {"x": [0, 10], "y": [0, 20]}},
]
SHAPES_2D = [
    {"kind": "sphere", "centre": [0, 1], "radius": 2},
    {"kind": "polygon", "points": [[0, 0], [1, 0], [0, 1]]},
    {"kind": "layer", "top": 1},
    {"kind": "layer", "bottom": 0.5, "top": 1, "region": {"x": [0, 1]}},
]
SHAPES_3D = [
    {"kind": "sphere", "centre": [0, 1, 0], "radius": 2},
    {"kind": "cylinder", "base": [0, 0, 0], "axis": [0, 0, 1], "radius": 1, "height": 2},
    {"kind": "mesh", "file": "house.stl"},
    {"kind": "prism", "points": [[0, 0], [1, 0], [0, 1]], "y": [0, 1]},
    {"kind": "layer", "top": 1, "region": {"x": [0, 1], "y": [0, 1]}},
    {"kind": "layer", "top": 1, "region": {"polygon": [[0, 0], [1, 0], [0, 1]]}},
    {"kind": "layer", "top": "file", "region": {"file": "release.shp"}},
    {"kind": "layer", "region": {"file": "release.geojson"}},
]


@pytest.mark.parametrize("terrain", TERRAINS_2D, ids=str)
def test_every_terrain_in_2d(terrain):
    assert Scene.model_validate(smallest(2, terrain=terrain)).terrain.kind == terrain["kind"]


@pytest.mark.parametrize("terrain", TERRAINS_3D, ids=str)
def test_every_terrain_in_3d(terrain):
    assert Scene.model_validate(smallest(3, terrain=terrain)).terrain.kind == terrain["kind"]


@pytest.mark.parametrize("shape", SHAPES_2D, ids=str)
def test_every_shape_in_2d(shape):
    bodies = [{"name": "b", "material": "snow", "shape": shape}]
    scene = Scene.model_validate(smallest(2, bodies=bodies, terrain=TERRAINS_2D[0]))
    assert scene.bodies[0].shape.kind == shape["kind"]


@pytest.mark.parametrize("shape", SHAPES_3D, ids=str)
def test_every_shape_in_3d(shape):
    bodies = [{"name": "b", "material": "snow", "shape": shape}]
    scene = Scene.model_validate(smallest(3, bodies=bodies, terrain=TERRAINS_3D[0]))
    assert scene.bodies[0].shape.kind == shape["kind"]


def test_every_event():
    events = [
        {"kind": "cut", "body": "block", "path": [[0, 0], [1, 0]]},
        {"kind": "load", "body": "block", "start": 1, "stop": 2, "centre": [0, 1], "radius": 0.5, "force": [0, -800]},
        {"kind": "remove", "body": "block", "start": 0.5},
    ]
    assert [event.kind for event in Scene.model_validate(smallest(events=events)).events] == ["cut", "load", "remove"]


def test_sides_of_the_domain():
    one = Scene.model_validate(smallest(domain={"boundary": "slip"})).domain
    assert one.sides(2) == {"x_min": "slip", "x_max": "slip", "z_min": "slip", "z_max": "slip"}
    some = Scene.model_validate(smallest(3, domain={"boundary": {"z_min": "stick", "y_max": "slip"}})).domain
    sides = some.sides(3)
    assert (sides["z_min"], sides["y_max"], sides["x_min"], len(sides)) == ("stick", "slip", "open", 6)


def test_nothing_can_be_set():
    scene = Scene.model_validate(smallest())
    with pytest.raises(ValidationError):
        scene.solver.dx = 1.0
    with pytest.raises(ValidationError):
        scene.end_time = 2.0


# (change of the smallest scene, what the message must name)
REFUSED = [
    ({"end_time": 0.0}, "end_time"),
    ({"end_time": "1"}, "end_time"),
    ({"end_time": True}, "end_time"),
    ({"end_time": float("inf")}, "end_time"),
    ({"dimension": 4}, "dimension"),
    ({"name": "../up"}, "name"),
    ({"name": ""}, "name"),
    ({"seed": 0.5}, "seed"),
    ({"gravity": [0.0, 0.0, -9.81]}, "2 numbers, \\[x, z\\]"),
    ({"solver": {"dx": 0.1, "cfl": 1.5}}, "cfl"),
    ({"solver": {"dx": 0.1, "kernel": "linear"}}, "kernel"),
    ({"solver": {"dx": 0.1, "particles_per_cell": 0}}, "particles_per_cell"),
    ({"output": {"fields": ["speed"]}}, "fields"),
    ({"output": {"fields": ["p", "p"]}}, "twice"),
    ({"output": {"interval": 0}}, "interval"),
    ({"domain": {"min": [0.0, 0.0], "max": [0.0, 1.0]}}, "above min"),
    ({"domain": {"min": [0.0, 0.0]}}, "both min and max"),
    ({"domain": {"boundary": {"y_min": "slip"}}}, "no y"),
    ({"domain": {"boundary": {"x_min": "periodic"}}}, "both ends"),
    ({"terrain": {"kind": "mesh", "file": "a.stl"}}, "only in a 3-D"),
    ({"terrain": {"kind": "plane", "azimuth": 10.0}}, "azimuth"),
    ({"terrain": {"kind": "plane", "angle": 90.0}}, "angle"),
    ({"terrain": {"kind": "profile", "points": [[0, 1], [0, 0]]}}, "x must grow"),
    ({"materials": {}}, "materials"),
    ({"materials": {"snow": {**MATERIAL, "density": -1.0}}}, "density"),
    ({"materials": {"snow": {**MATERIAL, "poisson_ratio": 0.5}}}, "poisson_ratio"),
    ({"materials": {"ice": MATERIAL}}, "must be one of the materials: ice"),
    ({"bodies": []}, "bodies"),
    ({"bodies": layer()}, "needs|none|terrain"),
    ({"bodies": layer(bottom=0.5), "terrain": TERRAINS_2D[0]}, "above bottom"),
    ({"bodies": layer(top="file"), "terrain": TERRAINS_2D[0]}, "needs region"),
    ({"bodies": layer(region={"x": [2, 1]}), "terrain": TERRAINS_2D[0]}, "lower < upper"),
    ({"bodies": layer(region={"polygon": [[0, 0], [1, 0], [0, 1]]}), "terrain": TERRAINS_2D[0]}, "only in a 3-D"),
    ({"bodies": layer(region={}), "terrain": TERRAINS_2D[0]}, "needs x"),
    ({"bodies": [{"name": "b", "material": "snow", "shape": SHAPES_3D[1]}]}, "2 numbers"),
    ({"obstacles": [{"name": "o", "shape": {"kind": "layer", "top": 1}}]}, "kind|layer"),
    ({"events": [{"kind": "remove", "body": "blok"}]}, "must be one of the bodies: block"),
    ({"events": [{"kind": "cut", "body": "block", "path": [[0, 0]]}]}, "path"),
    ({"initial": {"stress": "gravity"}}, "stress"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED, ids=lambda value: str(value)[:60])
def test_refused(change, message):
    with pytest.raises(ValidationError, match=message):
        Scene.model_validate({**smallest(), **copy.deepcopy(change)})


def test_names_of_bodies_differ():
    scene = smallest()
    scene["bodies"] *= 2
    with pytest.raises(ValidationError, match="another of this name"):
        Scene.model_validate(scene)


def test_polygon_shape_only_in_2d():
    bodies = [{"name": "b", "material": "snow", "shape": {"kind": "polygon", "points": [[0, 0, 0]] * 3}}]
    with pytest.raises(ValidationError, match="only in a 2-D"):
        Scene.model_validate(smallest(3, bodies=bodies))


def test_a_file_is_looked_for_beside_the_scene(scene_file, monkeypatch):
    shape = {"kind": "layer", "region": {"file": "release.shp"}}
    three = {"dimension": 3, "domain": {}, "obstacles": [], "events": [], "bodies.0.velocity": [0, 0, 0]}
    three |= {"bodies.0.shape": shape, "bodies.1.shape": shape, "terrain": {"kind": "mesh", "file": "slope.stl"}}
    with pytest.raises(InputError, match=r'terrain.file = "slope.stl": no such file'):
        load_scene(scene_file, three)
    (scene_file.parent / "slope.stl").touch()
    (scene_file.parent / "release.shp").touch()
    monkeypatch.chdir(scene_file.parent.parent)
    assert load_scene(scene_file, three).terrain.file == "slope.stl"
