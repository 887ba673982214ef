"""Scores against what was observed: of areas, lengths and values that can be counted, and of a whole command."""

import csv
import json

import numpy as np
import pytest
import shapely

from snowmpm.events.scoring import Computed, Observation, score_run, scores
from snowmpm.events.spec import Event
from snowmpm.gis.observed import area_of
from snowmpm.quantities.scores import SCORES
from tests.support.straight_avalanche import ORIGIN, lambert, write_avalanche

X, Y = ORIGIN[:2]
KNOWN = {"title": "straight", "date": "2026-01-02", "place": "a", "kind": "b", "credit": "c", "licence": "CC0",
         "terms": "https://example.org", "uses": "d", "sources": ["e"], "assumed": ["f"]}
PATH = [[X + 20.0, Y + 100.0], [X + 700.0, Y + 100.0]]


@pytest.fixture(scope="module")
def straight(tmp_path_factory):
    return Computed.of(write_avalanche(tmp_path_factory.mktemp("straight"), crs=lambert()))


def observation(outline=None, deposit=None, /, **observed):
    event = Event.model_validate_json(json.dumps({**KNOWN, "observed": observed}))
    return Observation(event, outline, deposit)


def box(x0, y0, x1, y1):
    return shapely.box(X + x0, Y + y0, X + x1, Y + y1)


def test_an_outline_and_its_reach_are_counted(straight):
    """Computed: x = 20 to 500 m, y = 80 to 120 m, less a hole of 100 m2; seen: without the last 100 m."""
    seen = observation(box(20, 80, 400, 120), outline={"file": "a.shp", "uncertainty": 10.0}, path=PATH)
    found = scores(straight, seen)
    hit, missed, false = 380.0 * 40.0 - 100.0, 100.0, 4000.0
    assert found["success_index"] == pytest.approx(hit / (hit + missed + false))
    assert found["hit_rate"] == pytest.approx(hit / (hit + missed))
    assert found["false_alarm_ratio"] == pytest.approx(false / (hit + false))
    assert found["area_ratio"] == pytest.approx((hit + false) / (hit + missed))
    assert found["runout_error"] == pytest.approx(100.0, abs=0.1)
    whole = 380.0 * 40.0
    wider, narrower = shapely.area(shapely.buffer(box(20, 80, 400, 120), 10.0)), 360.0 * 20.0
    unsure = 0.5 * ((1.0 - whole / wider) + (1.0 - narrower / whole))
    terms = [(1.0 - found["success_index"]) / unsure, found["runout_error"] / 10.0]
    assert found["misfit"] == pytest.approx(np.sqrt(np.mean(np.square(terms))))


def test_the_same_outline_has_no_misfit(straight):
    seen = observation(straight.area("peak_depth"), outline={"file": "a.shp", "uncertainty": 10.0}, path=PATH)
    found = scores(straight, seen)
    assert found["misfit"] == pytest.approx(0.0, abs=1e-9) and found["success_index"] == 1.0


def test_the_angle_is_that_of_heights_along_the_path(straight):
    slope = Computed(straight.maps, straight.origin, straight.numbers, lambda places: -0.5 * np.minimum(
        places[:, 0], X + 300.0))
    seen = observation(path=PATH, stopped={"x": X + 400.0, "y": Y + 90.0, "uncertainty": 25.0})
    found = scores(slope, seen)
    assert found["runout_error"] == pytest.approx(100.0, abs=0.1) and found["misfit"] == pytest.approx(4.0, abs=0.01)
    angles = [np.degrees(np.arctan2(140.0, s)) for s in (480.0, 380.0)]
    assert found["angle_error"] == pytest.approx(angles[0] - angles[1], abs=0.02)


def test_a_deposit_and_its_volume(straight):
    """Computed: 1 m from x = 460 to 500 m, 1600 m3."""
    seen = observation(None, box(460, 80, 480, 120), deposit={"file": "a.shp", "uncertainty": 5.0},
                       deposit_volume={"value": 2000.0, "deviation": 200.0})
    found = scores(straight, seen)
    assert found["deposit_success_index"] == pytest.approx(0.5) and found["deposit_ratio"] == pytest.approx(0.8)
    wider = shapely.area(shapely.buffer(box(460, 80, 480, 120), 5.0))
    unsure = 0.5 * ((1.0 - 800.0 / wider) + (1.0 - 300.0 / 800.0))
    assert found["misfit"] == pytest.approx(np.sqrt(0.5 * ((0.5 / unsure) ** 2 + 4.0)))


@pytest.mark.parametrize(("place", "expected"), [
    ({"x": X + 400.0, "y": Y + 100.0}, (12.0 - 9.0) / 2.0),
    ({"x": X + 400.0, "y": Y + 130.0}, -9.0 / 2.0),                    # no flow there
    ({"x": X + 400.0, "y": Y + 130.0, "within": 20.0}, 1.5),           # but within 20 m
    ({"x": X - 5000.0, "y": Y}, -9.0 / 2.0),                           # beside the map
    ({}, 1.5),                                                         # the largest anywhere
], ids=["in the flow", "beside it", "near it", "beside the map", "anywhere"])
def test_a_measured_speed(straight, place, expected):
    seen = observation(values=[{"map": "peak_speed", "value": 9.0, "deviation": 2.0, "by": "hand", **place}])
    found = scores(straight, seen)
    assert found["value_error_0"] == pytest.approx(expected) and found["misfit"] == pytest.approx(abs(expected))


@pytest.mark.parametrize(("value", "expected"), [(9.0, 0.0), (16.0, -2.0)])
def test_a_sensor_may_ride_behind_the_fastest_part(straight, value, expected):
    seen = observation(values=[{"map": "peak_speed", "value": value, "deviation": 2.0, "at_least": True, "by": "hand"}])
    assert scores(straight, seen)["value_error_0"] == pytest.approx(expected)


def test_turning_the_scene_changes_nothing(straight):
    """A quarter turn, in which cells stay cells."""
    seen = observation(box(20, 80, 400, 120), outline={"file": "a.shp", "uncertainty": 10.0}, path=PATH)

    def turned(corners):
        return np.column_stack([-corners[:, 1], corners[:, 0]])

    maps = {}
    for name, raster in straight.maps.items():
        cells = raster.values.shape[0]
        maps[name] = type(raster)(raster.values.T[:, ::-1], -(raster.y0 + (cells - 1) * raster.cell), raster.x0,
                                  raster.cell, raster.units)
    other = Computed(maps, turned(straight.origin[None, :2])[0], straight.numbers)
    event = seen.event.model_copy(update={"observed": seen.event.observed.model_copy(update={
        "path": tuple(map(tuple, turned(np.array(PATH))))})})
    again = scores(other, Observation(event, shapely.transform(seen.outline, turned), None))
    for name, value in scores(straight, seen).items():
        if value is not None and name != "angle_error":
            assert again[name] == pytest.approx(value, rel=1e-9), name


def test_an_observed_area_may_be_a_raster(tmp_path):
    rows = ["ncols 4", "nrows 3", "xllcorner 100", "yllcorner 200", "cellsize 10", "NODATA_value -9999",
            "0 0 0 0", "0 1 1 -9999", "0 1 0 0"]
    (tmp_path / "seen.asc").write_text("\n".join(rows), encoding="utf-8")
    found = area_of(tmp_path / "seen.asc", None)
    assert shapely.area(found) == 300.0 and found.bounds == (110.0, 200.0, 130.0, 220.0)


@pytest.mark.filterwarnings("ignore")
def test_every_way_to_compute_an_event_in_one_table(made_up, call, tmp_path):
    pytest.importorskip("distributed")
    name = made_up(observed="deposit_volume = { value = 40000.0, deviation = 8000.0 }")
    code, out, err = call("events", "score", name, "--only", "samos_at_small", "--only", "Coulomb", "--workers", "1")
    assert code == 0, err
    folder = tmp_path / "campaigns" / "event_made_up"
    with open(folder / "scores.csv", encoding="utf-8") as stream:
        rows = {row["way"]: row for row in csv.DictReader(stream)}
    assert set(rows) == {"samos_at_auto", "samos_at_small", "Coulomb 0.3, of a scene that names none"}
    known = {one.name for one in SCORES} - {"deposit_success_index"}
    more = {"value_error_0", "runout_beyond", "final", "statement", "class", "way"}
    assert known | more == set(rows["samos_at_small"])
    assert "the class is for a volume below" in rows["samos_at_small"]["class"]
    assert rows["samos_at_small"]["runout_beyond"] == "no"
    least = min(rows, key=lambda way: float(rows[way]["misfit"]))
    assert f"{least} [" in out and "best" in out and "[default" in out.replace("[best, default", "[default")
    assert "models without a flow, run-out less observed" in out and "energy line of 25 degrees" in out
    assert "peak flow speed" in " ".join(out.split()) and "The default" in out
    page = (folder / "event.html").read_text(encoding="utf-8")
    again = "snowmpm events score made_up --only samos_at_small --only Coulomb"
    assert all(words in page for words in ("A made-up avalanche", "everything", "CC0", "critical success index", again))
    assert (folder / "pictures" / "event.png").stat().st_size > 10_000
    again = call("events", "score", name, "--only", "samos_at_small", "--only", "Coulomb", "--resume", "--json")
    assert again[0] == 0 and json.loads(again[1])["samos_at_small"]["misfit"] == pytest.approx(
        float(rows["samos_at_small"]["misfit"]), rel=1e-5)


@pytest.mark.filterwarnings("ignore")
def test_an_event_is_run_by_its_name_and_drawn_with_its_outline(made_up, call, tmp_path):
    name = made_up()
    code, _, err = call("run", f"event:{name}", "-o", "out", "--set", "solver.dx=20", "--quiet")
    assert code == 0, err
    from snowmpm.io import Run

    numbers, seen = score_run(Run(tmp_path / "out"), name)
    assert 0.2 < numbers["success_index"] < 1.0 and len(seen.rings) == 1
    assert _distance_of_a_calibration(Run(tmp_path / "out"), name, tmp_path) == pytest.approx(
        numbers["misfit"], rel=1e-6)
    code, out, err = call("maps", "out", "--observed", f"event:{name}")
    assert code == 0 and f"critical success index  {100 * numbers['success_index']:.1f} %" in out


def _distance_of_a_calibration(run, name, folder):
    """Of a run as a campaign keeps it: its numbers and five of its maps."""
    from snowmpm.campaigns import work
    from snowmpm.campaigns.observation import Observation as OfCampaign
    from snowmpm.campaigns.spec import CampaignFile

    work._write_maps(folder / work.MAPS, run)
    mu = {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.1, "high": 0.4}
    tables = {"name": "fit", "scene": f"event:{name}", "runs": 8, "parameters": {"mu": mu},
              "calibration": {"observed": {"event": name}}}
    file = CampaignFile.checked(tables, "fit.toml", folder)
    return OfCampaign(file).distance({"status": "done", "numbers": work.numbers_of(run)}, folder)


def test_one_event_and_nothing_beside_it(tmp_path):
    from snowmpm.campaigns.spec import CampaignFile
    from snowmpm.errors import InputError

    mu = {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.1, "high": 0.4}
    observed = {"event": "ryggfonn_2021", "runout": {"value": 1.0, "deviation": 1.0}}
    tables = {"name": "fit", "scene": "event:ryggfonn_2021", "runs": 8, "parameters": {"mu": mu},
              "calibration": {"observed": observed}}
    with pytest.raises(InputError, match="does not go with other observations"):
        CampaignFile.checked(tables, "fit.toml", tmp_path)


def test_words_that_no_way_has(made_up, call):
    code, _, err = call("events", "score", made_up(), "--only", "samos_at_smal1")
    assert code == 2 and "did you mean samos_at_small?" in err
