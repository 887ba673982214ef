"""`snowmpm maps` and what `snowmpm info` says of an avalanche."""

import csv
import sys

import numpy as np
import pytest

from snowmpm.io import RunWriter


@pytest.fixture
def avalanche(tmp_path):
    """A run with maps and a thalweg, without particles."""
    folder = tmp_path / "avalanche"
    with RunWriter(folder, provenance={"scene_name": "valley"}, origin=[6e5, 2e5, 1e3]) as writer:
        depth = np.zeros((12, 30))
        depth[4:8, 2:26] = 1.0
        for name, unit in (("release_depth", "m"), ("peak_depth", "m"), ("peak_pressure", "Pa")):
            values = depth * (np.arange(30) < 8) if name == "release_depth" else depth
            writer.map(name, values * (5e3 if unit == "Pa" else 1.0), 5.0, 5.0, 10.0, unit)
        s = np.arange(0.0, 250.0, 10.0)
        profile = {"s": s, "x": 6e5 + 25.0 + s, "y": np.full(25, 2e5 + 60.0), "z": 1200.0 - 0.4 * s,
                   "peak_depth": np.ones(25), "peak_speed": np.ones(25), "peak_pressure": np.full(25, 5e3),
                   "deposit_depth": np.zeros(25)}
        writer.hazard({"numbers": {"runout": 230.0, "fall": 92.0, "top": 1200.0, "travel_angle": 21.8,
                                   "runout_x": 600255.0, "runout_y": 200060.0, "runout_z": 1108.0,
                                   "area_above_1_kPa": 9600.0, "flow_depth": 0.1},
                       "profile": {name: values.tolist() for name, values in profile.items()},
                       "runout_line": [[600255.0, 200030.0], [600255.0, 200090.0]]})
    return folder


def test_maps_are_written_and_numbers_said(call, avalanche):
    pytest.importorskip("rasterio")
    result = call("maps", avalanche)
    assert result.code == 0, result.err
    written = {path.name for path in (avalanche / "maps").glob("[!.]*")}
    names = ("release_depth", "peak_depth", "peak_pressure")
    assert written == {*(f"{name}.{kind}" for name in names for kind in ("tif", "qml", "png")), "thalweg.png",
                       *(f"avalanche.{kind}" for kind in ("gpkg", "qgs", "csv", "json")), "areas.csv"}
    assert "no avalanche.geojson: the terrain names no coordinate system" in result.out
    for words in ("run-out 230 ± 5 m", "travel angle 21.8 ± 0.6°", "10 000 ± 2000 m²", "600255 ± 5 m",
                  "NOT FINAL: Whether the snow is at rest is not known"):
        assert words in " ".join(result.out.split()), result.out


def test_without_rasterio_the_pictures_are_left(call, avalanche, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    refused = call("maps", avalanche)
    assert refused.code == 2 and "snowmpm[gis]" in refused.err and "--files pictures" in refused.err
    result = call("maps", avalanche, "--files", "pictures", "-o", tmp_path / "drawn")
    assert result.code == 0 and not list((tmp_path / "drawn").glob("*.tif"))
    assert (tmp_path / "drawn" / "peak_depth.png").stat().st_size > 1000


def test_files_for_a_gis_without_pictures(call, avalanche, tmp_path):
    pytest.importorskip("rasterio")
    result = call("maps", avalanche, "--files", "gis", "-o", tmp_path / "gis")
    assert result.code == 0 and not list((tmp_path / "gis").glob("*.png"))
    assert {"peak_depth.tif", "peak_depth.qml", "avalanche.qgs", "avalanche.gpkg"} <= {
        path.name for path in (tmp_path / "gis").iterdir()}
    old = call("maps", avalanche, "--pictures", "-o", tmp_path / "old")
    assert old.code == 0 and "warning: --pictures is now --files pictures" in old.err
    assert not list((tmp_path / "old").glob("*.tif"))


def test_info_says_how_far_it_came(call, avalanche):
    result = call("info", avalanche)
    assert result.code == 0 and "run-out" in result.out and "peak_pressure [Pa]" in result.out


def test_a_run_without_maps(call, tmp_path):
    with RunWriter(tmp_path / "flat", provenance={}, dimension=2):
        pass
    result = call("maps", tmp_path / "flat")
    assert result.code == 2 and "three dimensions" in result.err


def test_definitions_of_every_number_are_a_command_away(call):
    from snowmpm.quantities.table import QUANTITIES

    result = call("maps", "--definitions")
    assert result.code == 0
    told = " ".join(result.out.split())
    for one in QUANTITIES.values():
        assert f"{one.name}: {one.label}" in told and " ".join(one.definition.split()) in told


def test_what_was_seen_is_scored(call, avalanche):
    """The flow covers x = 20 to 260 m, y = 40 to 80 m of the fixture; seen were x = 20 to 220 m, y = 50 to 90 m."""
    import json

    pytest.importorskip("rasterio")
    ring = [[600020.0, 200050.0], [600220.0, 200050.0], [600220.0, 200090.0], [600020.0, 200090.0]]
    seen = avalanche / "seen.geojson"
    seen.write_text(json.dumps({"type": "Polygon", "coordinates": [[*ring, ring[0]]]}))
    result = call("maps", avalanche, "--observed", seen)
    assert result.code == 0, result.err
    assert "affected area against seen.geojson" in result.out
    # 200 x 30 m hit, 200 x 10 m missed, 9600 - 6000 m2 too much
    for words in ("hit area 6000 m²", "missed area 2000 m²", "false area 3600 m²", "critical success index 51.7 %",
                  "hit rate 75 %", "area ratio 1.20"):
        assert words in " ".join(result.out.split()), result.out
    record = json.loads((avalanche / "maps" / "avalanche.json").read_text())
    assert record["observed"][0]["runout_difference"] == pytest.approx(40.0)
    rows = {row["name"]: row for row in csv.DictReader((avalanche / "maps" / "avalanche.csv").open())}
    assert float(rows["observed.affected_area.hit_area"]["value"]) == pytest.approx(6000.0)
    assert rows["observed.affected_area.hit_area"]["unit"] == "m2"
    assert float(rows["observed.affected_area.runout_difference"]["value"]) == pytest.approx(40.0)
    assert rows["runout"]["resolution"] == "5" and "No hazard assessment" in rows["statement"]["value"]
    refused = call("maps", avalanche, "--observed", seen, "--files", "pictures")
    assert refused.code == 2 and "--observed" in refused.err
    missing = call("maps", avalanche, "--observed", avalanche / "nothing.shp")
    assert missing.code == 2 and "nothing.shp" in missing.err
