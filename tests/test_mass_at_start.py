"""The mass at the start is that of the union of the bodies above the ground; where it is not, check and run say so."""

import json

import numpy as np
import pytest
import trimesh

from snowmpm.scenes import Scene, library, load_scene
from snowmpm.scenes.loader import tomllib
from snowmpm.setup.build import build
from snowmpm.setup.mass_at_start import mass_doubts

PLAIN = {
    "name": "b", "dimension": 2, "end_time": 0.02, "output": {"interval": 0.01}, "solver": {"dx": 0.1},
    "domain": {"min": [0.0, 0.0], "max": [1.0, 1.0], "boundary": "slip"},
    "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
}
BOX = {"kind": "box", "min": [0.2, 0.0], "max": [0.6, 0.4]}


def scene(*shapes, **changes):
    return Scene.model_validate(PLAIN | changes | {"bodies": [
        {"name": f"body_{i}", "material": "snow", "shape": shape} for i, shape in enumerate(shapes)]})


def told(made):
    return [str(doubt) for doubt in mass_doubts(build(made))]


@pytest.mark.parametrize("method", ["mpm", "sph", "implicit"])
@pytest.mark.parametrize(("other", "share"), [
    (BOX, 1.0), (BOX | {"min": [0.4, 0.0], "max": [0.8, 0.4]}, 0.5), (BOX | {"min": [0.6, 0.0], "max": [0.9, 0.4]}, 0),
    ({"kind": "sphere", "centre": [0.4, 0.2], "radius": 0.1}, 1.0),
    ({"kind": "polygon", "points": [[0.5, 0.1], [0.9, 0.1], [0.9, 0.4]]}, 0.0625)])
def test_two_bodies(method, other, share):
    solver = {"dx": 0.02, "method": method}
    said = told(scene(BOX, other, solver=solver))
    if not share:
        assert said == []
    else:
        assert len(said) == 1 and "with body_0: its mass counts twice there" in said[0]
        assert float(said[0].split(", ")[1].split("%")[0]) == pytest.approx(100.0 * share, abs=4.0)


@pytest.mark.parametrize(("bottom", "share"), [(0.0, 50), (0.1, 25), (0.2, 0), (0.198, 0)])
def test_half_a_body_in_the_ground(bottom, share):
    box = {"kind": "box", "min": [0.2, bottom], "max": [0.6, bottom + 0.4]}
    said = told(scene(box, terrain={"kind": "plane", "point": [0.0, 0.2]}, domain=PLAIN["domain"] | {
        "boundary": "stick"}))
    assert [int(one.split("%")[0].split()[-1]) for one in said] == ([share] if share else [])


@pytest.fixture
def ground(tmp_path, monkeypatch):
    """A curved slope, and two release polygons of which the second holds a quarter of the first."""
    monkeypatch.chdir(tmp_path)
    x = 10.0 * np.arange(60)
    z = 500.0 * np.exp(-x / 300.0) + 8.0 * np.sin(np.arange(40) / 4.0)[:, None]
    (tmp_path / "dem.asc").write_text("ncols 60\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
                                      + "\n".join(" ".join(f"{v:.2f}" for v in row) for row in z))
    for name, (a, b) in {"one": (60.0, 60.0), "two": (110.0, 110.0)}.items():
        ring = [[a, b], [a + 100.0, b], [a + 100.0, b + 100.0], [a, b + 100.0], [a, b]]
        (tmp_path / f"{name}.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))


def on_ground(bottoms, files=("one", "two"), method="depth", dx=5.0):
    return Scene.model_validate({
        "name": "r", "dimension": 3, "end_time": 1.0, "output": {"interval": 1.0},
        "solver": {"method": method, "dx": dx}, "terrain": {"kind": "dem", "file": "dem.asc", "friction": 0.3},
        "materials": PLAIN["materials"], "bodies": [
            {"name": name, "material": "snow", "shape": {"kind": "layer", "bottom": bottom, "top": bottom + 1.0,
                                                         "region": {"file": f"{name}.geojson"}}}
            for bottom, name in zip(bottoms, files, strict=True)]})


def table(made):
    """A scene as what is written in its file."""
    return tomllib.loads(made.to_toml())


@pytest.mark.parametrize(("method", "dx"), [("depth", 5.0), ("mpm", 2.0)])
def test_two_releases_over_one_area(ground, method, dx):
    said = told(on_ground((0.0, 0.0), method=method, dx=dx))
    assert len(said) == 1 and "with one: its mass counts twice there" in said[0]
    assert float(said[0].split(", ")[1].split("%")[0]) == pytest.approx(25.0, abs=2.0)


@pytest.mark.parametrize(("method", "dx"), [("depth", 5.0), ("mpm", 2.0)])
def test_layers_on_each_other_share_nothing(ground, method, dx):
    assert told(on_ground((0.0, 1.0), method=method, dx=dx)) == []


def test_layers_one_in_the_other_share_what_both_hold(ground):
    made = table(on_ground((0.0, 0.5)))
    made["bodies"][1]["shape"]["region"]["file"] = "one.geojson"
    said = told(Scene.model_validate(made))
    assert len(said) == 1 and float(said[0].split(", ")[1].split("%")[0]) == pytest.approx(50.0, abs=13.0)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_boxes_of_a_depth_averaged_flow(ground):
    made = on_ground((0.0, 0.0))
    z = float(build(made).surface.height(np.array([[100.0, 100.0]]))[0])
    boxes = [{"kind": "box", "min": [a, 80.0, z - 40.0], "max": [a + 50.0, 130.0, z + 40.0]} for a in (80.0, 105.0)]
    bodies = [{"name": f"box_{i}", "material": "snow", "shape": box} for i, box in enumerate(boxes)]
    said = told(Scene.model_validate(table(made) | {"bodies": bodies}))
    assert sum("below the ground" in one for one in said) == 2
    assert sum("counts twice" in one for one in said) == 1


def mesh_volume(mesh):
    """Volume of a body of a mesh, as a scene has it."""
    mesh.export("body.stl")
    made = PLAIN | {"dimension": 3, "solver": {"dx": 0.1}, "bodies": [
        {"name": "a", "material": "snow", "shape": {"kind": "mesh", "file": "body.stl"}}],
                    "domain": {"min": [-2.0, -2.0, -2.0], "max": [3.0, 3.0, 3.0], "boundary": "slip"}}
    return build(Scene.model_validate(made)).population.volumes.sum()


def test_a_shell_beside_another_is_no_cavity_whichever_way_it_faces(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cube, beside, within = (trimesh.creation.box((side,) * 3) for side in (0.6, 0.5, 0.3))
    for one in (beside, within):
        one.invert()
    beside.apply_translation((0.8, 0.0, 0.0))
    assert mesh_volume(trimesh.util.concatenate([cube, beside])) == pytest.approx(0.6**3 + 0.5**3, rel=1e-5)
    assert mesh_volume(trimesh.util.concatenate([cube, within])) == pytest.approx(0.6**3 - 0.3**3, rel=1e-5)


def test_a_surface_that_crosses_itself_holds_what_lies_inside(tmp_path, monkeypatch):
    """A prism over a pentagram, whose facets count the pentagon in its middle twice: 5/2 R^2 sin 144 degrees."""
    monkeypatch.chdir(tmp_path)
    angle = np.radians(144.0 * np.arange(5))
    corners = np.vstack([np.column_stack([np.cos(angle), np.sin(angle)]), [0.0, 0.0]])
    vertices = np.vstack([np.column_stack([corners, np.full(6, z)]) for z in (0.0, 0.5)])
    faces = [face for k in range(5) for face in ((5, (k + 1) % 5, k), (11, 6 + k, 6 + (k + 1) % 5),
                                                 (k, (k + 1) % 5, 6 + (k + 1) % 5), (k, 6 + (k + 1) % 5, 6 + k))]
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    twice = 0.5 * 2.5 * np.sin(np.radians(144.0))
    assert mesh.is_watertight and abs(mesh.volume) == pytest.approx(twice)
    with pytest.warns(UserWarning, match="its surface crosses itself"):
        volume = mesh_volume(mesh)
    inner = np.cos(np.radians(72.0)) / np.cos(np.radians(36.0))  # radius of the corners between the points
    star = 5.0 * inner * np.sin(np.radians(36.0)) * 0.5
    # Beside the walls within, up to the reach of distances, 1 % of the extent, the wall says that it is outside
    perimeter, extent = 10.0 * inner * np.sin(np.radians(36.0)), np.ptp(corners, axis=0).max()
    assert star - 0.01 * extent * perimeter * 0.5 < volume < 1.005 * star < 0.9 * twice


def test_snow_of_a_raster_off_the_terrain_is_told(ground):
    rows = "\n".join(" ".join(["1"] * 20) for _ in range(20))
    with open("thickness.asc", "w") as file:
        file.write("ncols 20\nnrows 20\nxllcorner -100\nyllcorner 100\ncellsize 10\n" + rows)
    made = table(on_ground((0.0,), ("one",)))
    made["bodies"][0]["shape"] = {"kind": "layer", "bottom": 0.0, "top": {"file": "thickness.asc"}}
    with pytest.warns(UserWarning, match="50% of its snow lies off the terrain"):
        build(Scene.model_validate(made))


def test_a_release_that_goes_later_does_not_count(ground):
    made = on_ground((0.0, 0.0))
    later = made.bodies[1].model_copy(update={"start_time": 0.5})
    assert told(made.model_copy(update={"bodies": (made.bodies[0], later)})) == []


@pytest.mark.parametrize("name", library())
def test_no_scene_of_the_library_is_told(name):
    assert told(load_scene(name)) == []
