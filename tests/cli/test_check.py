"""`snowmpm check`: what it prints of warnings, payments and savings."""

import json


def test_a_sound_scene(call, block):
    result = call("check", block)
    assert result.code == 0, result.err
    payments = result.out.partition("pays for")[2].partition("warnings")[0]
    assert max(len(line) for line in payments.splitlines()) <= 100
    for words in ("pays for", "law elastic", "calls of kernels", "warnings: none", "could do without"):
        assert words in result.out


def test_a_doubtful_one_is_warned_of_with_its_cure(call, block):
    result = call("check", block, "--set", "solver.transfer=pic", "--set", "solver.cfl=0.05", "--set", "end_time=20")
    assert result.code == 0
    assert "atlas: damped_waves" in result.out and 'transfer = "aflip"' in result.out
    assert "solver.cfl: leave it out" in result.out


def test_as_json(call, block):
    record = json.loads(call("check", block, "--set", "solver.transfer=pic", "--json").out)
    assert record["run_time"] > 0.0 and {item["entry"] for item in record["cautions"]} >= {"damped_waves", "lost_spin"}
    assert {item["what"] for item in record["payments"]} >= {"dimension", "output", "law elastic"}
    assert isinstance(record["savings"], list)


def test_what_fast_and_accurate_would_take(call, block):
    """Both are told of the scene as it is; asked for one, `check` is of the scene that `run` would then take."""
    record = json.loads(call("check", block, "--json").out)
    fast, accurate = record["along"]
    assert (fast["option"], accurate["option"]) == ("--fast", "--accurate")
    assert fast["seconds"] <= record["run_time"] <= accurate["seconds"]
    shown = call("check", block).out
    assert "--fast: about" in shown and "--accurate: about" in shown
    changed = call("check", block, "--accurate", "--json")
    assert abs(json.loads(changed.out)["run_time"] / accurate["seconds"] - 1.0) < 0.3
    assert "--accurate: " in changed.err
    assert call("check", block, "--fast", "--accurate").code == 2
