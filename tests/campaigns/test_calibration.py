"""C5: friction found again from the run-out and the outline of a run that was made with it."""

import json

import numpy as np
import pytest
import shapely

from snowmpm.campaigns.calibration import calibrate_campaign
from snowmpm.campaigns.launch import prepare, run_campaign
from snowmpm.campaigns.members import make_plan
from snowmpm.campaigns.observation import Observation, success
from snowmpm.campaigns.spec import CampaignFile, read_campaign
from snowmpm.campaigns.work import MAPS, job_of, work
from tests.support.small_campaign import COARSE, small_file

pytest.importorskip("distributed")
TRUE = 0.268
MU = {"mu": {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.2, "high": 0.35}}
RUNS = {**COARSE, "solver.dx": 10.0, "end_time": 60.0, "output.interval": 10.0}


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """(run-out [m], file of the outline) of a run with the true friction."""
    folder = tmp_path_factory.mktemp("seen")
    truth = {"mu": {"key": "terrain.friction.mu", "distribution": "choices", "values": [TRUE]}}
    plan = make_plan(small_file(runs=1, set=RUNS, parameters=truth, maps={"cell": 10.0}), folder, 10.0)
    record = work(job_of(plan, plan.members[0]))
    with np.load(plan.results(plan.members[0]) / MAPS) as maps:
        rows, columns = np.nonzero(np.nan_to_num(maps["peak_depth"]) >= record["numbers"]["flow_depth"])
        west, south, cell = *(maps["corner"][:, None] + maps["cell"] * np.array([columns, rows])), float(maps["cell"])
        outline = shapely.union_all(shapely.box(west, south, west + cell, south + cell))
        cells = np.nan_to_num(maps["peak_depth"]) >= record["numbers"]["flow_depth"]
        assert success(cells, maps["corner"], cell, outline) == pytest.approx(1.0, abs=1e-9)
    file = folder / "seen.geojson"
    geometry = json.loads(shapely.to_geojson(outline))
    file.write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": geometry}))
    return record["numbers"]["runout"], file


def calibration_file(seen, **options):
    runout, outline = seen
    return CampaignFile.checked(
        {"name": "friction", "scene": "avalanche_depth_averaged", "runs": 1, "set": RUNS, "parameters": MU,
         "maps": {"cell": 10.0}, "calibration": {**options, "observed": {
             "runout": {"value": runout, "deviation": 10.0},
             "outline": {"file": str(outline), "deviation": 0.05}}}}, "friction.toml", outline.parent)


@pytest.mark.slow
def test_friction_is_found_again(seen, site, tmp_path):
    """Within 2 %, and the width of the posterior is no less than the error."""
    said = []
    file = calibration_file(seen, particles=16, generations=4)
    found = calibrate_campaign(file, tmp_path / "one", scheduler=site.client.scheduler.address, say=said.append)
    mean, wide = found.mean[0], found.deviation[0]
    print(f"mu = {mean:.4f} +- {wide:.4f}, true {TRUE}, {found.runs} runs, {found.generations} generations")
    assert abs(mean - TRUE) < 0.02 * TRUE
    assert abs(mean - TRUE) < 3.0 * wide and wide < 0.1 * TRUE
    table = (tmp_path / "one" / "posterior.csv").read_text().splitlines()
    assert table[0] == "mu,weight,distance" and len(table) == 1 + 8
    forecast = read_campaign(tmp_path / "one" / "forecast.toml").model_copy(update={"runs": 4})
    forecast._base_dir = tmp_path / "one"
    after = run_campaign(forecast, tmp_path / "forecast", scheduler=site.client.scheduler.address)
    assert after.done == 4 and np.isin(np.round(after.table.mu, 8), np.round(found.values[:, 0], 8)).all()
    assert np.ptp(after.table.runout) < 60.0


def test_distance_by_hand(seen, tmp_path):
    runout, _ = seen
    file = calibration_file(seen)
    plan, _ = prepare(file, tmp_path / "one", 1)
    record = {"status": "done", "numbers": {"runout": runout + 20.0, "flow_depth": 0.1, "end": 60.0}}
    results = tmp_path / "results"
    results.mkdir()
    np.savez(results / MAPS, corner=np.zeros(2), cell=10.0, peak_depth=np.zeros((2, 2)),
             arrival_time=np.full((2, 2), np.nan))
    observation = Observation(file)
    assert observation.misfits(record, results) == {"runout": pytest.approx(2.0), "outline": pytest.approx(20.0)}
    assert observation.distance(record, results) == pytest.approx(np.sqrt((4.0 + 400.0) / 2.0))
    assert observation.distance({"status": "failed"}, results) == np.inf
    assert plan.members
