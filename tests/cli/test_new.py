"""Scenes to start from: they load, they say what they are, and nothing is lost."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh

import snowmpm
from snowmpm.scenes import load_scene, starts
from snowmpm.scenes.library import FOLDER
from snowmpm.seeding import seed_body
from snowmpm.setup.first_scene import scene_on_ground
from snowmpm.terrain import TerrainSurface, load_terrain
from snowmpm.terrain.first_release import first_release


def test_a_first_scene_runs_as_it_is(call):
    made = call("new", "first")
    assert made.code == 0, made.err
    assert "snowmpm run first.toml" in made.out
    text = Path("first.toml").read_text()
    assert text.count("#") > 20
    done = call("run", "first.toml", "--set", "end_time=0.05", "--threads", "1")
    assert done.code == 0, done.err
    assert "2 frames" in done.out


def test_a_slab_is_put_where_the_ground_is_even():
    """Two slopes of 36 degrees side by side: the higher one with furrows 3 m apart and 1.6 m deep, in which a layer of
    2 m folds."""
    x, y = (np.arange(0.0, 100.1, 0.5), np.arange(0.0, 60.1, 0.5))
    along, across = np.meshgrid(x, y, indexing="ij")
    rough = np.clip((across - 28.0) / 4.0, 0.0, 1.0)
    z = -np.tan(np.radians(36.0)) * along + rough * (5.0 + 0.8 * np.cos(2.0 * np.pi * across / 3.0))
    number = np.arange(z.size).reshape(z.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    surface = TerrainSurface.of(np.column_stack([along.ravel(), across.ravel(), z.ravel()]),
                                np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))
    assert first_release(surface, 2.0).y[1] <= 29.0


@pytest.mark.parametrize("example", ["obstacles", "box", "precision", "polygon"])
def test_what_a_comment_proposes_may_be_added(call, example):
    shutil.copy(FOLDER / "slope.stl", "slope.stl")
    arguments = ("--terrain", "slope.stl") if example == "polygon" else ()
    assert call("new", "mine", *arguments).code == 0
    text = Path("mine.toml").read_text()
    if example == "obstacles":
        start = text.index("# [[obstacles]]")
        block = text[start:].split("\n\n")[0]
        text = text.replace(block, block.replace("# [[", "[[").replace("\n# ", "\n"))
    elif example == "precision":
        text = text.replace("# precision", "precision")
    elif example == "box":
        text = "\n".join(line.removeprefix("# ") for line in text.split("\n")
                         if not line.startswith("shape = ")).replace("mine: a slab", "# mine").split("\n", 4)[4]
    else:
        start = text.index("# region = ")
        proposed = text[start + 2 :].split(" or ")[0]
        line = next(line for line in text.split("\n") if line.startswith("shape = "))
        text = text.replace(line, line[: line.index("region = ")] + proposed + " }")
    Path("other.toml").write_text(text)
    scene = load_scene("other.toml")
    changed = {"obstacles": lambda: scene.obstacles[0].name == "wall",
               "precision": lambda: scene.solver.precision == "f64",
               "box": lambda: scene.bodies[0].shape.kind == "box",
               "polygon": lambda: len(scene.bodies[0].shape.region.polygon) == 3}
    assert changed[example]()


def test_own_slope(call):
    shutil.copy(FOLDER / "slope.stl", "slope.stl")
    made = call("new", "mine", "--terrain", "slope.stl", "--thickness", "0.9")
    assert made.code == 0, made.err
    scene = load_scene("mine.toml")
    assert (scene.terrain.kind, scene.terrain.file, scene.bodies[0].shape.top) == ("mesh", "slope.stl", 0.9)
    assert 0.3 <= scene.solver.dx <= 1.35
    checked = call("check", "mine.toml")
    assert checked.code == 0, checked.err
    assert "release" in checked.out


def test_values_may_be_set_at_once(call, tmp_path):
    """Files count from the current folder, comments stay, and what is not in the file is added to its table."""
    shutil.copy(FOLDER / "valley.asc", "valley.asc")
    shutil.copy(FOLDER / "valley_release.geojson", "seen.geojson")
    made = call("new", "mine", "--terrain", "valley.asc", "--elevation-unit", "ft", "--set", "end_time=7",
                "--set", "bodies.0.shape.top=0.8", "--set", "solver.precision=f64", "--set", "stop.momentum_share=0.1",
                "--set", 'bodies.0.shape.region={file = "seen.geojson"}', "-o", "sub", "--thickness", "0.8")
    assert made.code == 0, made.err
    scene, text = load_scene("sub/mine.toml"), Path("sub/mine.toml").read_text()
    assert (scene.end_time, scene.solver.precision, scene.stop.momentum_share) == (7, "f64", 0.1)
    assert scene.bodies[0].shape.region.file == str(tmp_path / "seen.geojson") and scene.bodies[0].shape.top == 0.8
    assert scene.terrain.elevation_unit == "ft" and "# s: until it rests" in text
    refused = call("new", "other", "--set", "solver.dx=none", "--set", "nothing.at.all=1")
    assert refused.code == 2 and not Path("other.toml").exists()


def test_own_raster_with_a_release_polygon(call):
    for name in ("valley.asc", "valley_release.geojson"):
        shutil.copy(FOLDER / name, name)
    made = call("new", "valley", "--terrain", "valley.asc", "--release", "valley_release.geojson", "-o", "sub")
    assert made.code == 0, made.err
    scene = load_scene("sub/valley.toml")
    assert scene.terrain.kind == "dem"
    assert Path(scene.terrain.file).is_absolute()  # it does not lie below the scene
    assert scene.bodies[0].shape.top == "file"


@pytest.mark.parametrize("release", [(), ("--release", "valley_release.geojson")])
def test_a_depth_averaged_scene_on_an_own_raster_runs(call, release):
    """Cells of the raster, a class of friction, and a first second of it."""
    for name in ("valley.asc", "valley_release.geojson"):
        shutil.copy(FOLDER / name, name)
    made = call("new", "path", "--terrain", "valley.asc", "--method", "depth", *release)
    assert made.code == 0, made.err
    assert " cells" in made.out
    scene = load_scene("path.toml")
    assert scene.solver.method == "depth" and scene.terrain.friction.card == "samos_at_auto"
    assert scene.solver.dx == 10.0  # the raster's
    result = call("run", "path.toml", "-o", "first", "-q", "--set", "end_time=1.0", "--set", "output.interval=1.0")
    assert result.code == 0, result.err


def test_a_first_depth_averaged_scene_ends_at_rest(call):
    """Before its end time, and with as many cells at the start as it said."""
    for name in ("valley.asc", "valley_release.geojson"):
        shutil.copy(FOLDER / name, name)
    made = call("new", "path", "--terrain", "valley.asc", "--release", "valley_release.geojson", "--method", "depth")
    assert made.code == 0, made.err
    done = call("run", "path.toml", "-o", "first", "-q")
    assert done.code == 0, done.err
    run = snowmpm.Run("first")
    assert run.summary["ended"] and run.times[-1] < load_scene("path.toml").end_time
    assert f"{len(run.frame(0).points)} cells" in made.out


def release_with(rows):
    """The polygon of the valley once for each row of attributes, side by side."""
    data = json.loads((FOLDER / "valley_release.geojson").read_text())
    shape = json.dumps(data["features"][0]["geometry"])
    ring = np.array(data["features"][0]["geometry"]["coordinates"][0])
    features = []
    for i, row in enumerate(rows):
        geometry = json.loads(shape)
        geometry["coordinates"] = [(ring.mean(axis=0) + 0.2 * (ring - ring.mean(axis=0)) + [40.0 * i, 0.0]).tolist()]
        features.append({"type": "Feature", "properties": row, "geometry": geometry})
    Path("release.geojson").write_text(json.dumps({**data, "features": features}))


@pytest.mark.parametrize(("rows", "options", "top", "words"), [
    ([{"d0": 0.6}], (), "file", "thickness: 0.6 m, from the file"),
    ([{"depth": 0.6}], (), 1.5,
     "an assumption: release.geojson has no attribute 'thickness' (its attributes are depth)"),
    ([{}], ("--thickness", "0.7"), 0.7, "thickness: 0.7 m\n"),
    ([{"thickness": 0.6}, {"thickness": None}], ("--thickness", "0.7"), 0.7, "0.7 m, in place of 0.6 m of the file"),
    ([{"thickness": 0.6}, {"thickness": None}], (), None, "polygon 2: thickness is missing; others have 0.6 m"),
    ([{"thickness": "1,2"}], (), None, "polygon 1: thickness = '1,2': must be a number of metres; with a point: 1.2"),
])
def test_a_thickness_is_never_invented_in_silence(call, rows, options, top, words):
    shutil.copy(FOLDER / "valley.asc", "valley.asc")
    release_with(rows)
    made = call("new", "path", "--terrain", "valley.asc", "--release", "release.geojson", "--method", "depth", *options)
    assert words in made.out + made.err
    if top is None:
        assert made.code == 2 and not Path("path.toml").exists()
    else:
        assert made.code == 0 and load_scene("path.toml").bodies[0].shape.top == top


def test_a_long_slope_is_pointed_to_the_depth_averaged_method(call):
    shutil.copy(FOLDER / "valley.asc", "valley.asc")
    assert "--method depth" in call("new", "path", "--terrain", "valley.asc").out


def test_copy_brings_what_belongs_to_its_files(tmp_path):
    """A shapefile is four files, a grid has its system beside it; names stand in quotes of either kind."""
    folder = tmp_path / "from"
    folder.mkdir()
    text = (FOLDER / "avalanche_on_raster.toml").read_text()
    assert '"valley.asc"' in text and '"valley_release.geojson"' in text
    (folder / "path.toml").write_text(text.replace('"valley.asc"', "'valley.asc'").replace(
        '"valley_release.geojson"', '"release.shp"'))
    for name in ("valley.asc", "valley.prj", "release.shp", "release.DBF", "release.shx", "release.prj", "other.prj"):
        (folder / name).write_bytes(b"of " + name.encode())
    _, copied = starts.copy_of(folder / "path.toml", "mine", tmp_path / "to")
    assert sorted(one.name for one in copied) == ["release.DBF", "release.prj", "release.shp", "release.shx",
                                                  "valley.asc", "valley.prj"]


def test_copy_of_a_library_scene_brings_its_files(call):
    made = call("new", "other", "--like", "slab_release")
    assert made.code == 0, made.err
    assert Path("slope.stl").read_bytes() == (FOLDER / "slope.stl").read_bytes()
    copy, original = (load_scene(name).model_dump() for name in ("other.toml", "slab_release"))
    assert copy.pop("name") == "other"
    original.pop("name")
    assert copy == original
    Path("slope.stl").write_text("mine")
    refused = call("new", "third", "--like", "slab_release")
    assert refused.code == 2 and "slope.stl" in refused.err and not Path("third.toml").exists()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("../up",), "letters, digits"),
        (("first", "--like", "slab_relese"), "did you mean slab_release?"),
        (("first", "--terrain", "slpe.stl"), "no such file; did you mean slope.stl?"),
        (("first", "--terrain", "notes.txt"), "must end in .stl"),
        (("first", "--release", "area.geojson"), "--terrain"),
        (("first", "--method", "depth"), "--terrain"),
        (("first", "--like", "pst", "--terrain", "slope.stl"), "--like"),
        (("first", "--like", "slush_dam_2d", "--set", 'solver.transfer="apic"'), 'must be "aflip" or "flip"'),
        (("taken",), "--overwrite"),
    ],
)
def test_refused(call, arguments, expected):
    shutil.copy(FOLDER / "slope.stl", "slope.stl")
    Path("taken.toml").write_text("mine")
    refused = call("new", *arguments)
    assert refused.code == 2
    assert expected in refused.err
    assert not Path("first.toml").exists()
    assert Path("taken.toml").read_text() == "mine"


def test_first_release_is_where_it_is_steep_and_high():
    # Falls along x: 10 degrees, then 38, then 38 again lower down, then flat
    x = np.linspace(0.0, 100.0, 101)
    angle = np.where(x < 20.0, 10.0, np.where(x < 70.0, 38.0, 0.0))
    z = 60.0 - np.concatenate([[0.0], np.cumsum(np.tan(np.radians(angle[:-1])))])
    grid, y = np.meshgrid(x, np.linspace(0.0, 60.0, 31), indexing="ij")
    number = np.arange(grid.size).reshape(grid.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    surface = TerrainSurface.of(np.column_stack([grid.ravel(), y.ravel(), np.repeat(z, 31)]),
                                np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))
    found = first_release(surface)
    assert found.slope == pytest.approx(38.0, abs=1.5)
    assert 18.0 < found.x[0] < 26.0
    assert found.y[0] >= 3.0 and found.y[1] <= 57.0


def turned_ground(kind, azimuth, path, scale=1.0):
    """A strip of ground 100 m long and 50 m wide that falls in the direction of `azimuth` [degrees], as a mesh or, with
    no data around it, a raster. kind: a bowl, a valley, a ridge, an even slope with a hole of 6 m."""
    along, across = np.meshgrid(np.linspace(0.0, 100.0, 61), np.linspace(-25.0, 25.0, 31), indexing="ij")
    z = {"valley": 40.0 * np.exp(-along / 35.0) + 0.01 * across**2,
         "ridge": 40.0 * np.exp(-along / 35.0) - 0.01 * across**2,
         "hole": -np.tan(np.radians(38.0)) * along}[kind]
    c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))
    points = scale * np.column_stack([(c * along - s * across).ravel(), (s * along + c * across).ravel(), z.ravel()])
    number = np.arange(along.size).reshape(along.shape)
    corner = [n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])]
    facets = np.concatenate([np.column_stack([corner[i] for i in three]) for three in ((0, 1, 2), (0, 2, 3))])
    if kind == "hole":
        place = np.array([30.0 * c, 30.0 * s]) * scale
        facets = facets[(np.linalg.norm(points[facets][:, :, :2].mean(axis=1) - place, axis=1) > 3.0 * scale)]
    if path.suffix == ".stl":
        trimesh.Trimesh(points, facets, process=False).export(path)
        return path
    surface, cell = TerrainSurface.of(points, facets), 1.5 * scale
    x, y = (np.arange(surface.lower[k], surface.upper[k], cell) for k in (0, 1))
    xx, yy = np.meshgrid(x, y[::-1])
    z = np.nan_to_num(surface.height(np.column_stack([xx.ravel(), yy.ravel()])), nan=-9999.0).reshape(xx.shape)
    rows = "\n".join(" ".join(f"{v:.5g}" for v in row) for row in z)
    path.write_text(f"ncols {len(x)}\nnrows {len(y)}\nxllcenter {x[0]}\nyllcenter {y[0]}\ncellsize {cell}\n{rows}\n")
    return path


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("ending", [".stl", ".asc"])
@pytest.mark.parametrize("kind", ["valley", "ridge", "hole"])
def test_a_slope_in_any_direction_makes_a_scene_that_can_be_filled(kind, ending, tmp_path):
    """Of such a strip the box in plan is empty in its corners."""
    for azimuth, scale in ((0, 1.0), (17, 1.0), (45, 0.05), (60, 1.0), (110, 20.0), (135, 1.0), (200, 1.0), (287, 1.0)):
        path = turned_ground(kind, azimuth, tmp_path / f"ground{ending}", scale)
        text, told = scene_on_ground("mine", tmp_path / "mine.toml", path)
        (tmp_path / "mine.toml").write_text(text)
        scene = load_scene(tmp_path / "mine.toml")
        surface = load_terrain(scene.terrain, tmp_path, dimension=3)
        dx = 2.0 * scene.bodies[0].shape.top  # as coarse as it may be: the check of what lies on ground is the same
        seeds = seed_body(scene.bodies[0].shape, surface, dim=3, dx=dx, particles_per_cell=8, sampling="regular",
                          rng=np.random.default_rng(0), base_dir=tmp_path)
        region = scene.bodies[0].shape.region
        side = min(np.ptp(region.x), np.ptp(region.y))
        assert 5.0 * scale < side < 32.0 * scale, (azimuth, told)
        slope = np.degrees(np.arccos(surface.normal(seeds.positions[:, :2])[:, 2])).mean()
        assert 28.0 < slope < 48.0, (azimuth, slope)


def test_a_turned_slope_passes_its_check(call):
    turned_ground("valley", 30.0, Path("slope.stl"))
    assert call("new", "mine", "--terrain", "slope.stl").code == 0
    checked = call("check", "mine.toml", "--set", "solver.dx=2.0")
    assert checked.code == 0, checked.err


@pytest.mark.parametrize(("kind", "leaves"), [("valley", False), ("ridge", True), ("hole", True)])
def test_it_is_said_where_the_ground_may_be_too_small(call, kind, leaves):
    """A ridge sheds to its sides, an even slope runs out at its foot."""
    turned_ground(kind, 30.0, Path("slope.stl"))
    made = call("new", "mine", "--terrain", "slope.stl")
    assert ("the ground may end before the snow stops" in made.out) == leaves, made.out
    assert "names no coordinate system" in made.out


def test_ground_with_no_room_is_refused(call):
    points = np.array([[0.0, 0.0, 0.0], [1000.0, 1000.0, 600.0], [1000.0, 1000.5, 600.0]])
    trimesh.Trimesh(points, [[0, 1, 2]], process=False).export("strip.stl")
    refused = call("new", "mine", "--terrain", "strip.stl")
    assert refused.code == 2 and "no ground wide and even enough" in refused.err
