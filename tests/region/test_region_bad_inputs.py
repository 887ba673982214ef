"""Bad input gets a line that names file, key, value and what is allowed; nothing is written."""

import json

import numpy as np
import pytest

from snowmpm.errors import InputError, WriteError
from snowmpm.region import forecast, jobs, journal, launch, plan, preparing
from snowmpm.region import release_areas as areas_of
from snowmpm.region.elevations import open_elevations
from snowmpm.region.release_terrain import RULES
from snowmpm.region.spec import read_region
from tests.support.region import ROOF, roof

pytest.importorskip("distributed")


def refused(file, folder):
    with pytest.raises(InputError) as found:
        launch.run_region(read_region(file), folder, workers=1)
    text = str(found.value)
    assert len(text.splitlines()) <= 2
    assert not folder.exists()
    return text


def test_holes_in_the_terrain_are_no_release_areas(raster):
    z = roof()
    z[40:80, 20:50] = np.nan
    with open_elevations(raster(z)) as elevations:
        found = areas_of.release_areas(elevations, ROOF)
    hole = [600_000.0 + 5.0 * 20, 200_000.0 + 5.0 * 40, 600_000.0 + 5.0 * 50, 200_000.0 + 5.0 * 80]
    import shapely

    assert not sum(one.geometry.intersection(shapely.box(*hole)).area for one in found)


def test_a_raster_without_heights(raster, region_file, tmp_path):
    file = raster(np.full((40, 40), np.nan))
    path = region_file()
    path.write_text(path.read_text().replace("massif.tif", file.name).replace("cell = 20.0", ""))
    assert "no release areas" in refused(path, tmp_path / "out")


def test_forest_in_another_place(region_file, tmp_path, raster):
    raster(np.full((20, 20), 80.0), name="cover.tif", corner=(700_000.0, 200_000.0))
    text = refused(region_file('[forest]\nfile = "cover.tif"'), tmp_path / "out")
    assert "forest.file" in text and "lies beside the terrain" in text


def test_forest_without_a_system(region_file, tmp_path, raster):
    raster(np.full((20, 20), 80.0), name="cover.tif", system=None)
    assert "names no coordinate system" in refused(region_file('[forest]\nfile = "cover.tif"'), tmp_path / "out")


def test_an_area_of_interest_beside_the_terrain(region_file, tmp_path):
    (tmp_path / "town.geojson").write_text(json.dumps({
        "type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::21781"}},
        "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [
            [[700_000.0, 200_000.0], [700_100.0, 200_000.0], [700_000.0, 200_100.0], [700_000.0, 200_000.0]]]}}]}))
    path = region_file()
    path.write_text('area_of_interest = "town.geojson"\n' + path.read_text())
    assert "area_of_interest" in refused(path, tmp_path / "out")


@pytest.mark.parametrize(("old", "new", "says"), [
    ('terrain = "massif.tif"', 'terrain = "none.tif"', "no such file"),
    ("cell = 20.0", "cell = 13.0", "must be a whole multiple"),
    ("period = 100.0", "period = 0.1", "scenarios.rare.period"),
    ("three_day_snow = 1.6", "three_day_snow = 160.0", "scenarios.rare.thickness.three_day_snow"),
    ("thickness = { three_day_snow = 1.6 }", "", "scenarios.rare.thickness"),
    ("thickness = { three_day_snow = 1.6 }", "thickness = { value = 1.0, three_day_snow = 1.6 }", "needs one of"),
    ('card = "voellmy_avaframe"', 'card = "voelmy_avaframe"', "must be one of"),
    ("most_releases = 4", "most_release = 4", "did you mean most_releases"),
    ("[scenarios.rare]", "[scenarios.rare]\nbounds = { least = 58.0 }", "no release areas"),
])
def test_a_wrong_key_or_value(region_file, tmp_path, old, new, says):
    path = region_file()
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert says in refused(path, tmp_path / "out")


def test_terrain_in_degrees(raster, region_file, tmp_path):
    file = raster(roof(40), cell=5e-5, system="EPSG:4326", corner=(7.0, 46.0))
    path = region_file()
    path.write_text(path.read_text().replace("massif.tif", file.name))
    assert "must be in metres" in refused(path, tmp_path / "out")


def test_a_release_at_the_border_says_so(raster, region_file, tmp_path, scheduler):
    """The flow leaves the terrain: the run is done, and its numbers say what left."""
    file = raster(roof(60, cell=10.0), cell=10.0)
    path = region_file()
    path.write_text(path.read_text().replace("massif.tif", file.name).replace("cell = 20.0", "cell = 10.0"))
    setting = preparing.make(read_region(path), tmp_path / "out")
    record = jobs.work_on(next(iter(plan.jobs(setting))))
    assert record["status"] == "done"
    assert record["numbers"]["left_share"] > 0.5 and record["numbers"]["window_at_border"] == 1.0
    launch.run_region(read_region(path), setting.folder, scheduler=scheduler, resume=True)
    assert any("over the border of the terrain" in line and warns for line, warns in launch.told(setting))


def test_cover_as_a_share(region_file, tmp_path, raster):
    raster(np.full((40, 40), 0.6), cell=100.0, name="cover.tif")
    text = refused(region_file('[forest]\nfile = "cover.tif"'), tmp_path / "out")
    assert "is it in per cent?" in text


def test_a_folder_with_files_of_others(region_file, tmp_path):
    out = tmp_path / "out"
    (out / "maps").mkdir(parents=True)
    (out / "maps" / "mine.txt").write_text("mine")
    with pytest.raises(InputError):
        launch.run_region(read_region(region_file()), out, workers=1)
    assert [one.name for one in out.rglob("*")] == ["maps", "mine.txt"]


def test_too_little_disk(region_file, tmp_path, monkeypatch):
    from collections import namedtuple

    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(forecast.shutil, "disk_usage", lambda path: usage(1, 1, 1000))
    with pytest.raises(InputError, match="of disk, of which"):
        launch.run_region(read_region(region_file()), tmp_path / "out", workers=1)


def test_a_full_disk_in_a_worker_is_no_record(region_file, tmp_path, monkeypatch):
    """A worker that cannot write leaves no record, so that the release is run elsewhere."""
    from snowmpm.campaigns import work

    setting = preparing.make(read_region(region_file()), tmp_path / "out")
    job = next(iter(plan.jobs(setting)))

    def full(*arguments, **options):
        raise WriteError("disk full") from OSError(28, "No space left on device")

    monkeypatch.setattr(work, "_write_maps", full)
    record = jobs.work_on(job)
    assert record["status"] == work.UNWRITTEN and "disk full" in record["reason"]
    assert not (plan.results_of(setting.folder, job.hash) / work.RECORD).exists()


def test_a_failing_release_is_listed_and_done_again(region_file, tmp_path, scheduler):
    """One release fails: the others are done, the table says why, --retry-failed does it once more."""
    file = read_region(region_file())
    setting = preparing.make(file, tmp_path / "out")
    broken = list(plan.jobs(setting))[1]
    results = plan.results_of(setting.folder, broken.hash)
    results.mkdir(parents=True)
    record = {"status": "failed", "reason": "a test", "numbers": {}, "work": {}}
    (results / "record.json").write_text(json.dumps(record))
    said = []
    launch.run_region(file, setting.folder, scheduler=scheduler, resume=True, say=said.append)
    assert any("failed: a test" in line for line in said)
    counts = launch.counts(setting)["rare"]
    assert (counts["done"], counts["failed"], counts["out_of_reach"], counts["releases"]) == (3, 1, 0, 4)
    assert any("1 runs failed and are missing in the maps" in line for line, _ in launch.told(setting))
    launch.run_region(file, setting.folder, scheduler=scheduler, resume=True, retry=True)
    assert launch.counts(setting)["rare"]["done"] == 4


@pytest.mark.parametrize("line", ['{"hash": "../../../../etc", "scenario": "rare"}', "[1, 2]", "no json at all",
                                  '{"hash": "0123456789abcdef", "scenario": "rare", "area": 1, "sample": 0, "status":'
                                  ' "done", "bounds": [1, 2], "numbers": {}}'])
def test_a_foreign_list_of_results_is_refused(tmp_path, line):
    good = json.dumps({"hash": "0123456789abcdef", "scenario": "rare", "area": 1, "sample": 0, "status": "done",
                       "bounds": None, "seconds": 1.0, "numbers": {}})
    (tmp_path / plan.RESULTS).write_text(f"{good}\n{line}\n{good}\n")
    with pytest.raises(InputError, match="line 2: not written by this program"):
        list(journal.lines(tmp_path))


def test_a_line_that_a_kill_cut_off_is_left_out(tmp_path):
    good = json.dumps({"hash": "0123456789abcdef", "scenario": "rare", "area": 1, "sample": 0, "status": "done",
                       "bounds": None, "seconds": 1.0, "numbers": {}})
    path = tmp_path / plan.RESULTS
    path.write_text(f"{good}\n{good[:40]}")
    assert len(list(journal.lines(tmp_path))) == 1
    journal.repair(tmp_path)
    assert path.read_text() == f"{good}\n"


def test_cells_too_coarse(raster):
    with open_elevations(raster(roof(40), cell=50.0)) as elevations, pytest.raises(InputError, match="best 5 m"):
        areas_of.release_areas(elevations, RULES["rare"])


@pytest.mark.parametrize(("old", "new"), [
    ('terrain = "terrain.tif"', 'terrain = "/etc/hostname"'),
    ('terrain = "terrain.tif"', 'terrain = "../secret.tif"'),
    ('terrain = "terrain.tif"', 'terrain = "terrain.tif"\nexposed = ["../houses.geojson"]'),
    ('terrain = "terrain.tif"', 'terrain = "terrain.tif"\narea_of_interest = "../houses.geojson"'),
])
def test_a_folder_from_elsewhere_reads_nothing_outside(region_file, tmp_path, old, new):
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    for name in ("secret.tif", "houses.geojson"):
        (tmp_path / name).write_text("{}")
    text = (made.folder / plan.FILE).read_text()
    assert old in text
    (made.folder / plan.FILE).write_text(text.replace(old, new))
    plan.forget()
    with pytest.raises(InputError, match="must lie in inputs/ of its folder"):
        plan.read_setting(made.folder)


@pytest.mark.parametrize("text", [
    '{"cell": 20.0, "crs": null, "areas": {"foo": 3}, "digests": {}}',
    '{"cell": 20.0, "crs": null, "areas": {"rare": 3}, "digests": [1]}',
    '{"cell": "x", "crs": null, "areas": {}, "digests": {}}', "[]", "{}", "no json"])
def test_a_damaged_folder_is_refused(region_file, tmp_path, text):
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    (made.folder / plan.SETTING).write_text(text)
    plan.forget()
    with pytest.raises(InputError, match="not written by this program"):
        plan.read_setting(made.folder)


def test_areas_that_are_no_geopackage_are_not_opened(region_file, tmp_path):
    """GDAL would follow other formats to other files and addresses."""
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    plan.areas_file(made.folder, "rare").write_text("<OGRVRTDataSource></OGRVRTDataSource>")
    with pytest.raises(InputError, match="not written by this program"):
        plan.read_area(made.folder, "rare", 1)


@pytest.mark.parametrize("name", ["maps", "maps/page", "inputs", "results", "runs"])
def test_folders_that_are_links_are_refused(region_file, tmp_path, name):
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    outside = tmp_path / "outside"
    outside.mkdir()
    (made.folder / name).parent.mkdir(exist_ok=True)
    (made.folder / name).symlink_to(outside)
    with pytest.raises(InputError, match="is a link"):
        launch.run_region(read_region(region_file()), made.folder, workers=1, resume=True)
    assert not list(outside.iterdir())


def test_a_folder_goes_on_by_its_own_file(region_file, tmp_path, scheduler):
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    (tmp_path / "massif.tif").unlink()
    launch.run_region(read_region(made.folder / plan.FILE), made.folder, scheduler=scheduler, resume=True)
    assert launch.counts(made)["rare"]["done"] == 4


def test_runs_of_others_are_kept(region_file, tmp_path):
    (tmp_path / "runs" / "mine").mkdir(parents=True)
    (tmp_path / "runs" / "mine" / "data.txt").write_text("x")
    with pytest.raises(InputError, match="holds files of others"):
        launch.run_region(read_region(region_file()), tmp_path, workers=1)
    assert (tmp_path / "runs" / "mine" / "data.txt").read_text() == "x"


def test_a_link_in_a_folder_from_elsewhere_is_not_written_through(region_file, tmp_path):
    made = preparing.make(read_region(region_file()), tmp_path / "out")
    job = next(iter(plan.jobs(made)))
    outside = tmp_path / "outside"
    outside.mkdir()
    results = plan.results_of(made.folder, job.hash)
    results.parent.mkdir(parents=True)
    results.symlink_to(outside)
    assert jobs.work_on(job)["reason"] == "its folder is a link"
    assert not list(outside.iterdir())
