"""The project of `snowmpm maps` in QGIS itself: valid systems, a sensible scale, layers drawn, the sheet exported."""

import numpy as np
import pytest

pytest.importorskip("rasterio")
pytest.importorskip("pyogrio")

import snowmpm
from snowmpm.cli.maps import maps
from snowmpm.io import RunWriter
from tests.support.project import ROOT
from tests.support.qgis import in_qgis, needs_qgis
from tests.support.straight_avalanche import lambert, write_avalanche

pytestmark = needs_qgis
READER = ROOT / "tests" / "integrations" / "read_in_qgis.py"


@pytest.fixture(scope="module", params=["with a projection", "without one"])
def opened(request, tmp_path_factory):
    """What QGIS makes of the project of a run, and whether it has a projection."""
    folder, placed = tmp_path_factory.mktemp("run"), request.param == "with a projection"
    write_avalanche(folder / "run", crs=lambert() if placed else None)
    maps(str(folder / "run"), files="gis", quiet=True)
    return in_qgis(READER, [folder / "run" / "maps" / "avalanche.qgs", folder], folder), placed


def test_qgis_reads_it_without_a_warning(opened):
    found, placed = opened
    assert found["read"] and found["crs_valid"] and found["metres"]
    assert found["crs"] == ("EPSG:31287" if placed else "")
    assert "GeoPackage" not in found["stderr"] and "Invalid" not in found["stderr"], found["stderr"]
    assert all(one["valid"] and one["crs_valid"] for one in found["layers"].values()), found["layers"]
    assert found["errors"] == []


def test_its_scale_is_that_of_a_map(opened):
    """480 m over 800 pixels of 0.265 mm is about 1:3000; without a valid system it would be 1:300 000 000."""
    found, _ = opened
    assert 2000 < found["scale"] < 5000
    assert 1000 < found["layouts"][0]["map_scale"] < 10_000


def test_nothing_is_painted_where_there_is_no_snow(opened):
    """Release and deposit cover 1600 of the 19 100 m2 of the flow; over the rest of it they are zero."""
    layers = opened[0]["layers"]
    flow = layers["peak flow depth [m]"]["covered"]
    assert layers["release depth [m]"]["covered"] == pytest.approx(1600.0 / (480.0 * 40.0 - 100.0) * flow, rel=0.1)
    assert layers["depth at the end [m]"]["covered"] == pytest.approx(1600.0 / (480.0 * 40.0 - 100.0) * flow, rel=0.1)
    assert 0.05 < flow < 0.25


def test_the_sheet_shows_what_the_map_shows(opened):
    layout, = opened[0]["layouts"]
    assert layout["exported"]
    assert layout["legend"] == [name for name, one in opened[0]["layers"].items() if one["shown"] and name != "terrain"]


def test_a_layer_by_itself_brings_its_style(opened):
    """The thalweg is dashed (Qt.DashLine is 2), and its fields have units."""
    assert opened[0]["style_of_thalweg"] == 2
    assert opened[0]["layers"]["run-out point"]["aliases"]["runout"] == "run-out [m]"


def test_the_ground_is_shaded(tmp_path):
    scene = snowmpm.load_scene("avalanche_depth_averaged", {"solver.dx": 20.0, "end_time": 4.0})
    snowmpm.run(scene, tmp_path / "run")
    maps(str(tmp_path / "run"), files="gis", quiet=True)
    found = in_qgis(READER, [tmp_path / "run" / "maps" / "avalanche.qgs", tmp_path], tmp_path)
    assert found["layers"]["terrain"]["shown"] and found["layers"]["terrain"]["covered"] > 0.9
    assert found["covered"] > 0.9 and found["errors"] == []


def test_layers_over_time(tmp_path):
    """Nothing of the project is lost where it has layers for the time slider."""
    scene = snowmpm.load_scene("avalanche_depth_averaged", {"solver.dx": 20.0, "end_time": 3.0})
    snowmpm.run(scene, tmp_path / "run")
    maps(str(tmp_path / "run"), files="gis", over_time="gif", quiet=True)
    assert not list((tmp_path / "run" / "maps").glob("*.gif"))
    found = in_qgis(READER, [tmp_path / "run" / "maps" / "avalanche.qgs", tmp_path], tmp_path)
    assert sum("over time, t =" in name for name in found["layers"]) == len(list((tmp_path / "run" / "maps").glob(
        "over_time/*.tif"))) > 0
    assert all(one["valid"] for one in found["layers"].values())


def test_a_run_without_a_terrain_or_numbers_has_rasters_only(tmp_path):
    with RunWriter(tmp_path / "run", provenance={}) as writer:
        writer.map("peak_depth", np.ones((4, 5)), 0.0, 0.0, 1.0, "m")
    maps(str(tmp_path / "run"), files="gis", quiet=True)
    assert {path.name for path in (tmp_path / "run" / "maps").glob("[!.]*")} == {"peak_depth.tif", "peak_depth.qml"}
