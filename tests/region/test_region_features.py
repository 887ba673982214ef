"""What a region may be given besides: an area of interest, exposed layers, forest that brakes, classes of friction,
release areas and thickness from files."""

import csv
import json

import numpy as np
import pytest

from snowmpm.campaigns.work import start_quietly
from snowmpm.region import exposure, jobs, launch, plan, preparing
from snowmpm.region.elevations import open_elevations
from snowmpm.region.spec import read_region

pytest.importorskip("distributed")

CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::21781"}}


def geojson(path, shapes, kind="Polygon", **fields):
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": CRS, "features": [
        {"type": "Feature", "properties": {"name": f"place {k}", **fields},
         "geometry": {"type": kind, "coordinates": shape}} for k, shape in enumerate(shapes)]}))
    return path


def square(x, y, half):
    return [[[x + a * half, y + b * half] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]]


@pytest.fixture
def setting(region_file, tmp_path):
    """The region without anything else, before its runs."""
    start_quietly("cpu", 1)
    return preparing.make(read_region(region_file()), tmp_path / "plain")


def record_of(setting, k=0):
    job = list(plan.jobs(setting))[k]
    return jobs.work_on(job), job


def maps_of(setting, job):
    with np.load(plan.results_of(setting.folder, job.hash) / "maps.npz") as found:
        return {name: found[name] for name in found.files}


def test_only_what_can_reach_the_area_of_interest_is_run(setting, region_file, tmp_path, scheduler):
    areas = list(plan.read_areas(setting.folder, "rare"))
    place = areas[plan.chosen(len(areas), 4)[0] - 1].geometry.centroid
    geojson(tmp_path / "town.geojson", [square(place.x, place.y, 20.0)])
    path = region_file()
    path.write_text('area_of_interest = "town.geojson"\n' + path.read_text())
    found = launch.run_region(read_region(path), tmp_path / "out", scheduler=scheduler)
    counts = launch.counts(found)["rare"]
    assert counts["done"] >= 1 and counts["out_of_reach"] >= 1 and counts["done"] + counts["out_of_reach"] == 4


def test_what_is_exposed(setting, region_file, tmp_path, scheduler):
    """Houses in and beside the flow, a road through it: the largest pressure over their cells."""
    _, job = record_of(setting)
    maps = maps_of(setting, job)
    pressure = np.nan_to_num(maps["peak_pressure"])
    row, column = np.unravel_index(pressure.argmax(), pressure.shape)
    x, y = maps["corner"] + 20.0 * (np.array([column, row]) + 0.5)
    geojson(tmp_path / "houses.geojson", [square(x, y, 5.0), square(600_020.0, 200_020.0, 5.0)])
    geojson(tmp_path / "roads.geojson", [[[x - 300.0, y], [x + 300.0, y]]], "LineString")
    path = region_file()
    path.write_text('exposed = ["houses.geojson", "roads.geojson"]\n' + path.read_text())
    found = launch.run_region(read_region(path), tmp_path / "out", scheduler=scheduler)
    folder = found.folder / plan.MAPS
    rows = list(csv.DictReader((folder / exposure.TABLE).open()))
    house = next(one for one in rows if one["layer"] == "houses" and one["feature"] == "1")
    assert house["name"] == "place 0" and float(house["once_in_years"]) == 100.0
    assert float(house["pressure_kpa_rare"]) == pytest.approx(pressure.max() / 1e3, rel=1e-3)
    assert int(house["class"]) == 1 + np.digitize(pressure.max(), [1e3, 3e3, 1e4, 3e4])
    assert float(house["frequency"]) == pytest.approx(0.01)
    other = next(one for one in rows if one["layer"] == "houses" and one["feature"] == "2")
    assert other["class"] == "0" and other["pressure_kpa_rare"] == ""
    road = next(one for one in rows if one["layer"] == "roads")
    assert road["name"] == "place 0" and float(road["pressure_kpa_rare"]) >= float(house["pressure_kpa_rare"])
    assert (folder / exposure.OUTLINES).is_file() and "houses" in (folder / "index.html").read_text()


def test_forest_brakes(setting, region_file, tmp_path):
    with open_elevations(setting.terrain) as elevations:
        west, south, east, north = elevations.grid.bounds
    geojson(tmp_path / "forest.geojson", [square(0.5 * (west + east), 0.5 * (south + north), 5000.0)])
    more = '[forest]\nfile = "forest.geojson"\nprotects = false\ndrag = 0.05'
    forested = preparing.make(read_region(region_file(more)), tmp_path / "out")
    assert forested.areas == setting.areas
    (plain, _), (braked, job) = record_of(setting), record_of(forested)
    assert plain["status"] == braked["status"] == "done"
    assert braked["numbers"]["largest_flow_speed"] < 0.9 * plain["numbers"]["largest_flow_speed"]
    assert not list((forested.folder / "runs").rglob("*")) or job.keep == "results"
    assert "no release areas" in _refused(region_file('[forest]\nfile = "forest.geojson"', name="b.toml"), tmp_path)


def _refused(path, tmp_path):
    from snowmpm.errors import InputError

    with pytest.raises(InputError) as found:
        preparing.make(read_region(path), tmp_path / "refused")
    return str(found.value)


def test_classes_of_friction_are_those_of_one_number_where_all_are_alike(setting, region_file, tmp_path):
    """Equal numbers in all classes, as rasters: the flow with these numbers."""
    path = region_file()
    rows = ", ".join(f'{{ terrain = "{kind}", mu = 0.155, xi = 4000.0 }}' for kind in (
        "open", "channelled", "gully", "flat"))
    path.write_text(path.read_text().replace('card = "voellmy_avaframe"', f"classes = [{rows}]"))
    classes = preparing.make(read_region(path), tmp_path / "classes")
    (one, first), (other, second) = record_of(setting), record_of(classes)
    assert other["status"] == "done", other["reason"]
    assert first.hash != second.hash
    assert other["numbers"]["runout"] == pytest.approx(one["numbers"]["runout"], abs=20.0)
    assert other["numbers"]["largest_flow_speed"] == pytest.approx(one["numbers"]["largest_flow_speed"], rel=1e-3)
    path.write_text(path.read_text().replace("mu = 0.155", "mu = 0.3"))
    slower, _ = record_of(preparing.make(read_region(path), tmp_path / "rough"))
    assert slower["numbers"]["largest_flow_speed"] < 0.95 * one["numbers"]["largest_flow_speed"]


def test_areas_and_thickness_from_files(setting, region_file, tmp_path, raster):
    """The areas of one region as the file of another, and a raster of thickness."""
    first = plan.read_area(setting.folder, "rare", 1)
    file = plan.areas_file(setting.folder, "rare")
    with open_elevations(setting.terrain) as elevations:
        grid = elevations.grid
    depth = raster(np.full((grid.rows, grid.columns), 1.25), cell=grid.cell, name="depth.tif")
    path = region_file()
    text = path.read_text().replace("thickness = { three_day_snow = 1.6 }", f'file = "{file}"')
    path.write_text(text)
    given = preparing.make(read_region(path), tmp_path / "given")
    own = plan.read_area(given.folder, "rare", 1)
    assert own.thickness == first.thickness
    assert own.area == pytest.approx(first.area) and own.slope == pytest.approx(first.slope, abs=1.5)
    assert own.surface == pytest.approx(first.surface, rel=0.02)
    path.write_text(text.replace(f'file = "{file}"', f'file = "{file}"\nthickness = {{ file = "{depth.name}" }}'))
    given = preparing.make(read_region(path), tmp_path / "depth")
    assert plan.read_area(given.folder, "rare", 1).thickness == pytest.approx(1.25)


def test_a_folder_is_whole_without_its_sources(region_file, tmp_path):
    """Runs need the folder only, wherever it is."""
    import shutil

    path = region_file()
    made = preparing.make(read_region(path), tmp_path / "made")
    moved = tmp_path / "moved"
    shutil.move(made.folder, moved)
    (tmp_path / "massif.tif").unlink()
    setting = plan.read_setting(moved)
    record, _ = record_of(setting)
    assert record["status"] == "done"
    assert str(tmp_path) not in (moved / plan.FILE).read_text() + (moved / plan.SETTING).read_text()


def test_polygons_are_run_as_they_are_drawn(region_file, tmp_path):
    """Alternatives that overlap, one in another; and one that reaches beyond the terrain by a little, or by half."""
    text = region_file().read_text()
    x, y = 602_000.0, 202_000.0
    geojson(tmp_path / "own.geojson", [square(x, y, 100.0), square(x + 100.0, y, 100.0), square(x, y, 30.0)],
            thickness=1.0)
    path = tmp_path / "own.toml"
    path.write_text(text.replace("thickness = { three_day_snow = 1.6 }", 'file = "own.geojson"'))
    made = preparing.make(read_region(path), tmp_path / "own")
    assert made.areas["rare"] == 3
    assert [round(one.area) for one in plan.read_areas(made.folder, "rare")] == [40_000, 40_000, 3600]
    geojson(tmp_path / "own.geojson", [square(600_098.0, y, 100.0)], thickness=1.0)
    made = preparing.make(read_region(path), tmp_path / "edge")
    record, _ = record_of(made)
    assert record["status"] == "done", record["reason"]
    geojson(tmp_path / "own.geojson", [square(x, y, 100.0), square(600_000.0, y, 100.0)], thickness=1.0)
    assert "polygon 2: 50 % of it lies off the terrain" in _refused(path, tmp_path)
    geojson(tmp_path / "own.geojson", [square(x, y, 100.0)], thickness=40.0)
    assert "must be at most 10 m" in _refused(path, tmp_path)


def test_a_raster_of_thickness_counts_zeros_and_is_in_the_same_system(region_file, tmp_path, raster, terrain):
    with open_elevations(terrain) as elevations:
        shape = elevations.grid.rows, elevations.grid.columns
    half = np.tile([[1.5], [0.0]], (shape[0] // 2, shape[1]))
    text = region_file().read_text()
    path = tmp_path / "own.toml"
    path.write_text(text.replace("{ three_day_snow = 1.6 }", '{ file = "half.tif" }'))
    raster(half, cell=10.0, name="half.tif")
    made = preparing.make(read_region(path), tmp_path / "half")
    assert plan.read_area(made.folder, "rare", 1).thickness == pytest.approx(0.75, abs=0.1)
    raster(half, cell=10.0, name="half.tif", system="EPSG:32632")
    assert "gdalwarp" in _refused(path, tmp_path)


def test_exposed_layers_are_read_first(region_file, tmp_path):
    path = region_file()
    path.write_text('exposed = ["far.geojson"]\n' + path.read_text())
    geojson(tmp_path / "far.geojson", [square(0.0, 0.0, 5.0)])
    assert "lies beside the terrain" in _refused(path, tmp_path)
    geojson(tmp_path / "far.geojson", [])
    assert "exposed" in _refused(path, tmp_path)
