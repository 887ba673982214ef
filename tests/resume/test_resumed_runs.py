"""A run that was stopped and resumed against one that never was."""

import os
import signal
from pathlib import Path

import pytest

import snowmpm
from snowmpm.io import checkpoint
from snowmpm.io.archive import read_archive, write_archive
from snowmpm.io.checkpoint import Checkpoints
from snowmpm.running.interruption import Interruption
from snowmpm.scenes import load_scene
from tests.support.same_runs import assert_same, assert_same_runs, copy, particles, run_with_signal
from tests.support.usual_signals import usual_signals


def test_the_scene_does_what_the_test_is_about(whole):
    run, state = snowmpm.Run(whole), particles(whole)
    assert state["solver"]["sorts"] > 2
    assert state["solver"]["removed"]["count"] > 0
    assert all(event["done"] for event in state["events"])
    assert run.frame(len(run) - 1).fields["damage"].max() == 1.0
    assert run.history["steps_breaking"][-1] > 0 < run.history["steps_elastic"][-1]


def test_resumed_in_the_middle_of_events(scene, whole, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    at_stop = read_archive(folder / checkpoint.FILE)
    assert [event["done"] for event in at_stop["simulation"]["events"]] == [False, False, True]
    assert at_stop["time"] not in snowmpm.Run(whole).times
    run = snowmpm.run(scene, folder, resume=True)
    assert run.provenance["resumed"] == [at_stop["time"]]
    assert_same_runs(whole, folder)


def test_wall_and_processor_times_add_up(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    saved = read_archive(folder / checkpoint.FILE)
    before = {**saved["phases"], "steps": 1000.0, "processor": 2000.0}
    write_archive(folder / checkpoint.FILE, {**saved, "phases": before})
    summary = snowmpm.run(scene, folder, resume=True).summary
    assert summary["wall_time_of"]["steps"] > 1000.0 and summary["processor_time"] > 2000.0
    assert summary["wall_time"] == pytest.approx(sum(summary["wall_time_of"].values()), abs=0.01)


def test_resumed_many_times(scene, whole, tmp_path):
    times = [0.0, 0.04, 0.09, 0.15, 0.26]
    for i, time in enumerate(times):
        with pytest.raises(KeyboardInterrupt):
            run_with_signal(scene, tmp_path, signal.SIGTERM, time, resume=i > 0)
    snowmpm.run(scene, tmp_path, resume=True)
    assert_same_runs(whole, tmp_path)


def test_resumed_after_frames_that_the_checkpoint_does_not_know(scene, whole, changed, tmp_path, monkeypatch):
    # As after kill -9: the checkpoint is older than the last frames.
    path = tmp_path / checkpoint.FILE
    monkeypatch.setattr(Checkpoints, "finish", lambda self: None)  # else the older checkpoint is removed at the end
    often = changed({"output.checkpoint_interval": 0.11})
    snowmpm.run(often, tmp_path)
    os.replace(checkpoint.previous(path), path)
    assert read_archive(path)["time"] == pytest.approx(0.22, abs=0.01)  # a step late at most
    assert snowmpm.Run(tmp_path).times[-1] == 0.3
    snowmpm.run(scene, tmp_path, resume=True)
    assert_same_runs(whole, tmp_path)


def test_settled_only_once(changed, tmp_path, monkeypatch):
    layer = {"kind": "layer", "bottom": 0.0, "top": 0.3, "region": {"x": [0.0, 0.5]}}
    settling = changed({"initial.stress": "settle", "terrain.angle": 0.0, "terrain.contact": "stick", "events": [],
                        "bodies": [{"name": "slab", "material": "slab", "shape": layer}],
                        "end_time": 0.02, "output.interval": 0.01})
    whole, folder = tmp_path / "whole", tmp_path / "stopped"
    snowmpm.run(settling, whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(settling, folder, signal.SIGINT, 0.005)
    monkeypatch.setattr(snowmpm.Simulation, "settle", None)
    snowmpm.run(settling, folder, resume=True)
    assert_same_runs(whole, folder)


def test_a_finished_run_may_go_on(scene, changed, whole, tmp_path):
    folder = copy(whole, tmp_path)
    assert not checkpoint.previous(folder / checkpoint.FILE).exists()
    run = snowmpm.run(changed({"end_time": 0.35}), folder, resume=True)
    assert run.times[-1] == 0.35 and len(run) == len(snowmpm.Run(whole)) + 2
    assert load_scene(folder / "scene.toml").end_time == 0.35


def test_simulation_alone(scene, tmp_path):
    path = tmp_path / "one.npz"
    first, second = snowmpm.Simulation(scene), snowmpm.Simulation(scene)
    while first.time < 0.1:
        first.step()
    checkpoint.save(first, path)
    checkpoint.restore(second, path)
    for i, simulation in enumerate((first, second)):
        for _ in range(20):
            simulation.step()
        checkpoint.save(simulation, tmp_path / f"end{i}.npz")
    assert_same(*(read_archive(tmp_path / f"end{i}.npz")["simulation"] for i in range(2)))
    assert_same(first.audit(), second.audit())


def test_restored_where_particles_are_about_to_be_sorted(scene, tmp_path):
    path = tmp_path / "one.npz"
    first, second = snowmpm.Simulation(scene), snowmpm.Simulation(scene)
    while first.solver.particles.sorts == 0:
        checkpoint.save(first, path)
        first.step()
    checkpoint.restore(second, path)
    second.step()
    assert second.solver.particles.sorts == 1
    assert_same(first.particles["position"], second.particles["position"])


def test_peak_maps_go_on(tmp_path):
    ball = load_scene(Path(__file__).with_name("ball.toml"))
    whole, folder = tmp_path / "whole", tmp_path / "stopped"
    snowmpm.run(ball, whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(ball, folder, signal.SIGINT, 0.012)  # before the first look at the maps, after half a cell
    snowmpm.run(ball, folder, resume=True)
    assert_same_runs(whole, folder)
    assert snowmpm.Run(whole).maps
    for name, raster in snowmpm.Run(whole).maps.items():
        assert_same(raster.values, snowmpm.Run(folder).maps[name].values, name)


def test_second_signal_gets_through():
    before = signal.getsignal(signal.SIGTERM)
    with usual_signals(), Interruption() as interruption:
        signal.raise_signal(signal.SIGTERM)
        assert interruption.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_terminal_that_closes_stops_a_run_like_ctrl_c(scene, whole, tmp_path):
    with pytest.raises(KeyboardInterrupt, match=r"checkpoint\.npz"):
        run_with_signal(scene, tmp_path, signal.SIGHUP, 0.1)
    snowmpm.run(scene, tmp_path, resume=True)
    assert_same_runs(whole, tmp_path)


def test_a_display_that_is_gone_stops_no_run(scene, whole, tmp_path):
    def gone(report):
        raise BrokenPipeError

    snowmpm.run(scene, tmp_path, gone)
    assert_same_runs(whole, tmp_path)
