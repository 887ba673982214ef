"""The saw test that the guide shows."""

import re

import pytest

import snowmpm
from snowmpm.reading.toml_text import tables
from snowmpm.scenes import Scene
from tests.support.project import ROOT

GUIDE = (ROOT / "docs" / "saw_tests.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_scene_of_the_guide_finds_what_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slope30.toml").write_text(re.search(r"```toml\n(.*?)```", GUIDE, re.DOTALL)[1], encoding="utf-8")
    found = snowmpm.run(snowmpm.load_scene("slope30.toml"), tmp_path / "run").summary["saw_test"]
    told = re.search(r"a critical length of ([\d.]+) ± ([\d.]+) m", GUIDE)
    assert found["critical_length"] == pytest.approx(float(told[1]), abs=0.005)
    assert found["critical_length_resolution"] == pytest.approx(float(told[2]))
    assert found["runs_to_the_end"]


def test_the_scene_of_the_guide_loads():
    text = re.search(r"```toml\n(.*?)```", GUIDE, re.DOTALL)[1]
    scene = Scene.model_validate(tables(text, "guide"))
    assert len(scene.saw_test.slab) == 2 and scene.saw_test.ends == "vertical"
