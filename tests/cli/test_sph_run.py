"""`snowmpm run --set solver.method=sph`, interrupted and resumed: the run that was never interrupted, bit for bit."""

import os
import signal

import numpy as np

import snowmpm
from snowmpm.sph.solver import SphSolver

STOP = 33
"""Step that is the last before the request to end."""


def test_an_interrupted_run_goes_on_bit_by_bit(call, block, monkeypatch):
    settings = ("--set", "solver.method=sph", "--set", "solver.dx=0.05", "--set", "end_time=0.04")
    assert call("run", block, *settings, "-o", "whole").code == 0
    step, taken = SphSolver.step, []

    def until_asked_to_end(solver, dt):
        step(solver, dt)
        taken.append(dt)
        if len(taken) == STOP:
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(SphSolver, "step", until_asked_to_end)
    stopped = call("run", block, *settings, "-o", "parts")
    assert stopped.code == 130 and "--resume" in stopped.err
    assert not snowmpm.Run("parts").complete
    assert call("run", block, *settings, "-o", "parts", "--resume").code == 0
    whole, parts = snowmpm.Run("whole"), snowmpm.Run("parts")
    assert parts.complete and STOP < len(taken) == whole.summary["steps"]  # none of them taken twice
    assert list(parts.times) == list(whole.times)
    for k in range(len(whole)):
        one, other = whole.frame(k), parts.frame(k)
        assert one.points.tobytes() == other.points.tobytes()
        for name, values in one.fields.items():
            assert values.tobytes() == other.fields[name].tobytes(), name
    # Beyond the frames: energies, momentum and impulses of every step that was told
    for name, values in whole.history.items():
        if "wall" not in name:
            assert np.array_equal(values, parts.history[name], equal_nan=True), name
