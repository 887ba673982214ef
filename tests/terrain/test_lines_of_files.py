"""Crests of dams and profiles from files, written out in the resolved scene."""

import json

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene
from snowmpm.seeding.region_files import read_lines
from snowmpm.terrain import load_terrain

shapefile, pyogrio = pytest.importorskip("shapefile"), pytest.importorskip("pyogrio")

LINES = [[[200.0, 60.0], [200.0, 140.0]], [[260.0, 60.0], [280.0, 100.0], [260.0, 140.0]]]

SCENE = """
name = "path"
dimension = 3
end_time = 1.0
output = { interval = 1.0 }
solver = { method = "depth", dx = 10.0 }
materials.snow = { kind = "elastic", density = 200.0, youngs_modulus = 1e6, poisson_ratio = 0.3 }
[terrain]
kind = "dem"
file = "dem.asc"
friction = 0.3
dams = [{ name = "dam", file = "FILE", height = 12.0, crest_width = 20.0 }]
[[bodies]]
name = "release"
material = "snow"
shape = { kind = "layer", bottom = 0.0, top = 1.0, region = { x = [50.0, 90.0], y = [60.0, 120.0] } }
"""


def written(path, lines):
    if path.suffix == ".shp":
        with shapefile.Writer(str(path)) as writer:
            writer.field("name", "C", 10)
            for line in lines:
                writer.line([line])
                writer.record("d\xfc")
    elif path.suffix == ".gpkg":
        import shapely

        pyogrio.raw.write(path, shapely.to_wkb([shapely.LineString(line) for line in lines]), [], [],
                          geometry_type="LineString", driver="GPKG", layer="dams", crs=None)
    else:
        features = [{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": line}}
                    for line in lines]
        path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


@pytest.fixture
def folder(tmp_path):
    x = 10.0 * np.arange(40)
    z = np.tile(300.0 - 0.6 * x, (20, 1))
    (tmp_path / "dem.asc").write_text("ncols 40\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
                                      + "\n".join(" ".join(f"{v:.2f}" for v in row) for row in z))
    return tmp_path


@pytest.mark.parametrize("kind", ["shp", "geojson", "gpkg"])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_lines_of_every_format(tmp_path, kind):
    found = read_lines(written(tmp_path / f"dams.{kind}", LINES), "file")
    assert [line.tolist() for line in found] == LINES


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_dams_of_a_file_are_those_of_their_lines(folder):
    written(folder / "dams.geojson", LINES)
    (folder / "scene.toml").write_text(SCENE.replace("FILE", "dams.geojson"))
    scene = load_scene(folder / "scene.toml")
    assert [(dam.name, [list(p) for p in dam.line], dam.line_source) for dam in scene.terrain.dams] == [
        ("dam_1", LINES[0], "dams.geojson"), ("dam_2", LINES[1], "dams.geojson")]
    by_hand = ", ".join(f'{{ name = "{i}", line = {line}, height = 12.0, crest_width = 20.0 }}'
                        for i, line in enumerate(LINES))
    of_file = '{ name = "dam", file = "FILE", height = 12.0, crest_width = 20.0 }'
    (folder / "hand.toml").write_text(SCENE.replace(of_file, by_hand))
    surfaces = [load_terrain(one.terrain, folder, dimension=3) for one in (scene, load_scene(folder / "hand.toml"))]
    assert (surfaces[0].vertices == surfaces[1].vertices).all()
    (folder / "resolved.toml").write_text(scene.to_toml())  # a run reads no other file
    (folder / "dams.geojson").unlink()
    assert load_scene(folder / "resolved.toml").terrain.dams == scene.terrain.dams


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("change", "words"), [
    (("FILE", "no.shp"), "terrain.dams.0.file.*no such file"), (('file = "FILE"', 'height_ = 1'), "terrain.dams.0"),
    (('file = "FILE", ', ""), r"terrain.dams.0.line is missing: corners \[x, y\] of its crest \[m\], or file"),
    (('file = "FILE"', 'file = "dams.geojson", line = [[0.0, 0.0], [1.0, 1.0]]'), "does not go with line"),
    (("FILE", "areas.geojson"), "holds no line")])
def test_what_is_wrong_is_said(folder, change, words):
    written(folder / "dams.geojson", LINES)
    ring = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 0.0]]
    (folder / "areas.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    (folder / "scene.toml").write_text(SCENE.replace(*change))
    with pytest.raises(InputError, match=words):
        load_scene(folder / "scene.toml")


PROFILE = """
name = "slope"
dimension = 2
end_time = 1.0
output = { interval = 1.0 }
solver = { dx = 0.5 }
terrain = { kind = "profile", file = "profile.csv", friction = 0.3 }
materials.snow = { kind = "elastic", density = 200.0, youngs_modulus = 1e6, poisson_ratio = 0.3 }
[[bodies]]
name = "slab"
material = "snow"
shape = { kind = "layer", bottom = 0.0, top = 2.0, region = { x = [2.0, 9.0] } }
"""


def test_a_profile_of_a_file(tmp_path):
    (tmp_path / "profile.csv").write_text("x [m], z [cm]\n0, 2000\n10, 1400\n30, 1000\n")
    (tmp_path / "scene.toml").write_text(PROFILE)
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.terrain.points == ((0.0, 20.0), (10.0, 14.0), (30.0, 10.0))
    assert scene.terrain.points_source == "profile.csv"
    (tmp_path / "resolved.toml").write_text(scene.to_toml())
    (tmp_path / "profile.csv").unlink()
    assert load_scene(tmp_path / "resolved.toml").terrain.points == scene.terrain.points


@pytest.mark.parametrize(("text", "words"), [
    ("x, y\n0, 1\n2, 3\n", "terrain.file.*column y: must be one of x, z"), ("x\n0\n1\n", "needs columns x and z"),
    ("x, z\n0, 1\n0, 3\n", "x must grow"), ("x, z [kg]\n0, 1\n1, 3\n", "unit 'kg'")])
def test_a_profile_that_is_none(tmp_path, text, words):
    (tmp_path / "profile.csv").write_text(text)
    (tmp_path / "scene.toml").write_text(PROFILE)
    with pytest.raises(InputError, match=words):
        load_scene(tmp_path / "scene.toml")
