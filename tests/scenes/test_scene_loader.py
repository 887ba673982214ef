"""Loading scenes: names and paths, overrides, round trip through TOML."""

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import library, load_scene, loader
from snowmpm.scenes.library import FOLDER


def test_resolved_scene_loads_to_itself(scene_file, tmp_path):
    scene = load_scene(scene_file, {"solver.dt": 1 / 3, "domain.boundary": {"x_min": "slip"}})
    resolved = tmp_path / "elsewhere" / "scene.toml"
    resolved.parent.mkdir()
    resolved.write_text(scene.to_toml())
    again = load_scene(resolved)
    assert again.model_dump() == scene.model_dump()
    assert again.to_toml() == scene.to_toml()


def test_resolved_scene_finds_its_files_from_anywhere(scene_file, tmp_path):
    (scene_file.parent / "alps.asc").touch()
    shape = {"kind": "layer", "top": 1.0}
    three = {"dimension": 3, "domain": {}, "obstacles": [], "events": [], "bodies.0.velocity": [0, 0, 0]}
    three |= {"bodies.0.shape": shape, "bodies.1.shape": shape, "terrain": {"kind": "dem", "file": "alps.asc"}}
    resolved = tmp_path / "elsewhere" / "scene.toml"
    resolved.parent.mkdir()
    resolved.write_text(load_scene(scene_file, three).to_toml())
    assert load_scene(resolved).terrain.file == str(scene_file.parent.resolve() / "alps.asc")


@pytest.mark.parametrize("text", ['quote " and back \\', "line\nbreak", "tab\tdel\x7f", "Schnee ❄"])
def test_any_text_survives(scene_file, text, tmp_path):
    # The name of a body's material is the one text of a scene that a user is free to choose; here via the writer.
    from snowmpm.scenes.toml import _value

    path = tmp_path / "text.toml"
    path.write_text(f"x = {_value(text)}", encoding="utf-8")
    assert loader.parse(path) == {"x": text}


def test_overrides(scene_file):
    changes = {
        "solver.dx": 0.05,
        "bodies.0.velocity": [1.0, 0.0],
        "materials.slab.p0": 3.0e4,
        "bodies.1.shape.region.x": [0.0, 1.0],
        "output.fields.1": "damage",
        "solver.precision": "f64",
    }
    scene = load_scene(scene_file, changes)
    assert scene.solver.dx == 0.05
    assert scene.bodies[0].velocity == (1.0, 0.0)
    assert scene.materials["slab"].p0 == 3.0e4
    assert scene.bodies[1].shape.region.x == (0.0, 1.0)
    assert scene.output.fields == ("velocity", "damage")
    assert scene.solver.precision == "f64"


def test_overrides_stay_as_they_were_given(scene_file):
    given = {"domain": {"min": [-9.0, -9.0], "max": [9.0, 9.0]}, "domain.min": [-8.0, -8.0]}
    load_scene(scene_file, given)
    assert given["domain"]["min"] == [-9.0, -9.0]


def test_an_override_makes_the_table_it_needs(scene_file):
    text = scene_file.read_text()
    scene_file.write_text(text[: text.index("[initial]")])
    assert load_scene(scene_file, {"initial.stress": "settle"}).initial.stress == "settle"


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("bodies.7.velocity", "list with entries 0 to 1"),
        ("bodies.slab.velocity", "list with entries 0 to 1"),
        ("solver.dx.y", "has no keys"),
        ("solver..dx", "dotted key"),
        ("solver.dxx", "did you mean dx"),
        ("materials.slab.dens", "did you mean density"),
    ],
)
def test_misplaced_override(scene_file, key, message):
    with pytest.raises(InputError, match=message):
        load_scene(scene_file, {key: 1.0})


def test_unknown_name_suggests_the_nearest(monkeypatch):
    monkeypatch.setattr(loader, "library", lambda: {"slab_release": "..."})
    with pytest.raises(InputError, match="did you mean slab_release"):
        load_scene("slab_relaese")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"name = ", "not valid TOML"),
        (b"\xff\xfe\x00", "not a text file"),
        (b"x = " + b"[" * 100_000, "nested too deeply|not valid TOML"),
        (b"", "name is missing"),
    ],
    ids=["syntax", "binary", "deep", "empty"],
)
def test_files_that_are_no_scene(tmp_path, content, message):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        load_scene(path)
    assert str(caught.value).startswith(str(path))


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_scene(tmp_path / "none.toml")
    with pytest.raises(InputError, match="a folder"):
        load_scene(str(tmp_path))


def test_library_scenes_load_and_say_what_they_show():
    scenes = library()
    assert set(scenes) == {path.stem for path in FOLDER.glob("*.toml")}
    for name, text in scenes.items():
        assert len(text) > 20, f"{name}: the first comment line says what the scene shows"


def test_a_key_of_an_earlier_version(scene_file):
    """With the value that changed nothing, as resolved scenes have it, it is left out; else what to do is said."""
    assert load_scene(scene_file, {"solver.sleeping": 0.0}).solver == load_scene(scene_file).solver
    with pytest.raises(InputError, match=r'solver.sleeping = 0.01: was removed, .* initial.relaxation = "static"'):
        load_scene(scene_file, {"solver.sleeping": 0.01})
