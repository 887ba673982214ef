"""Runs that are stopped by a signal, and whether two runs are equal to the last bit."""

import shutil
import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.io import checkpoint
from snowmpm.io.archive import read_archive
from snowmpm.running import loop
from tests.support.usual_signals import usual_signals


def run_with_signal(scene, folder, number, time, resume=False):
    def progress(report):
        if report.time >= time:
            signal.raise_signal(number)

    with pytest.MonkeyPatch.context() as patch, usual_signals():
        patch.setattr(loop, "PROGRESS_INTERVAL", 0.0)
        snowmpm.run(scene, folder, progress, resume=resume)


def copy(folder, to):
    return shutil.copytree(folder, to / "run")


def particles(folder):
    return read_archive(folder / checkpoint.FILE)["simulation"]


def assert_same(one, other, path=""):
    """Equal to the last bit, NaN included."""
    assert type(one) is type(other), path
    if isinstance(one, dict):
        assert one.keys() == other.keys(), path
    if isinstance(one, dict | list):
        for key, a, b in [(k, one[k], other[k]) for k in (one if isinstance(one, dict) else range(len(one)))]:
            assert_same(a, b, f"{path}.{key}")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype and one.tobytes() == other.tobytes(), path
    else:
        assert one == other, path


def assert_goes_on_alike(whole, until, folder, resumed=None):
    """A `Simulation` and another one of its scene, restored from its checkpoint as it is now, are equal to the last bit
    at the time `until` [s]; -> the other one. resumed: what `Simulation` takes of this name."""
    checkpoint.save(whole, folder / "one.npz")
    other = snowmpm.Simulation(whole.scene, resumed=resumed)
    checkpoint.restore(other, folder / "one.npz")
    for simulation, name in ((whole, "whole.npz"), (other, "other.npz")):
        while simulation.time < until:
            simulation.step(until=until)
        checkpoint.save(simulation, folder / name)
    one, two = (read_archive(folder / name)["simulation"] for name in ("whole.npz", "other.npz"))
    assert_same(one, two)
    assert_same(whole.audit(), other.audit())
    return other


def assert_same_runs(folder, other):
    """Final state, frames, history and summary are equal to the last bit."""
    assert_same(particles(folder), particles(other))
    a, b = snowmpm.Run(folder), snowmpm.Run(other)
    assert b.complete
    assert_same(a.times, b.times)
    assert_same(a.history, b.history)
    for i in range(len(a)):
        assert_same(a.frame(i).points, b.frame(i).points, f"points {i}")
        assert_same(a.frame(i).fields, b.frame(i).fields, f"frame {i}")
    for name in ("steps", "sorts", "frames", "particle_steps", "dt_causes", "smallest_dt", "last", "time"):
        assert a.summary[name] == b.summary[name], name
