"""Runs that are cut before the snow rests, or lose it over an edge, say so in everything that is made of them; maps lie
on the raster's cells."""

import csv
import json

import numpy as np
import pytest
import shapely

import snowmpm
from snowmpm.cli.app import app
from snowmpm.io.status import status_of
from snowmpm.quantities.table import quantity
from snowmpm.render import render_report
from snowmpm.scenes.library import FOLDER as LIBRARY

SETTINGS = {"solver.dx": 7.5, "bodies.0.shape.top": 5.0, "end_time": 8.0, "output.interval": 2.0,
            "materials.snow.youngs_modulus": 3e5, "materials.snow.hardening": 10.0}


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """The library's avalanche, stopped after eight seconds."""
    return snowmpm.run(snowmpm.load_scene("avalanche_on_raster", SETTINGS), tmp_path_factory.mktemp("cut"))


def test_the_summary_says_so(cut):
    summary = cut.summary["status"]
    assert summary["final"] is False and summary["at_rest"] is False and summary["moving_share"] > 0.9
    assert summary["status"].startswith("NOT FINAL: Still moving at 8 s") and summary == status_of(cut).record()
    assert cut.hazard["numbers"]["moving_share"] == pytest.approx(summary["moving_share"])


def test_map_cells_are_those_of_the_raster(cut, tmp_path):
    """valley.asc has cells of 10 m from 600000, 200000 on; a run on a part of it has the same cells."""
    corners = set()
    for name, raster in cut.maps.items():
        low = np.array([raster.x0, raster.y0]) + cut.origin[:2] - 0.5 * raster.cell
        corners.add((raster.cell, raster.values.shape, *np.round(low, 6).tolist()))
        assert raster.cell % 10.0 == 0.0, name
    assert len(corners) == 1
    cell, _, x, y = corners.pop()
    assert x % cell == 0.0 and y % cell == 0.0
    domain = {"min": [600033.0, 200047.0, 1100.0], "max": [600777.0, 200455.0, 1900.0]}
    part = {**SETTINGS, "end_time": 0.1, "domain": domain}
    other = snowmpm.run(snowmpm.load_scene("avalanche_on_raster", part), tmp_path).maps["release_depth"]
    assert other.cell == cell


@pytest.mark.parametrize("ending", ["html", pytest.param("pdf", marks=pytest.mark.slow)])
def test_the_report_says_so(cut, tmp_path, ending):
    pages = render_report(cut, tmp_path / f"report.{ending}", interactive=False, size=(320, 160))
    content = pages.read_bytes()
    if ending == "pdf":
        assert content.startswith(b"%PDF") and content.count(b"/Type /Page\n") + content.count(b"/Type /Page ") >= 3
        assert [entry.name for entry in tmp_path.iterdir()] == ["report.pdf"]
        return
    text = content.decode()
    assert "NOT FINAL: Still moving at 8 s" in text and "run-out so far" in text
    numbers = cut.hazard["numbers"]
    shown = quantity("runout").text(numbers["runout"], 0.5 * cut.maps["peak_depth"].cell)
    assert "±" in shown and shown in text and 'href="#runout" title="Length in plan of the thalweg' in text
    assert 'id="runout"' in text and "deposit volume, at release density" in text


def test_every_file_of_the_maps_says_so(cut, tmp_path):
    rasterio = pytest.importorskip("rasterio")
    pyogrio = pytest.importorskip("pyogrio")
    from typer.testing import CliRunner

    result = CliRunner().invoke(app, ["maps", str(cut.path.parent), "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "NOT FINAL: Still moving at 8 s" in result.output
    for name in cut.maps:
        with rasterio.open(tmp_path / f"{name}.tif") as file:
            assert file.tags()["final"] == "False" and "Still moving" in file.tags()["status"]
            assert file.transform.a % 10.0 == 0.0 and file.bounds.left % file.transform.a == 0.0
    assert json.loads((tmp_path / "avalanche.json").read_text())["final"] is False
    assert not (tmp_path / "avalanche.geojson").exists()  # the valley has no projection
    areas = {}
    for layer in (name for name, kind in pyogrio.list_layers(tmp_path / "avalanche.gpkg") if kind):  # styles have none
        meta, _, _, columns = pyogrio.raw.read(tmp_path / "avalanche.gpkg", layer=layer)
        fields = dict(zip(meta["fields"], columns, strict=True))
        assert not any(fields["final"])
        areas[layer] = float(np.sum(fields.get("area_m2", 0.0)))
    numbers = cut.hazard["numbers"]
    polygons = json.loads((LIBRARY / "valley_release.geojson").read_text())["features"]
    drawn = sum(shapely.geometry.shape(feature["geometry"]).area for feature in polygons)
    assert areas["release"] == pytest.approx(numbers["release_area"], abs=0.01) == pytest.approx(drawn, rel=1e-6)
    assert areas["deposit"] == pytest.approx(numbers["deposit_area"])
    assert areas["pressure_classes"] == areas["affected_area"] == pytest.approx(numbers["affected_area"])
    with open(tmp_path / "avalanche.csv", encoding="utf-8", newline="") as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    assert rows["status"]["value"].startswith("NOT FINAL")
    half = 0.5 * cut.maps["peak_depth"].cell
    assert float(rows["runout"]["resolution"]) == pytest.approx(half, rel=0.01)
    assert float(rows["runout"]["value"]) == pytest.approx(cut.hazard["numbers"]["runout"], abs=half)
    assert "No hazard assessment." in rows["statement"]["value"]
    with open(tmp_path / "areas.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["final"] for row in rows} == {"False"}
    for name in cut.hazard["classes"]:
        total = sum(float(row["area_m2"]) for row in rows if row["map"] == name)
        assert total == pytest.approx(numbers["deposit_area" if name == "deposit_depth" else "affected_area"])


def test_what_leaves_over_an_edge_is_told(tmp_path):
    """The domain ends in the middle of the release's own lower edge: half of the snow is soon gone."""
    upper = snowmpm.Simulation(snowmpm.load_scene("avalanche_on_raster", SETTINGS)).particles["position"].max(axis=0)
    domain = {"min": [600005.0, 200005.0, 1000.0], "max": [float(upper[0]) + 10.0, 200500.0, 2000.0]}
    settings = SETTINGS | {"domain": domain}
    run = snowmpm.run(snowmpm.load_scene("avalanche_on_raster", settings), tmp_path)
    status = status_of(run)
    assert status.left_share > 0.01 and any("of the mass left the model" in line for line in status.warnings)
    assert run.hazard["numbers"]["left_share"] == pytest.approx(status.left_share, rel=1e-6)
