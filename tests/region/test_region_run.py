"""A small region from its file to its maps: the same maps as its runs, whatever died meanwhile."""

import json

import numpy as np
import pytest
import rasterio

from snowmpm.campaigns.work import MAPS as RUN_MAPS
from snowmpm.errors import InputError
from snowmpm.region import journal, launch, maps, plan
from snowmpm.region.spec import read_region
from tests.support.region import TEXT

pytest.importorskip("distributed")

MORE = """
[scenarios.frequent]
period = 10.0
thickness = {{ three_day_snow = 0.9 }}
[samples]
runs = 2
""".replace("{{", "{").replace("}}", "}")


@pytest.fixture(scope="module")
def done(terrain, tmp_path_factory, scheduler):
    """A region that was run, and its folder."""
    folder = tmp_path_factory.mktemp("region")
    (folder / "massif.tif").write_bytes(terrain.read_bytes())
    (folder / "region.toml").write_text('zones = "switzerland"\n' + TEXT.format(more=MORE))
    said = []
    file = read_region(folder / "region.toml")
    setting = launch.run_region(file, folder / "out", scheduler=scheduler, say=said.append)
    return setting, said


def band(setting, name):
    with rasterio.open(setting.folder / plan.MAPS / f"{name}.tif") as file:
        return file.read(1, masked=True), file


def runs_of(setting, scenario):
    """(index, cells of the maps, peaks (3, rows, columns) over the whole region) of each run of a scenario."""
    index = journal.index_of(setting.folder, list(setting.areas))
    grid = maps.grid_of(setting)
    for k in np.flatnonzero(index.scenario == index.names.index(scenario)):
        whole = np.zeros((3, grid.rows, grid.columns))
        with np.load(plan.results_of(setting.folder, index.name_of(k)) / RUN_MAPS) as own:
            peaks = np.nan_to_num([own[kind] for kind in ("peak_depth", "peak_speed", "peak_pressure")])
            column, row = np.round((own["corner"] - [grid.west, grid.bounds[1]]) / grid.cell).astype(int)
        south = whole[:, ::-1]  # rows from the south, as the file has them
        south[:, row : row + peaks.shape[1], column : column + peaks.shape[2]] = np.where(
            peaks[0] >= index.flow_depth[k], peaks, 0.0)
        yield int(index.area[k]), whole


def test_every_run_is_done(done):
    setting, said = done
    counts = launch.counts(setting)
    assert {name: one["done"] for name, one in counts.items()} == {"rare": 8, "frequent": 8}
    assert any("16 runs, " in line and "of disk" in line for line in said)
    lines = list(launch.told(setting))
    assert any("a trial: only 4 of" in line and warns for line, warns in lines)
    assert any("still moved at flow.end_time" in line and warns for line, warns in lines)
    assert all(one["failed"] == 0 for one in counts.values())


@pytest.mark.parametrize("scenario", ["rare", "frequent"])
def test_maps_are_those_of_the_runs(done, scenario):
    """Peaks, number of releases and probability, from the runs one by one without tiles."""
    setting, _ = done
    peaks, hits = None, {}
    for area, whole in runs_of(setting, scenario):
        peaks = whole if peaks is None else np.maximum(peaks, whole)
        hits[area] = hits.get(area, 0) + (whole[0] > 0.0)
    for kind, expected in zip(("peak_depth", "peak_speed", "peak_pressure"), peaks, strict=True):
        found, _ = band(setting, f"{kind}_{scenario}")
        reached = sum(hits.values()) > 0
        assert ((~np.ma.getmaskarray(found)) == reached).all()
        assert np.array_equal(found.filled(0.0), np.where(reached, expected, 0.0).astype(np.float32))
    assert np.array_equal(band(setting, f"releases_{scenario}")[0].filled(0.0), sum(one > 0 for one in hits.values()))
    survives = np.prod([1.0 - one / 2.0 for one in hits.values()], axis=0)
    assert np.allclose(band(setting, f"probability_{scenario}")[0].filled(0.0), 1.0 - survives, atol=1e-6)


def test_frequency_is_the_sum_over_periods(done):
    setting, _ = done
    rare, frequent = (band(setting, f"probability_{name}")[0].filled(0.0) for name in ("rare", "frequent"))
    expected = frequent * (1.0 / 10.0 - 1.0 / 100.0) + np.maximum(rare, frequent) / 100.0
    assert np.allclose(band(setting, "frequency")[0].filled(0.0), expected, atol=1e-7)
    strong = band(setting, "frequency_above_30_kPa")[0].filled(0.0)
    assert (strong <= expected + 1e-7).all() and (strong > 0.0).any()


def test_zones_are_those_of_the_peaks(done):
    setting, _ = done
    zones = band(setting, "zones")[0].filled(0)
    rare, frequent = (band(setting, f"peak_pressure_{name}")[0] for name in ("rare", "frequent"))
    red = ~np.ma.getmaskarray(frequent) | (rare.filled(0.0) >= 30e3)
    assert ((zones == 2) == red).all()
    assert ((zones == 1) == (~np.ma.getmaskarray(rare) & ~red)).all()


def test_files_are_as_they_say(done):
    """Overviews, cloud-optimised layout, Zarr with the same numbers, outlines with the same areas, page and project."""
    import zarr
    from pyogrio import raw

    setting, _ = done
    folder = setting.folder / plan.MAPS
    for one in maps.rasters(setting):
        with rasterio.open(folder / f"{one.name}.tif") as file:
            assert file.tags(ns="IMAGE_STRUCTURE")["LAYOUT"] == "COG" and file.crs.to_epsg() == 21781
            assert file.units[0] == one.unit
    store = zarr.open_group(str(folder / maps.STORE), mode="r")
    pressure, _ = band(setting, "peak_pressure_rare")
    assert np.array_equal(store["peak_pressure"][0], pressure.filled(0.0))
    assert store["peak_pressure"].metadata.dimension_names == ("scenario", "y", "x")
    classes, file = band(setting, "intensity_rare")
    meta, _, geometry, values = raw.read(str(folder / "intensity.gpkg"), layer="intensity_rare")
    fields = dict(zip(meta["fields"], values, strict=True))
    for k in range(1, 6):
        assert fields["area_m2"][fields["class"] == k].sum() == pytest.approx((classes.filled(0) == k).sum() * 400.0)
    assert file.transform.a == 20.0 and len(geometry)
    page = (folder / "index.html").read_text()
    assert "@@" not in page and "http" not in page.replace("http-equiv", "")
    facts = json.loads(page.partition("const F=")[2].partition(", map=")[0])
    for layer in facts["layers"]:
        assert (folder / "page" / layer["key"] / "0_0_0.png").is_file()
    project = (folder / "region.qgs").read_text()
    assert "./intensity_rare.tif" in project and "../areas_rare.gpkg|layername=release_areas" in project


def test_a_run_lies_on_the_lines_of_the_maps(done):
    setting, _ = done
    index, grid = journal.index_of(setting.folder, list(setting.areas)), maps.grid_of(setting)
    for k in range(len(index.hash)):
        with np.load(plan.results_of(setting.folder, index.name_of(k)) / RUN_MAPS) as found:
            at = (found["corner"] - [grid.west, grid.north]) / grid.cell
        assert np.allclose(at, np.round(at), atol=1e-6)


def test_resume_does_nothing_where_all_is_done_and_refuses_another_region(done, region_file, scheduler):
    setting, _ = done
    path = region_file(MORE)
    path.write_text('zones = "switzerland"\n' + path.read_text())
    file = read_region(path)
    before = (setting.folder / plan.RESULTS).read_bytes()
    launch.run_region(file, setting.folder, scheduler=scheduler, resume=True)
    assert (setting.folder / plan.RESULTS).read_bytes() == before
    with pytest.raises(InputError, match="already holds a region"):
        launch.run_region(file, setting.folder)
    changed = read_region(region_file(MORE.replace("0.9", "0.8"), name="other.toml"))
    with pytest.raises(InputError, match="scenarios: is not that of the region"):
        launch.run_region(changed, setting.folder, resume=True)


def test_samples_and_their_factors(region_file):
    file = read_region(region_file("[samples]\nruns = 40\nthickness = 0.2\nfriction = 0.1"))
    found = np.log(plan.factors(file.samples))
    assert np.abs(found.mean(axis=0)).max() < 0.02
    assert np.allclose(found.std(axis=0), [0.2, 0.1], rtol=0.06)
    assert plan.factors(read_region(region_file()).samples) == [(1.0, 1.0)]


def test_releases_are_chosen_evenly_and_nested():
    assert plan.chosen(10, None) == range(1, 11)
    found = plan.chosen(1000, 100)
    assert len(set(found)) == 100 and min(found) >= 1 and max(found) <= 1000
    assert np.diff(found).max() <= 16
    for most in (1, 7, 99):
        assert set(plan.chosen(1000, most)) <= set(found)


@pytest.mark.parametrize(("periods", "shares", "expected"), [
    ((10.0, 100.0), (0.5, 1.0), 0.5 * 0.09 + 1.0 * 0.01),
    ((10.0, 100.0), (1.0, 0.0), 0.1),  # what comes every 10 years comes every 100 as well
    ((30.0, 30.0), (0.5, 0.5), 0.75 / 30.0),
    ((30.0, 30.0, 300.0), (1.0, 0.0, 0.2), 1.0 / 30.0),
    ((300.0,), (0.3,), 0.001),
])
def test_frequency_of_scenarios(periods, shares, expected):
    found = maps.frequency_of(periods, [np.array([one]) for one in shares], lambda a, b: 1.0 - (1.0 - a) * (1.0 - b))
    assert found[0] == pytest.approx(expected)


def test_arrivals_are_at_least_the_frequency(done):
    setting, _ = done
    arrivals, frequency = (band(setting, name)[0].filled(0.0) for name in ("arrivals", "frequency"))
    assert (arrivals >= frequency * (1.0 - 1e-6)).all() and (arrivals > 1.5 * frequency).any()


def test_the_store_opens_in_xarray(done):
    xarray = pytest.importorskip("xarray")
    setting, _ = done
    found = xarray.open_zarr(setting.folder / plan.MAPS / maps.STORE)
    assert dict(found.sizes)["scenario"] == 2 and list(found.period.values) == [100.0, 10.0]
    assert found.peak_pressure.dims == ("scenario", "y", "x") and found.frequency.dims == ("y", "x")


def test_what_became_of_each_release(done):
    from pyogrio import raw

    setting, _ = done
    meta, _, geometry, values = raw.read(str(setting.folder / plan.MAPS / "releases.gpkg"), layer="rare")
    fields = dict(zip(meta["fields"], values, strict=True))
    assert len(geometry) == setting.areas["rare"]
    assert (fields["status"] == "done").sum() == 4 and (fields["status"] == "not run").sum() == len(geometry) - 4
    assert (fields["runs"] == 2.0).sum() == 4 and np.nanmax(fields["pressure_kpa"]) > 10.0
