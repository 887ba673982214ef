"""Bad input: exit code 2, one clear message, nothing written."""

import numpy as np
import pytest
import trimesh

from tests.support.slope_scene import SQUARE, raster_text, slope_scene


@pytest.fixture
def refused(call, tmp_path):
    """refused(arguments) -> the message, after checking that it is one, that the code is 2 and that no file came."""

    def invoke(*arguments):
        before = sorted(tmp_path.rglob("*"))
        result = call(*arguments)
        assert result.code == 2, result
        assert result.out == ""
        assert result.err.startswith("error: ")
        assert "Traceback" not in result.err
        assert 1 <= result.err.count("\n") <= 2
        assert sorted(tmp_path.rglob("*")) == before
        return result.err

    return invoke


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("solver.dxx=0.1", "solver.dxx = 0.1: unknown key; did you mean dx?"),
        ("solver.dx=coarse", 'solver.dx = "coarse": must be a number'),
        ("materials.snow.density=-300", "materials.snow.density = -300: must be > 0"),
        ("materials.snow.kind=ice", 'materials.snow.kind = "ice": must be one of'),
        ("terrain={kind='profile',points=[[0,0]]}", "terrain.points"),
        ("solver.kernel=hat", 'solver.kernel = "hat"'),
        ("solver.method=fem", 'solver.method = "fem"'),
        ("domain.max=[0.3,2.0]", "outside the domain"),
        ("bodies.0.shape={kind='layer',top=0.04}", "solver.dx <= 0.08"),
        ("bodies.0.shape={kind='layer',top=0.5,region={x=[50,60]}}", "terrain"),
        ("bodies=[]", "bodies = []: too few entries"),
    ],
)
def test_wrong_value(refused, block, command, setting, expected):
    message = refused(command, block, "--set", setting)
    assert expected in message
    assert str(block) in message


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (("check", "block.toml", "--set", "solver.dxx=1"), "dx"),
        (("check", "block.toml", "--set", "solver.transfer=apicc"), "apic"),
        (("check", "block.toml", "--set", "terrain.kind=plan"), "plane"),
        (("check", "block.toml", "--set", "materials.snow.kind=elastc"), "elastic"),
        (("check", "block.toml", "--set", "materials.snow.card=li_cold_dens"), "li_cold_dense"),
        (("check", "block.toml", "--set", "bodies.0.material=snwo"), "snow"),
        (("check", "block.toml", "--set", "bodies.0.shape.kind=bx"), "box"),
        (("check", "block.toml", "--set", 'output.fields=["velocty"]'), "velocity"),
        (("check", "block.toml", "--set", 'events=[{kind="remove",body="blck",start=1}]'), "block"),
        (("check", "blok.toml"), "block.toml"),
        (("check", "slab_releas"), "slab_release"),
        (("info", "runs/one_"), "runs/one"),
        (("element", "triaxal", "-m", "li_cold_dense"), "triaxial"),
        (("element", "triaxial", "-m", "li_cold_dens"), "li_cold_dense"),
        (("element", "triaxial", "-m", "kind=elastc"), "elastic"),
        (("element", "triaxial", "-m", "slab_release:slabb"), "slab"),
        (("new", "copy", "--like", "slab_relese"), "slab_release"),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value[:2]),
)
def test_nearest_name_is_suggested(refused, block, tmp_path, arguments, meant):
    (tmp_path / "runs" / "one").mkdir(parents=True)
    (tmp_path / "runs" / "one" / "run.vtkhdf").touch()
    message = refused(*arguments).strip()
    assert message.endswith(f"did you mean {meant}?"), message


@pytest.mark.parametrize(("arguments", "meant"), [(("rnu", "x"), "run"), (("run", "x", "--rendr"), "--render")])
def test_nearest_command_and_option_are_suggested(call, arguments, meant):
    refused = call(*arguments)
    assert refused.code == 2
    assert meant in refused.err


def test_step_too_long(refused, block):
    assert "solver.dt = 1.0: unstable" in refused("run", block, "--set", "solver.dt=1.0")
    # nu = 0.2 in 2-D: sqrt(1 - nu) of a cell
    message = refused("check", block, "--set", "solver.cfl=0.9")
    assert "solver.cfl = 0.9: unstable: must be at most 0.894 for apic" in message


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("run", "none.toml"), "none.toml: no such file"),
        (("run", "no_such_scene"), 'no scene "no_such_scene" in the library'),
        (("run", "block.toml", "--set", "solver.dx"), "must be KEY=VALUE"),
        (("run", "block.toml", "-o", "block.toml"), "must be a folder"),
        (("run", "block.toml", "-o", "block.toml/inside"), "must be a folder"),
        (("run", "block.toml", "--resume", "--overwrite"), "choose one"),
        (("run", "block.toml", "--backend", "cuda"), "--backend cuda: there is none here"),
        (("info", "nothing"), "no run file here"),
        (("render", "nothing"), "no run file here"),
        (("plot", "nothing"), "no run file here"),
        (("render", "nothing", "--size", "big"), "must be WIDTHxHEIGHT"),
    ],
)
def test_wrong_argument(refused, block, arguments, expected):
    assert expected in refused(*arguments)


@pytest.mark.parametrize(
    "arguments",
    [("run",), ("walk",), ("run", "x", "--threads", "0"), ("run", "x", "--precision", "f16"), ("run", "x", "--no"),
     ("render", "x", "-o"), ("export", "x", "--as", "abc"), ("campaign", "walk"), ("info", "x", "y")],
)
def test_wrong_usage(call, arguments):
    result = call(*arguments)
    assert result.code == 2 and not result.out
    assert result.err.startswith("error: ") and len(result.err.splitlines()) == 1, result.err


def test_a_scene_is_no_run(refused, block, tmp_path):
    assert "block.toml: is a scene, not a run; snowmpm run block.toml makes one" in refused("render", "block.toml")
    (tmp_path / "runs" / "block").mkdir(parents=True)
    (tmp_path / "runs" / "block" / "run.vtkhdf").touch()
    assert "did you mean runs/block?" in refused("info", "block.toml")


def scene(folder, kind="mesh", file="slope.stl", region=SQUARE):
    path = folder / "three.toml"
    path.write_text(slope_scene(file, kind, region, end_time=0.1))
    return path


def slope(folder):
    """A square of 10 m by 10 m, tilted."""
    corners = [[0, 0, 5], [10, 0, 0], [10, 10, 0], [0, 10, 5]]
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False).export(folder / "slope.stl")


def raster(folder, value):
    (folder / "alps.asc").write_text(raster_text(np.full((12, 12), value)))


def test_a_good_slope_is_accepted(call, tmp_path):
    # The other tests of this file differ from this one in one fact each.
    slope(tmp_path)
    result = call("check", scene(tmp_path))
    assert (result.code, result.err) == (0, "")
    assert "release" in result.out


def test_missing_terrain(refused, tmp_path):
    message = refused("run", scene(tmp_path))
    assert 'terrain.file = "slope.stl": no such file' in message


@pytest.mark.parametrize(
    "content", [b"", b"solid empty\nendsolid empty\n", b"\x00" * 84], ids=["empty", "ascii", "binary"]
)
def test_mesh_without_triangles(refused, tmp_path, content):
    (tmp_path / "slope.stl").write_bytes(content)
    message = refused("run", scene(tmp_path))
    assert "slope.stl" in message


def test_raster_of_no_data(refused, tmp_path):
    raster(tmp_path, -9999)
    message = refused("run", scene(tmp_path, "dem", "alps.asc"))
    assert "alps.asc" in message


@pytest.mark.parametrize(
    "region",
    [
        "{ x = [20, 30], y = [2, 8] }",
        "{ polygon = [[20, 2], [30, 2], [30, 8]] }",
        "{ polygon = [[8, 2], [13, 2], [13, 8]] }",
    ],
)
def test_release_off_the_terrain(refused, tmp_path, region):
    slope(tmp_path)
    assert "terrain" in refused("run", scene(tmp_path, region=region))


def test_body_without_particles(refused, block):
    # A sphere that no point of the lattice falls into.
    setting = "bodies.0.shape={kind='polygon',points=[[0,1],[1,1],[2,1]]}"
    refused("run", block, "--set", setting)
