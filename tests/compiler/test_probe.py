"""What is tried of the installed Taichi when it starts."""

import contextlib

import numpy as np
import pytest

from snowmpm.compiler import launch, patches, probe, runtime, ti
from snowmpm.errors import InputError

pytestmark = pytest.mark.usefixtures("taichi")


def test_a_taichi_that_passed_is_not_tried_again(tmp_path, monkeypatch):
    monkeypatch.setattr(probe, "_passed", set())
    left_out = patches.reasons()
    probe.probe("cpu", 1, tmp_path / "kernels")
    assert patches.reasons() == left_out
    monkeypatch.setattr(probe, "_passed", set())  # as in another process
    monkeypatch.setattr(probe, "try_precision", pytest.fail)
    probe.probe("cpu", 1, tmp_path / "kernels")
    with pytest.raises(pytest.fail.Exception):  # elsewhere it has yet to pass
        probe.probe("cpu", 1, tmp_path / "others")


def test_the_note_of_what_passed_stays_short(tmp_path, monkeypatch):
    monkeypatch.setattr(probe, "MOST", 3)
    file = tmp_path / probe.FILE
    for i in range(4):
        probe._note(f"{i}", file)
    assert file.read_text() == "3\n"
    (tmp_path / "file").touch()
    probe._note("5", tmp_path / "file" / probe.FILE)  # where nothing can be written


def test_another_float_than_asked_for_is_an_error(monkeypatch):
    monkeypatch.setattr(probe, "working_precision", contextlib.nullcontext)
    with runtime.precision("f32"), pytest.raises(InputError, match=r"1/3 as 0.333333343\d+ where f64 .*\n.*1\.7\.4"):
        probe.try_precision("f64")


def test_a_taichi_without_a_setting_is_refused(monkeypatch):
    monkeypatch.setattr(probe, "SETTINGS", ("cfg_optimization", "no_such_thing"))
    with pytest.raises(InputError, match=r"has no setting no_such_thing:\nthis version cannot be used"):
        probe.try_settings()


def test_a_patch_that_gives_something_else_is_left_out(monkeypatch):
    monkeypatch.setattr(patches, "_patches", {"launch": patches.Patch("launch")})
    monkeypatch.setattr(launch, "taichi_kernel", lambda function: lambda *args: None)
    with pytest.warns(UserWarning, match=r"patch launch .*gives \[1\.0, 2\.0\] instead of \[3\.0, 5\.0\]"):
        probe.try_launch()
    assert not patches.is_applied("launch")


def test_two_threads_share_a_loop(monkeypatch):
    if runtime.threads() == 1:
        pytest.skip("Taichi was started with one thread")
    assert probe.two_threads_meet()
    # Within the iterations that a thread gets at a time, only one is there
    monkeypatch.setattr(probe, "SPREAD", 64)
    monkeypatch.setattr(probe, "PATIENCE", (1000, 1))
    assert not probe.two_threads_meet()


def test_loops_on_one_thread_are_warned_of(tmp_path, monkeypatch):
    monkeypatch.setattr(probe, "_passed", set())
    monkeypatch.setattr(probe, "two_threads_meet", lambda: False)
    for _ in range(2):  # never noted as passed
        with pytest.warns(UserWarning, match="does not hand 1024 iterations of a loop to two threads"):
            probe.probe("cpu", 2, tmp_path)


def test_the_probe_leaves_no_setting_changed():
    before = runtime.impl.get_runtime().default_fp
    probe.try_precision("f64")
    assert runtime.impl.get_runtime().default_fp is before
    array = ti.ndarray(ti.f64, 2)
    array.from_numpy(np.ones(2))
    assert array.to_numpy().tolist() == [1.0, 1.0]
