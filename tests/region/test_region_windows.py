"""The window of a release: it grows where the flow needs it, and releases out of reach are not run."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from snowmpm.campaigns.work import start_quietly
from snowmpm.region import jobs, plan, preparing
from snowmpm.region.elevations import open_elevations
from snowmpm.region.spec import read_region


@pytest.fixture
def setting(region_file, tmp_path):
    start_quietly("cpu", 1)
    return preparing.make(read_region(region_file()), tmp_path / "out")


def job_of(setting, k=0):
    return list(plan.jobs(setting))[k]


def test_a_small_first_window_grows_to_the_same_maps(setting, tmp_path, monkeypatch):
    """The flow on a window that had to grow is that on a large one, to round-off."""
    large = jobs.work_on(job_of(setting))
    first = np.load(plan.results_of(setting.folder, large["hash"]) / "maps.npz")
    other = replace(setting, folder=tmp_path / "out")
    job = replace(job_of(setting), hash="0" * 16)
    monkeypatch.setattr(jobs, "first_window", lambda elevations, area, given: (
        area.geometry.bounds[0] - 40.0, area.geometry.bounds[1] - 40.0, area.geometry.bounds[2] + 40.0,
        area.geometry.bounds[3] + 40.0))
    grown = jobs.work_on(job)
    assert grown["status"] == "done" and grown["numbers"]["windows"] > 1.0
    second = np.load(plan.results_of(other.folder, grown["hash"]) / "maps.npz")
    assert np.allclose(first["corner"], second["corner"]) and first["peak_depth"].shape == second["peak_depth"].shape
    assert np.allclose(np.nan_to_num(first["peak_speed"]), np.nan_to_num(second["peak_speed"]), atol=1e-3)


def test_a_release_by_hand_has_the_same_peaks_to_the_bit(setting, tmp_path):
    """Its polygon and thickness on the whole terrain, with a domain on the lines of the maps."""
    import snowmpm
    from snowmpm.scenes import load_scene

    job = job_of(setting)
    jobs.work_on(job)
    own = np.load(plan.results_of(setting.folder, job.hash) / "maps.npz")
    area = plan.read_area(setting.folder, "rare", job.area)
    with open_elevations(setting.terrain) as elevations:
        west, south, east, north = elevations.grid.bounds
        whole = west + 20.0, south + 20.0, east - 20.0, north - 20.0
        changes = jobs.changes_of(job, setting, area, elevations, whole, tmp_path / "inputs")
    run = snowmpm.run(load_scene(setting.folder / plan.BASE, changes), tmp_path / "by_hand")
    raster = run.maps["peak_pressure"]
    column, row = np.round((own["corner"] - run.origin[:2] - [raster.x0, raster.y0]) / 20.0 + 0.5).astype(int)
    part = raster.values[row : row + own["peak_pressure"].shape[0], column : column + own["peak_pressure"].shape[1]]
    assert np.array_equal(np.nan_to_num(part).astype(np.float32), np.nan_to_num(own["peak_pressure"]))
    assert np.nan_to_num(raster.values).max() == np.nan_to_num(part).max() > 1e4


def test_the_window_holds_what_routing_reaches(setting):
    area = plan.read_area(setting.folder, "rare", 1)
    with open_elevations(setting.terrain) as elevations:
        west, south, east, north = jobs.first_window(elevations, area, setting)
        flat = jobs.first_window(elevations, area, replace(setting, file=setting.file.model_copy(update={
            "flow": setting.file.flow.model_copy(update={"reach": 8.0})})))
    assert shapely.box(west, south, east, north).contains(area.geometry)
    assert shapely.box(*flat).area > shapely.box(west, south, east, north).area


def test_out_of_reach(setting):
    far = replace(setting, interest=shapely.box(0.0, 0.0, 10.0, 10.0))
    area = plan.read_area(setting.folder, "rare", 1)
    with open_elevations(setting.terrain) as elevations:
        with pytest.raises(jobs.OutOfReach):
            jobs.first_window(elevations, area, far)
        jobs.first_window(elevations, area, replace(setting, interest=area.geometry))


def test_a_job_is_small(setting):
    import pickle

    assert len(pickle.dumps(job_of(setting))) < 600


def test_hashes_follow_what_matters(region_file, tmp_path):
    """Other friction, thickness or cells: other runs; another cluster: the same."""
    def hashes(text, folder):
        path = region_file()
        path.write_text(path.read_text().replace("end_time = 60.0", text))
        return [job.hash for job in plan.jobs(preparing.make(read_region(path), tmp_path / folder))]

    first = hashes("end_time = 60.0", "a")
    assert hashes("end_time = 60.0\n[cluster]\nworkers = 7\n", "b") == first
    assert not set(hashes("end_time = 61.0", "c")) & set(first)
    assert len(set(first)) == len(first)
