"""What a run in 3-D has released, as the release of a flow."""

import pytest
from typer.testing import CliRunner

import snowmpm
from snowmpm import load_scene
from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.pit.released import released_by

pytest.importorskip("rasterio")
pytest.importorskip("pyogrio")

SCENE = """
name = "two_slabs"
dimension = 3
end_time = {end}

[output]
interval = {end}
fields = ["velocity", "material"{identity}]

[solver]
dx = 0.5
particles_per_cell = 8

[domain]
min = [0.0, 0.0, -1.0]
max = [40.0, 12.0, 32.0]

[terrain]
kind = "profile"
points = [[0.0, 29.0], [40.0, 0.0]]
contact = "separate"
friction = {friction}

[materials.snow]
kind = "elastic"
density = 200.0
youngs_modulus = 1.0e5
poisson_ratio = 0.3

[[bodies]]
name = "upper"
material = "snow"
shape = {{ kind = "layer", bottom = 0.0, top = 1.0, region = {{ x = [6.0, 12.0], y = [2.0, 10.0] }} }}

[[bodies]]
name = "lower"
material = "snow"
shape = {{ kind = "layer", bottom = 0.0, top = 1.0, region = {{ x = [20.0, 26.0], y = [2.0, 10.0] }} }}
"""


@pytest.fixture(scope="module")
def slid(tmp_path_factory):
    """Two slabs of 6 by 8 m in plan on 36 degrees, without friction: both go."""
    return _run(tmp_path_factory.mktemp("slid"))


def _run(folder, end=0.7, friction=0.0, identity=', "id"'):
    path = folder / "scene.toml"
    path.write_text(SCENE.format(end=end, friction=friction, identity=identity), encoding="utf-8")
    return snowmpm.run(load_scene(path), folder / "run")


def test_area_thickness_and_volume_are_those_of_the_bodies(slid):
    found = released_by(slid)
    assert found.area == pytest.approx(2 * 6.0 * 8.0, rel=0.12)  # of cells of a metre
    assert found.thickness == pytest.approx(1.0, rel=0.1)
    assert found.volume == pytest.approx(slid.hazard["numbers"]["release_volume"], rel=0.05)
    assert found.area == pytest.approx(found.slab, rel=0.02)
    assert found.edge == 1.0


def test_what_did_not_move_is_not_released(tmp_path):
    """On rough ground nothing goes."""
    with pytest.raises(InputError, match=r"released nothing: no part of the snow moved by more than 0.5 m until 0.7 s"):
        released_by(_run(tmp_path, friction=5.0))


def test_particles_must_be_told_apart(tmp_path):
    with pytest.raises(InputError, match=r'output.fields must have "id" and "material"'):
        released_by(_run(tmp_path, end=0.05, identity=""))


def test_a_flow_takes_the_raster_and_the_outline(slid, tmp_path):
    """The depth method starts with the volume that was released, from either file."""
    done = CliRunner().invoke(app, ["release", str(slid.path.parent), "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "released: " in done.output
    found = released_by(slid)
    row = " ".join(f"{29.0 - 0.725 * x:.4f}" for x in range(60))
    rows = "\n".join([row] * 40)
    (tmp_path / "dem.asc").write_text(f"ncols 60\nnrows 40\nxllcorner -0.5\nyllcorner -14.5\ncellsize 1\n{rows}\n")
    for top, region in (('"file"', '{ file = "release.gpkg" }'), ('{ file = "release.tif" }', None)):
        shape = f'{{ kind = "layer", top = {top}' + (f", region = {region} }}" if region else " }")
        scene = tmp_path / "flow.toml"
        scene.write_text(f"""
name = "flow"
dimension = 3
end_time = 0.1
[output]
interval = 0.1
[solver]
method = "depth"
dx = 0.5
[terrain]
kind = "dem"
file = "dem.asc"
friction = {{ law = "coulomb", mu = 0.3 }}
[materials.snow]
kind = "elastic"
density = 200.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[[bodies]]
name = "release"
material = "snow"
shape = {shape}
""", encoding="utf-8")
        run = snowmpm.run(load_scene(scene), tmp_path / "flow")
        assert run.hazard["numbers"]["release_volume"] == pytest.approx(found.volume, rel=0.03), top
