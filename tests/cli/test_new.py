"""Scenes to start from: they load, they say what they are, and nothing is lost."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from snowmpm.scenes import load_scene
from snowmpm.scenes.library import FOLDER
from snowmpm.terrain import TerrainSurface
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


def test_own_raster_with_a_release_polygon(call):
    for name in ("valley.asc", "valley_release.geojson"):
        shutil.copy(FOLDER / name, name)
    made = call("new", "valley", "--terrain", "valley.asc", "--release", "valley_release.geojson", "-o", "sub")
    assert made.code == 0, made.err
    scene = load_scene("sub/valley.toml")
    assert scene.terrain.kind == "dem"
    assert Path(scene.terrain.file).is_absolute()  # it does not lie below the scene
    assert scene.bodies[0].shape.top == "file"


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
        (("first", "--like", "pst", "--terrain", "slope.stl"), "--like"),
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
