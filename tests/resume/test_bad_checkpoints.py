"""Checkpoints that are damaged, or of another scene, file or version: the one before, or a refusal with a reason."""

import json
import os
import signal

import pytest

import snowmpm
from snowmpm.errors import InputError, SimulationError
from snowmpm.io import checkpoint
from snowmpm.io.archive import read_archive, write_archive
from snowmpm.mpm.solver import MpmSolver
from tests.support.same_runs import assert_same_runs, copy, run_with_signal


@pytest.mark.parametrize("damage", ["torn", "changed", "missing"])
def test_damaged_checkpoint_gives_way_to_the_one_before(scene, whole, stopped, tmp_path, damage):
    folder = copy(stopped, tmp_path)
    path = folder / checkpoint.FILE
    if damage == "torn":
        os.truncate(path, path.stat().st_size // 2)
    elif damage == "changed":
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    else:
        path.unlink()
    if damage == "missing":
        snowmpm.run(scene, folder, resume=True)
    else:
        with pytest.warns(UserWarning, match=r"checkpoint\.npz: damaged.*checkpoint\.previous\.npz is used"):
            snowmpm.run(scene, folder, resume=True)
    assert_same_runs(whole, folder)


def test_both_checkpoints_damaged(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    for name in ("checkpoint.npz", "checkpoint.previous.npz"):
        (folder / name).write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(InputError, match=r"checkpoint\.npz: damaged"):
        snowmpm.run(scene, folder, resume=True)


def test_a_damaged_checkpoint_never_replaces_the_good_one(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    os.truncate(folder / checkpoint.FILE, 1000)
    with pytest.warns(UserWarning), pytest.raises(KeyboardInterrupt):
        run_with_signal(scene, folder, signal.SIGINT, 0.0, resume=True)
    for name in ("checkpoint.npz", "checkpoint.previous.npz"):
        assert read_archive(folder / name)["time"] >= 0.0


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"solver.cfl": 0.3}, r"solver\.cfl = 0\.3: was not there when the run began"),
        ({"materials.weak.p0": 7e3}, r"materials\.weak\.p0 = 7000\.0: was 8000\.0"),
        ({"events.0.speed": 9.0}, r"events\.0\.speed = 9\.0: was 8\.0"),
        ({"solver.precision": "f64"}, r"solver\.precision = 'f64': was 'f32'"),
        ({"solver.dt": 1e-4}, r"solver\.dt = 0\.0001: was not there"),
        ({"end_time": 0.2}, r"end_time = 0\.2: was 0\.3 .* may end later, not earlier"),
    ],
)
def test_changed_scene_is_refused(changed, stopped, overrides, message):
    before = {path.name: path.read_bytes() for path in stopped.iterdir()}
    with pytest.raises(InputError, match=message):
        snowmpm.run(changed(overrides), stopped, resume=True)
    assert {path.name: path.read_bytes() for path in stopped.iterdir()} == before


def test_changed_terrain_is_refused(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    write_archive(folder / checkpoint.FILE, {**read_archive(folder / checkpoint.FILE), "terrain": "another"})
    with pytest.raises(InputError, match="terrain: not what it was when the run began"):
        snowmpm.run(scene, folder, resume=True)


def test_checkpoint_of_another_version_is_refused(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    write_archive(folder / checkpoint.FILE, {**read_archive(folder / checkpoint.FILE), "version": 99})
    with pytest.raises(InputError, match=r"version 99; this program reads snowmpm checkpoint version \d+"):
        snowmpm.run(scene, folder, resume=True)


def test_a_run_that_never_began_starts(changed, tmp_path):
    """A job script can always say --resume."""
    folder = tmp_path / "empty"
    with pytest.warns(UserWarning, match="nothing to resume there yet: the run starts from its beginning"):
        run = snowmpm.run(changed({"end_time": 0.02}), folder, resume=True)
    assert run.complete


def test_a_run_killed_before_its_first_checkpoint_starts(changed, tmp_path):
    """What such a kill leaves: a run file with its first frame or none, or only its beginnings."""
    short, folder = changed({"end_time": 0.02}), tmp_path / "killed"

    def kill(simulation):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        snowmpm.run(short, folder, approve=kill)
    folder.mkdir(exist_ok=True)
    (folder / ".scene.unfinished.toml").write_text("half")
    with pytest.warns(UserWarning, match="nothing to resume"):
        assert snowmpm.run(short, folder, resume=True).complete


def test_frames_without_a_checkpoint_are_not_thrown_away(stopped, scene, tmp_path):
    folder = copy(stopped, tmp_path)
    for path in folder.glob("checkpoint*"):
        path.unlink()
    with pytest.raises(InputError, match=r"no checkpoint to resume from"):
        snowmpm.run(scene, folder, resume=True)


def test_an_edited_scene_in_the_folder_is_not_written_over(stopped, scene, tmp_path):
    folder = copy(stopped, tmp_path)
    (folder / "scene.toml").write_text("# mine\n" + (folder / "scene.toml").read_text())
    with pytest.raises(InputError, match=r"scene\.toml: was changed since the run began"):
        snowmpm.run(scene, folder, resume=True)


def test_another_run_file_is_refused(scene, stopped, tmp_path):
    folder = copy(stopped, tmp_path)
    with snowmpm.io.RunWriter(folder, provenance={}, dimension=2):
        pass
    with pytest.raises(InputError, match=r"0 frames up to t = .*not the file that it belongs to"):
        snowmpm.run(scene, folder, resume=True)


def test_failure_names_the_last_checkpoint(scene, tmp_path, monkeypatch):
    step = MpmSolver.step

    def failing(self, dt):
        if self.time > 0.1:
            raise SimulationError("particle 7 turned inside out")
        step(self, dt)

    monkeypatch.setattr(MpmSolver, "step", failing)
    (tmp_path / "checkpoint.previous.npz").write_bytes(b"of an earlier run")
    with pytest.raises(SimulationError, match=r"particle 7.*; last checkpoint: .*checkpoint\.npz, t = 0 s"):
        snowmpm.run(scene, tmp_path, overwrite=True)
    assert json.loads((tmp_path / "summary.json").read_text())["complete"] is False
    assert not (tmp_path / "checkpoint.previous.npz").exists()
