"""What tells a run apart from others of its scene, in titles."""

import json

import pytest

from snowmpm.io.scenario import scenario_of


def test_the_folder_tells(tmp_path):
    assert scenario_of(tmp_path / "gully_300_years", "path") == "gully_300_years"
    assert scenario_of(tmp_path / "path", "path") == ""


def test_in_a_campaign_what_varies_tells(tmp_path):
    name = "0123456789abcdef"
    folder = tmp_path / "runs" / name
    folder.mkdir(parents=True)
    assert scenario_of(folder) == name
    plan = [{"hash": "f" * 16, "values": {"mu": 0.1}}, {"hash": name, "values": {"mu": 0.25, "ground": "rough"}}]
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    assert scenario_of(folder, "path") == "mu 0.25, ground rough"


@pytest.mark.parametrize("text", ["", "[", "[1]", "{}", '[{"hash": "0123456789abcdef"}]', "null", "[" * 9000,
                                  '[{"hash": "0123456789abcdef", "values": 3}]'])
def test_a_plan_that_is_none(tmp_path, text):
    folder = tmp_path / "runs" / "0123456789abcdef"
    folder.mkdir(parents=True)
    (tmp_path / "plan.json").write_text(text)
    assert scenario_of(folder) == "0123456789abcdef"
