"""A run that was stopped and resumed against one that never was."""

import json
import os
import shutil
import signal

import numpy as np
import pytest

import snowmpm
from snowmpm import checkpoint, loop
from snowmpm.checkpoint import Checkpoints
from snowmpm.errors import InputError, SimulationError
from snowmpm.interruption import Interruption
from snowmpm.io.archive import read_archive, write_archive
from snowmpm.mpm.solver import MpmSolver
from snowmpm.scenes import load_scene

# A block on a weak layer that settles, is cut and loaded, and slides: particles sort, events are under way.
SCENE = """
name = "resumed"
dimension = 2
end_time = 0.3
[output]
interval = 0.025
fields = ["velocity", "density", "damage", "stress"]
[solver]
dx = 0.1
transfer = "aflip"
[domain]
min = [-1.0, -3.0]
max = [5.0, 2.0]
[terrain]
kind = "plane"
angle = 25.0
contact = "separate"
friction = 0.2
[materials.slab]
kind = "cohesive_cam_clay"
density = 250.0
youngs_modulus = 3.0e5
poisson_ratio = 0.3
critical_slope = 1.2
cohesion = 0.3
hardening = 1.0
p0 = 2.0e4
[materials.weak]
kind = "anticrack_cam_clay"
density = 150.0
youngs_modulus = 3.0e5
poisson_ratio = 0.3
critical_slope = 0.7
cohesion = 0.3
hardening = 0.5
softening = 1.8
p0 = 8.0e3
[[bodies]]
name = "weak"
material = "weak"
shape = { kind = "layer", bottom = 0.0, top = 0.2, region = { x = [0.0, 1.5] } }
[[bodies]]
name = "slab"
material = "slab"
shape = { kind = "layer", bottom = 0.2, top = 0.6, region = { x = [0.0, 1.5] } }
velocity = [2.0, -0.9]
[[bodies]]
name = "prop"
material = "slab"
shape = { kind = "box", min = [4.0, 1.0], max = [4.2, 1.2] }
[[events]]
kind = "cut"
body = "weak"
start = 0.05
speed = 8.0
path = [[0.0, 0.0], [1.5, -0.7]]
[[events]]
kind = "load"
body = "slab"
start = 0.08
stop = 0.25
centre = [0.8, 0.1]
radius = 0.4
force = [0.0, -300.0]
[[events]]
kind = "remove"
body = "prop"
start = 0.06
[initial]
stress = "geostatic"
"""

IN_MIDDLE = 0.13
"""[s]: cut and load under way, the prop removed, between two frames."""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "resumed.toml"
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture(scope="module")
def changed(scene):
    """changed({"solver.dx": 0.05}) -> the scene with other values."""
    return lambda overrides: load_scene(scene.source, overrides)


@pytest.fixture(scope="module")
def whole(scene, tmp_path_factory):
    """Folder of a run that never stopped."""
    folder = tmp_path_factory.mktemp("whole")
    snowmpm.run(scene, folder)
    return folder


@pytest.fixture(scope="module")
def stopped(scene, tmp_path_factory):
    """Folder of a run that Ctrl-C stopped in the middle."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.raises(KeyboardInterrupt, match=r"t = 0\.1.*checkpoint\.npz.*--resume"):
        _run_with_signal(scene, folder, signal.SIGINT, IN_MIDDLE)
    return folder


def _run_with_signal(scene, folder, number, time, resume=False):
    def progress(report):
        if report.time >= time:
            signal.raise_signal(number)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "PROGRESS_INTERVAL", 0.0)
        snowmpm.run(scene, folder, progress, resume=resume)


def _copy(folder, to):
    return shutil.copytree(folder, to / "run")


def _particles(folder):
    return read_archive(folder / checkpoint.FILE)["simulation"]


def _assert_same(one, other, path=""):
    """Equal to the last bit, NaN included."""
    assert type(one) is type(other), path
    if isinstance(one, dict):
        assert one.keys() == other.keys(), path
    if isinstance(one, dict | list):
        for key, a, b in [(k, one[k], other[k]) for k in (one if isinstance(one, dict) else range(len(one)))]:
            _assert_same(a, b, f"{path}.{key}")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype and one.tobytes() == other.tobytes(), path
    else:
        assert one == other, path


def _assert_same_runs(folder, other):
    """Final state, frames, history and summary are equal to the last bit."""
    _assert_same(_particles(folder), _particles(other))
    a, b = snowmpm.Run(folder), snowmpm.Run(other)
    assert b.complete
    _assert_same(a.times, b.times)
    _assert_same(a.history, b.history)
    for i in range(len(a)):
        _assert_same(a.frame(i).points, b.frame(i).points, f"points {i}")
        _assert_same(a.frame(i).fields, b.frame(i).fields, f"frame {i}")
    for name in ("steps", "sorts", "frames", "particle_steps", "dt_causes", "smallest_dt", "last", "time"):
        assert a.summary[name] == b.summary[name], name


def test_the_scene_does_what_the_test_is_about(whole):
    run, state = snowmpm.Run(whole), _particles(whole)
    assert state["solver"]["sorts"] > 2
    assert state["solver"]["removed"]["count"] > 0
    assert all(event["done"] for event in state["events"])
    assert run.frame(len(run) - 1).fields["damage"].max() == 1.0


def test_resumed_in_the_middle_of_events(scene, whole, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
    at_stop = read_archive(folder / checkpoint.FILE)
    assert [event["done"] for event in at_stop["simulation"]["events"]] == [False, False, True]
    assert at_stop["time"] not in snowmpm.Run(whole).times
    run = snowmpm.run(scene, folder, resume=True)
    assert run.provenance["resumed"] == [at_stop["time"]]
    _assert_same_runs(whole, folder)


def test_wall_time_adds_up(scene, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
    saved = read_archive(folder / checkpoint.FILE)
    write_archive(folder / checkpoint.FILE, {**saved, "phases": {**saved["phases"], "steps": 1000.0}})
    assert snowmpm.run(scene, folder, resume=True).summary["wall_time_of"]["steps"] > 1000.0


def test_resumed_many_times(scene, whole, tmp_path):
    times = [0.0, 0.04, 0.09, 0.15, 0.26]
    for i, time in enumerate(times):
        with pytest.raises(KeyboardInterrupt):
            _run_with_signal(scene, tmp_path, signal.SIGTERM, time, resume=i > 0)
    snowmpm.run(scene, tmp_path, resume=True)
    _assert_same_runs(whole, tmp_path)


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
    _assert_same_runs(whole, tmp_path)


def test_settled_only_once(changed, tmp_path, monkeypatch):
    layer = {"kind": "layer", "bottom": 0.0, "top": 0.3, "region": {"x": [0.0, 0.5]}}
    settling = changed({"initial.stress": "settle", "terrain.angle": 0.0, "terrain.contact": "stick", "events": [],
                        "bodies": [{"name": "slab", "material": "slab", "shape": layer}],
                        "end_time": 0.02, "output.interval": 0.01})
    whole, folder = tmp_path / "whole", tmp_path / "stopped"
    snowmpm.run(settling, whole)
    with pytest.raises(KeyboardInterrupt):
        _run_with_signal(settling, folder, signal.SIGINT, 0.005)
    monkeypatch.setattr(snowmpm.Simulation, "settle", None)
    snowmpm.run(settling, folder, resume=True)
    _assert_same_runs(whole, folder)


def test_a_finished_run_may_go_on(scene, changed, whole, tmp_path):
    folder = _copy(whole, tmp_path)
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
    _assert_same(*(read_archive(tmp_path / f"end{i}.npz")["simulation"] for i in range(2)))
    _assert_same(first.audit(), second.audit())


def test_restored_where_particles_are_about_to_be_sorted(scene, tmp_path):
    path = tmp_path / "one.npz"
    first, second = snowmpm.Simulation(scene), snowmpm.Simulation(scene)
    while first.solver.particles.sorts == 0:
        checkpoint.save(first, path)
        first.step()
    checkpoint.restore(second, path)
    second.step()
    assert second.solver.particles.sorts == 1
    _assert_same(first.particles["position"], second.particles["position"])


BALL = """
name = "ball"
dimension = 3
end_time = 0.04
gravity = 0.0
[output]
interval = 0.04
[solver]
dx = 0.1
[domain]
min = [-1.0, -1.0, -1.0]
max = [1.0, 1.0, 1.0]
[materials.ice]
kind = "elastic"
density = 300.0
youngs_modulus = 1.0e5
poisson_ratio = 0.2
[[bodies]]
name = "ball"
material = "ice"
shape = { kind = "sphere", centre = [0.0, 0.0, 0.0], radius = 0.1 }
velocity = [9.0, 3.0, -2.0]
"""


def test_peak_maps_go_on(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(BALL)
    ball, whole, folder = load_scene(path), tmp_path / "whole", tmp_path / "stopped"
    snowmpm.run(ball, whole)
    with pytest.raises(KeyboardInterrupt):
        _run_with_signal(ball, folder, signal.SIGINT, 0.012)  # before the first look at the maps, after half a cell
    snowmpm.run(ball, folder, resume=True)
    _assert_same_runs(whole, folder)
    assert snowmpm.Run(whole).maps
    for name, raster in snowmpm.Run(whole).maps.items():
        _assert_same(raster.values, snowmpm.Run(folder).maps[name].values, name)


@pytest.mark.parametrize("damage", ["torn", "changed", "missing"])
def test_damaged_checkpoint_gives_way_to_the_one_before(scene, whole, stopped, tmp_path, damage):
    folder = _copy(stopped, tmp_path)
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
    _assert_same_runs(whole, folder)


def test_both_checkpoints_damaged(scene, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
    for name in ("checkpoint.npz", "checkpoint.previous.npz"):
        (folder / name).write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(InputError, match=r"checkpoint\.npz: damaged"):
        snowmpm.run(scene, folder, resume=True)


def test_a_damaged_checkpoint_never_replaces_the_good_one(scene, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
    os.truncate(folder / checkpoint.FILE, 1000)
    with pytest.warns(UserWarning), pytest.raises(KeyboardInterrupt):
        _run_with_signal(scene, folder, signal.SIGINT, 0.0, resume=True)
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


@pytest.mark.parametrize("what", ["terrain", "obstacles"])
def test_changed_file_is_refused(scene, stopped, tmp_path, what):
    # The scene names the same file, but what was in it has changed.
    folder = _copy(stopped, tmp_path)
    write_archive(folder / checkpoint.FILE, {**read_archive(folder / checkpoint.FILE), what: "another"})
    with pytest.raises(InputError, match=f"{what}: not what it was when the run began"):
        snowmpm.run(scene, folder, resume=True)


def test_checkpoint_of_another_version_is_refused(scene, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
    write_archive(folder / checkpoint.FILE, {**read_archive(folder / checkpoint.FILE), "version": 99})
    with pytest.raises(InputError, match=r"version 99; this program reads snowmpm checkpoint version \d+"):
        snowmpm.run(scene, folder, resume=True)


def test_nothing_to_resume(scene, tmp_path):
    with pytest.raises(InputError, match=r"no checkpoint to resume from"):
        snowmpm.run(scene, tmp_path / "empty", resume=True)
    assert not (tmp_path / "empty").exists()


def test_another_run_file_is_refused(scene, stopped, tmp_path):
    folder = _copy(stopped, tmp_path)
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
        snowmpm.run(scene, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["complete"] is False
    assert not (tmp_path / "checkpoint.previous.npz").exists()


def test_full_disk_keeps_the_old_checkpoint(tmp_path, monkeypatch):
    path = tmp_path / "c.npz"
    write_archive(path, {"n": 1})

    def full(file, **arrays):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match=r"No space left on device: .*c\.npz"):
        write_archive(path, {"n": 2}, keep=tmp_path / "c.previous.npz")
    assert read_archive(path) == {"n": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_archive_gives_back_what_it_got(tmp_path):
    tree = {"a": [1, 2.5, None, True, "text"], "b": {"c": np.arange(6, dtype=np.int32).reshape(2, 3)},
            "third": 1.0 / 3.0, "far": float("-inf"), "empty": np.zeros((0, 4), np.float32), "zero-d": np.float64(0.1)}
    write_archive(tmp_path / "a.npz", tree)
    _assert_same(read_archive(tmp_path / "a.npz"), {**tree, "zero-d": 0.1})


def test_archive_with_a_part_of_another_is_refused(tmp_path):
    path, other = tmp_path / "a.npz", tmp_path / "b.npz"
    write_archive(path, {"x": np.arange(3.0)})
    with np.load(path) as archive:
        np.savez(other, **{**archive, "x": np.arange(3.0) + 1.0})
    with pytest.raises(InputError, match="checksum"):
        read_archive(other)


class Trap:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_archive_never_unpickles(tmp_path):
    path, sprung = tmp_path / "a.npz", tmp_path / "sprung"
    np.savez(path, record=np.array([Trap(sprung)], dtype=object), digest=np.zeros(32, np.uint8))
    with pytest.raises(InputError, match="damaged"):
        read_archive(path)
    assert not sprung.exists()


def test_a_small_archive_cannot_ask_for_much_memory(tmp_path):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, record=np.zeros(10_000_000, np.uint8), digest=np.zeros(32, np.uint8))
    with pytest.raises(InputError, match="sizes"):
        read_archive(path)


def test_second_signal_gets_through():
    before = signal.getsignal(signal.SIGTERM)
    with Interruption() as interruption:
        signal.raise_signal(signal.SIGTERM)
        assert interruption.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before
