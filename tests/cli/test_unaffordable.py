"""Runs that would never end are told what they would cost before they start, and run only when that is accepted."""

import json
import time

import pytest

from snowmpm import load_scene
from snowmpm.advice import affordability
from snowmpm.advice.affordability import LONGEST, many_bodies
from snowmpm.advice.facts import MOST_PAIRED, SceneFacts
from snowmpm.amounts import large, long_time
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build


@pytest.mark.parametrize("setting", ["end_time=1e12", "output.interval=1e-12", "solver.dt=1e-12", "solver.cfl=1e-12"])
def test_a_run_without_end_is_refused_with_its_cost(call, block, tmp_path, setting):
    began, out = time.monotonic(), tmp_path / "run"
    result = call("run", block, "-o", str(out), "--set", setting, "--set", "gravity=0.0")
    assert result.code == 2 and not (out / "run.vtkhdf").exists()
    assert "would take" in result.err and "--accept-cost" in result.err
    assert len(result.err.strip().splitlines()) <= 2
    assert time.monotonic() - began < 120.0


def test_check_says_the_same_and_ends(call, block):
    result = call("check", block, "--set", "end_time=1e12")
    assert result.code == 0 and "out of reach" in result.out and "years" in result.out
    record = json.loads(call("check", block, "--set", "end_time=1e12", "--json").out)
    assert record["run_time"] > LONGEST and "disk" in record["unaffordable"]
    assert json.loads(call("check", block, "--json").out)["unaffordable"] is None


def test_who_accepts_the_cost_runs(call, block, tmp_path, monkeypatch):
    monkeypatch.setattr(affordability, "LONGEST", 1e-9)
    arguments = ("run", block, "-o", str(tmp_path / "run"), "--quiet")
    assert call(*arguments).code == 2
    assert call(*arguments, "--accept-cost").code == 0


def test_a_full_disk_is_foreseen(call, block, tmp_path, monkeypatch):
    monkeypatch.setattr(affordability, "_free_disk", lambda folder: 1000)
    result = call("run", block, "-o", str(tmp_path / "run"))
    assert result.code == 2 and "of which 1000 B are free" in result.err


def test_what_is_left_of_a_resumed_run_counts(call, block, tmp_path, monkeypatch):
    out = str(tmp_path / "run")
    assert call("run", block, "-o", out, "--quiet").code == 0
    refused = call("run", block, "-o", out, "--resume", "--set", "end_time=1e12")
    assert refused.code == 2 and "would take about" in refused.err
    monkeypatch.setattr(affordability, "LONGEST", 1e-9)
    assert call("run", block, "-o", out, "--resume", "--quiet").code == 0  # nothing is left


def test_many_bodies_are_named_and_their_pairs_left_out():
    boxes = [{"name": f"b{i}", "material": "snow",
              "shape": {"kind": "box", "min": [0.1 * i, 0.0], "max": [0.1 * i + 0.1, 0.1]}}
             for i in range(MOST_PAIRED + 1)]
    snow = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
    scene = Scene.model_validate({"name": "many", "dimension": 2, "end_time": 1.0, "solver": {"dx": 0.1},
                                  "materials": {"snow": snow}, "bodies": boxes})
    assert f"{MOST_PAIRED + 1} bodies" in many_bodies(scene)
    model = build(scene)
    assert SceneFacts(scene, model, model.solver()).pairs == []
    assert many_bodies(load_scene("whumpf_2d")) is None


def test_amounts_have_two_digits():
    times = [long_time(t) for t in (1.5, 600.0, 86400.0 * 45, 8.5e11)]
    assert times == ["1.5 s", "10 minutes", "45 days", "27 000 years"]
    assert [large(size) for size in (4.3e16, 8.2e10, 12.0)] == ["43 PB", "82 GB", "12 B"]
