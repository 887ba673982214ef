"""Campaigns of scenarios: named sets of changes, one table and one map of all."""

import csv
import json

import pytest

from snowmpm.campaigns.campaign import Campaign
from snowmpm.campaigns.launch import own_data
from snowmpm.campaigns.members import samples
from snowmpm.campaigns.spec import CampaignFile
from snowmpm.cli.app import app
from snowmpm.errors import InputError

SETS = {"10 years": {"bodies.0.shape.top": 0.7}, "300 years": {
    "bodies.0.shape.top": 1.6, "terrain.friction": {"law": "voellmy", "mu": 0.2, "xi": 1500.0}}}


def file(folder, more=None, **changes):
    parameters = {"scenario": {"distribution": "scenarios", "sets": SETS}, **(more or {})}
    return CampaignFile.checked(
        {"name": "periods", "scene": "avalanche_depth_averaged", "design": "grid", "parameters": parameters,
         "set": {"solver.dx": 20.0, "end_time": 24.0, "output.interval": 8.0}, **changes}, "periods.toml", folder)


def test_each_scenario_makes_its_own_changes(tmp_path):
    found = file(tmp_path)
    assert [row["scenario"] for row in samples(found)] == ["10 years", "300 years"]
    parameter = found.parameters["scenario"]
    assert parameter.changes("10 years") == SETS["10 years"]
    assert parameter.keys == ("bodies.0.shape.top", "terrain.friction")
    again = CampaignFile.checked(own_data(found), "again", tmp_path)  # as it stands in the campaign's folder
    assert again.parameters["scenario"].sets == parameter.sets


@pytest.mark.parametrize(("parameter", "words"), [
    ({"sets": {}}, "sets"), ({"sets": {"a": {}}}, "sets.a"), ({}, "sets"),
    ({"sets": SETS, "key": "solver.dx"}, "key = .*does not go with distribution = \"scenarios\""),
    ({"sets": SETS, "values": [1]}, "values = .*does not go with"),
    ({"sets": {"a\nb": {"solver.dx": 1.0}}}, "sets"),
])
def test_sets_that_are_none(tmp_path, parameter, words):
    with pytest.raises(InputError, match=words):
        file(tmp_path, {"scenario": {"distribution": "scenarios", **parameter}})


def test_a_calibration_has_no_scenarios(tmp_path):
    with pytest.raises(InputError, match="does not go with a calibration"):
        file(tmp_path, calibration={"observed": {"runout": {"value": 700.0, "deviation": 10.0}}})


def test_a_file_within_a_table_of_a_scenario_goes_into_the_folder(tmp_path):
    """A forest whose polygon is a file: it was refused as one that no run would read."""
    from snowmpm.campaigns.launch import prepare

    pytest.importorskip("distributed")
    corners = [[600650, 200130], [600700, 200130], [600700, 200200], [600650, 200130]]
    trees = json.dumps({"type": "Polygon", "coordinates": [corners]})
    (tmp_path / "trees.geojson").write_text(trees, encoding="utf-8")
    forest = [{"name": "trees", "region": {"file": "trees.geojson"}, "drag": 0.01}]
    sets = {"bare": {"solver.dx": 20.0}, "forest": {"terrain.forest": forest}}
    plan, _ = prepare(file(tmp_path, {"scenario": {"distribution": "scenarios", "sets": sets}}), tmp_path / "out")
    assert len(plan.members) == 2 and list((tmp_path / "out" / "inputs").glob("*/trees.geojson"))


@pytest.mark.filterwarnings("ignore")
def test_one_command_for_table_map_and_page(tmp_path, capsys):
    pytest.importorskip("distributed")
    pyogrio = pytest.importorskip("pyogrio")
    path = tmp_path / "periods.toml"
    path.write_text("""name = "periods"
scene = "avalanche_depth_averaged"
design = "grid"
[set]
"solver.dx" = 20.0
end_time = 24.0
"output.interval" = 8.0
[parameters.scenario]
distribution = "scenarios"
[parameters.scenario.sets."10 years"]
"bodies.0.shape.top" = 0.7
[parameters.scenario.sets."300 years"]
"bodies.0.shape.top" = 1.6
""", encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        app(["campaign", "run", str(path), "-o", str(tmp_path / "out"), "--workers", "1"])
    assert not end.value.code
    told = capsys.readouterr().out
    assert "10 years" in told and "300 years" in told and "run-out" in told
    with open(tmp_path / "out" / "scenarios.csv", encoding="utf-8") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}
    volumes = [float(rows["release_volume"][name]) for name in ("10 years", "300 years")]
    assert volumes[1] / volumes[0] == pytest.approx(1.6 / 0.7, rel=1e-3)
    assert "moving" in rows["status"]["10 years"].lower()
    layers = [name for name, _ in pyogrio.list_layers(tmp_path / "out" / "scenarios.gpkg")]
    assert {"affected_area", "above_1_kPa"} <= set(layers)
    read = pyogrio.raw.read(tmp_path / "out" / "scenarios.gpkg", layer="affected_area")
    assert list(read[3][0]) == ["10 years", "300 years"]
    assert (tmp_path / "out" / "pictures" / "scenarios.png").is_file()
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Affected area of each scenario" in page and "share of runs" not in page
    assert Campaign(tmp_path / "out").done == 2
