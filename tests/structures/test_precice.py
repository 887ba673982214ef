"""Structures that another program computes, by preCICE itself: the same plate in a program of its own.

Without the library (docs/precice.md) these are skipped; `test_external` has the same by a stand-in.
"""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

from tests.structures.test_external import computed
from tests.support.coupled_plate import config, scene
from tests.support.project import ROOT

pytestmark = pytest.mark.skipif(importlib.util.find_spec("precice") is None, reason="preCICE is not installed")


def coupled(folder, end, names=None, steps=1, density=900.0, keys=None, **scheme):
    """(simulation at its end, impulse (2,) that the other program received [N s/m], displacement of its top [m])."""
    file = config(folder, end, **scheme)
    program = [sys.executable, "-m", "tests.support.coupled_plate", str(file), str(steps),
               json.dumps({"density": density})]
    with subprocess.Popen(program, cwd=ROOT, stdout=subprocess.PIPE, text=True) as other:
        try:
            simulation = computed(scene(end, file, names=names, **(keys or {})))
            said = other.communicate(timeout=120)[0].splitlines()[-1]
        finally:
            other.kill()
    *received, top = map(float, said.split())
    return simulation, np.array(received), top


def assert_handed_over(simulation, received, waiting=0.0):
    """Momentum that the snow lost is what the other program received; waiting [s]: length of the last window, where
    that program is ahead, and its force comes too late."""
    row = simulation.audit()
    last = np.array([row["plate_force_x"], row["plate_force_z"]])
    lost = simulation.obstacle_totals[:, :2].sum(axis=0) - waiting * last
    assert received == pytest.approx(lost, rel=1e-12, abs=1e-12 * np.abs(lost).max())
    assert row["structure_momentum_residual"] < 1e-12


def test_windows_of_one_step_are_weak_coupling(tmp_path):
    end = 0.06
    own = computed(scene(end))
    other, received, top = coupled(tmp_path, end)
    assert other.solver.steps == own.solver.steps > 20
    assert other.particles["position"] == pytest.approx(own.particles["position"], abs=1e-12)
    assert other.audit()["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], abs=1e-12)
    assert top == pytest.approx(own.audit()["plate_top_x"], abs=1e-12)
    assert_handed_over(other, received)


@pytest.mark.parametrize("names", [{}, {"velocity": None}])
@pytest.mark.parametrize(("ahead", "scheme"), [
    (False, {"scheme": "serial-explicit"}), (True, {"scheme": "serial-explicit", "first": "Solid"}),
    (True, {"scheme": "parallel-explicit"})])
def test_explicit_windows(tmp_path, ahead, scheme, names):
    """The other program takes three steps in each window."""
    end, size = 0.06, 0.0015
    other, received, _ = coupled(tmp_path, end, names, steps=3, size=size, **scheme)
    assert_handed_over(other, received, waiting=size if ahead else 0.0)
    assert other.audit()["plate_top_x"] == pytest.approx(0.04663, rel=0.03)


@pytest.mark.parametrize("scheme", ["serial-implicit", "parallel-implicit"])
def test_repeated_windows_of_one_step_are_strong_coupling(tmp_path, scheme):
    end, dt = 0.02, 0.001
    own = computed(scene(end, coupling="strong", dt=dt, density=150.0))
    other, received, _ = coupled(tmp_path, end, density=150.0, keys={"dt": dt}, scheme=scheme, size=dt)
    assert other.dt_cause == "window" and other.solver.steps == 20
    row = other.audit()
    assert row["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], rel=1e-4)
    assert row["structure_unsettled"] == 0.0
    assert_handed_over(other, received)
