"""`snowmpm runout` on the library's valley, as a user calls it."""

import csv
import json

import numpy as np
import pytest
import shapely

from snowmpm.compiler import runtime
from snowmpm.runout.ground import ground_of
from snowmpm.runout.models import FOLD, runout
from snowmpm.runout.routing import Routing
from snowmpm.scenes import load_scene

VALLEY = "avalanche_depth_averaged"
FRICTION = 'terrain.friction={law="voellmy",mu=0.2,xi=1500.0}'


@pytest.fixture(scope="module")
def valley():
    runtime.start("cpu")
    changes = {"solver.dx": 10.0, "terrain.friction": {"law": "voellmy", "mu": 0.2, "xi": 1500.0}}
    return ground_of(load_scene(VALLEY, changes))


def test_the_ground_is_that_of_the_scene(valley):
    assert valley.cell == 10.0 and valley.z.shape == (96, 52) and np.isnan(valley.z).any()
    assert valley.thickness == pytest.approx(1.5, rel=0.05)
    heights = valley.z[tuple(valley.release.T)]
    assert (np.diff(heights) <= 0.0).all() and valley.height(valley.top[None])[0] == pytest.approx(heights[0])


def test_a_table_a_picture_and_rasters(call, tmp_path):
    code, out, err = call("runout", VALLEY, "--set", FRICTION, "--set", "solver.dx=10", "-o", "out")
    assert code == 0, err
    for words in ("alpha", "alpha - 2 SD", "energy line of 25 degrees", "block, Voellmy 0.2, 1500", "routing",
                  "the way of most snow from the top of the release"):
        assert words in out
    with (tmp_path / "out" / "runout.csv").open(encoding="utf-8") as file:
        rows = {row["model"]: row for row in csv.DictReader(file)}
    lengths = [float(rows[name]["length_m"]) for name in ("alpha + SD", "alpha", "alpha - SD")]
    assert lengths == sorted(lengths)
    assert float(rows["energy line of 25 degrees"]["angle_deg"]) == pytest.approx(25.0, abs=0.01)
    assert (tmp_path / "out" / "runout.png").stat().st_size > 20_000
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(tmp_path / "out" / "speed.tif") as file:
        speed = file.read(1)
        assert file.tags()["angle"] == "25.0" and np.nanmax(np.where(speed > 0.0, speed, np.nan)) > 20.0
        stop = rows["routing, longest way"]
        row, column = file.index(float(stop["x_m"]), float(stop["y_m"]))
    with rasterio.open(tmp_path / "out" / "travel_length.tif") as file:  # north is up, east to the right
        assert file.read(1)[row, column] == pytest.approx(float(stop["length_m"]), abs=0.1)
    ground = ground_of(load_scene(VALLEY, {"solver.dx": 10.0}))
    place = np.array([[float(rows["alpha"]["x_m"]), float(rows["alpha"]["y_m"])]])
    assert ground.height(place)[0] == pytest.approx(float(rows["alpha"]["z_m"]), abs=1.0)
    pyogrio = pytest.importorskip("pyogrio")
    assert {name for name, _ in pyogrio.list_layers(tmp_path / "out" / "runout.gpkg")} == {"path", "runout"}
    _, _, shapes, columns = pyogrio.raw.read(tmp_path / "out" / "runout.gpkg", layer="runout")
    points = dict(zip(columns[0], shapely.from_wkb(shapes), strict=True))
    assert (points["alpha"].x, points["alpha"].y) == pytest.approx(tuple(place[0]), abs=0.01)
    assert call("runout", VALLEY, "--set", FRICTION, "--set", "solver.dx=10", "-o", "out", "--json")[0] == 0


def test_json_and_a_path_of_the_user(call, tmp_path):
    line = {"type": "LineString", "coordinates": [[600150, 200250], [600500, 200215], [600900, 200215]]}
    (tmp_path / "line.geojson").write_text(json.dumps(line), encoding="utf-8")
    code, out, err = call("runout", VALLEY, "--set", "solver.dx=10", "--path", "line.geojson", "--calibration",
                          "norway", "--angle", "22", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert found["path_length"] == pytest.approx(752.0, abs=1.0)
    assert found["alpha"] == pytest.approx(0.96 * found["beta"] - 1.4) and found["deviation"] == 2.3
    assert "energy line of 22 degrees" in found["models"] and found["calibration"] == "norway"
    assert found["models"]["block"]["length"] is None and "needs Coulomb's" in found["models"]["block"]["note"]
    assert found["path"] == "--path = 'line.geojson'"


@pytest.mark.parametrize(("options", "words"), [
    (("--calibration", "austia"), "did you mean austria?"), (("--angle", "2"), "--angle = 2.0: must be from 5 to 60"),
    (("--exponent", "0"), "--exponent"), (("--split", "-3"), "--split"), (("--path", "nowhere.shp"), "nowhere.shp"),
    (("--set", "solver.method=mpm", "--set", "solver.dx=3"), 'must be "depth"'),
])
def test_bad_input_is_one_line_and_writes_nothing(call, tmp_path, options, words):
    code, out, err = call("runout", VALLEY, *options)
    assert code == 2 and out == "" and words in err and len(err.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_path_that_ends_on_the_slope_is_said(valley):
    line = np.array([[600150.0, 200250.0], [600450.0, 200217.0]])
    found = runout(valley, line)
    assert found.statistics is None and "no beta point" in found.reason
    ends = [one for one in found.reaches if one.note == "beyond the end of the path"]
    assert any("block" in one.model for one in ends) and found.reaches[-1].model == "routing, longest way"


def test_models_go_as_far_as_the_flow_within_the_scatter_of_friction(valley):
    """The depth-averaged run goes 720 to 810 m with published classes (docs/engineers_day.md)."""
    found = {one.model: one.s for one in runout(valley).reaches}
    assert 500.0 < found["block, Voellmy 0.2, 1500"] < 810.0
    assert 500.0 < found["alpha"] < 810.0 and 550.0 < found["routing, longest way"] < 810.0


@pytest.mark.parametrize(("law", "model"), [
    ({"law": "coulomb", "mu": 0.3}, "block, Coulomb 0.3"),
    ({"law": "voellmy", "mu": 0.2, "k": 0.00981}, "block, Voellmy 0.2, 1000"),
    ({"law": "voellmy", "mu": 0.2, "xi": 1500.0, "tau0": 100.0}, "block"), ({"card": "samos_at_small"}, "block"),
])
def test_laws_that_a_block_has(law, model):
    runtime.start("cpu")
    found = runout(ground_of(load_scene(VALLEY, {"solver.dx": 10.0, "terrain.friction": law})))
    names = [one.model for one in found.reaches if one.model.startswith("block")]
    assert names == [model]


def test_what_the_models_have_not_is_said():
    runtime.start("cpu")
    forest = [{"name": "trees", "region": {"x": [600300.0, 600500.0]}, "drag": 0.01}]
    ground = ground_of(load_scene(VALLEY, {"solver.dx": 10.0, "terrain.forest": forest}))
    assert ground.ignored == ("forest and deposition",) and any("forest" in doubt for doubt in runout(ground).doubts)


def test_the_end_of_the_ground_is_no_run_out(valley):
    found = runout(valley, routing=Routing(angle=8.0))
    assert found.routed.at_edge and "at least" in found.reaches[-1].note
    assert any("cannot be told" in doubt for doubt in found.doubts)


def test_a_path_that_begins_elsewhere_or_folds_is_said(valley):
    line = np.array([[600400.0, 200220.0], [600700.0, 200215.0], [600500.0, 200215.0], [600900.0, 200215.0]])
    said = " ".join(runout(valley, line).doubts)
    assert "beside the release" in said and "turns by 180 degrees at" in said


def test_the_way_of_most_snow_does_not_fold(valley):
    turn, _ = runout(valley).profile.sharpest
    assert turn < FOLD
