"""A run ends when its snow has come to rest: why is on record, resumed runs end alike, and events are waited for."""

import signal
from pathlib import Path

import pytest

import snowmpm
from snowmpm.io import Run
from snowmpm.quantities.motion import REST_MOMENTUM, REST_SHARE
from snowmpm.running.rest import rested
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library
from snowmpm.scenes.stop import ends_at_rest
from tests.support.same_runs import assert_same_runs, run_with_signal

SCENE = Path(__file__).with_name("at_rest.toml")
HOLD = 0.4


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return snowmpm.run(load_scene(SCENE), tmp_path_factory.mktemp("rested"))


def test_it_ends_at_rest_and_says_so(whole):
    assert rested(whole) and whole.complete and whole.times[-1] < 6.0
    since = float(whole.summary["ended"].split()[-2])
    assert whole.summary["ended"] == whole.provenance["ended"] == f"came to rest at t = {since:.6g} s"
    assert whole.times[-1] == pytest.approx(since + HOLD, abs=0.11)
    history = whole.history
    resting = (history["moving_share"] <= REST_SHARE) & (history["momentum_share"] <= REST_MOMENTUM)
    assert resting[history["time"] >= since - 1e-9].all()
    assert not resting[(history["time"] > 0.3) & (history["time"] < since - 0.15)].all()


def test_a_resumed_run_ends_alike(whole, tmp_path):
    middle = float(whole.times[-1]) - 0.5 * HOLD  # at rest already, but not long enough
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(load_scene(SCENE), tmp_path, signal.SIGINT, middle)
    resumed = snowmpm.run(load_scene(SCENE), tmp_path, resume=True)
    assert resumed.summary["ended"] == whole.summary["ended"]
    assert_same_runs(whole.path.parent, tmp_path)


def test_resuming_a_rested_run_does_nothing_unless_asked(whole, tmp_path):
    scene = load_scene(SCENE, {"end_time": 3.0, "stop.hold": 0.2})
    first = snowmpm.run(scene, tmp_path)
    assert rested(first)
    steps = first.summary["steps"]
    assert snowmpm.run(scene, tmp_path, resume=True).summary["steps"] == steps
    on = snowmpm.run(load_scene(SCENE, {"end_time": 3.0, "stop.at_rest": False}), tmp_path, resume=True)
    assert on.times[-1] == pytest.approx(3.0) and on.summary["ended"].startswith("end_time = 3 s, at rest since t = ")


def test_an_event_to_come_is_waited_for(tmp_path):
    load = {"kind": "load", "body": "slab", "start": 2.8, "ramp": 0.1, "centre": [0.8, 1.2], "radius": 5.0,
            "force": [10.0, 0.0]}
    scene = load_scene(SCENE, {"events": [load], "end_time": 3.1, "stop.at_rest": True, "stop.hold": 0.1})
    run = snowmpm.run(scene, tmp_path)
    assert run.times[-1] > 2.8


ON_A_PROFILE = ("crown_and_flanks", "natural_release", "remote_trigger_2d", "skier_trigger", "slushflow", "whumpf_2d")


@pytest.mark.parametrize("name", sorted(library()))
def test_which_library_scenes_end_at_rest(name):
    scene = load_scene(name)
    flows = name.startswith(("flow_", "impact_w", "avalanche_", "slab_release")) or name in ON_A_PROFILE
    assert ends_at_rest(scene) == flows


def test_a_slope_that_never_moved_is_not_at_rest(tmp_path):
    scene = load_scene(SCENE, {"end_time": 0.5, "terrain.friction": 0.9, "stop.hold": 0.1, "gravity": 1.0,
                               "initial.stress": "geostatic", "materials.snow.youngs_modulus": 1e6})
    run = snowmpm.run(scene, tmp_path)
    assert not rested(run) and run.times[-1] == pytest.approx(0.5)


def test_it_is_a_run_like_any_other_on_disk(whole):
    assert Run(whole.path.parent).complete
