"""Structures that another program computes, by preCICE itself: the same plate in a program of its own.

Without the library (docs/precice.md) these are skipped; `test_external` has the same by a stand-in.
"""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

from snowmpm import Simulation
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


def assert_handed_over(simulation, received):
    """Momentum that the snow lost is what the other program received."""
    lost = simulation.obstacle_totals[:, :2].sum(axis=0)
    assert received == pytest.approx(lost, rel=1e-12, abs=1e-12 * np.abs(lost).max())
    assert simulation.audit()["structure_momentum_residual"] < 1e-12


def test_windows_of_one_step_are_weak_coupling(tmp_path):
    end = 0.06
    own = computed(scene(end))
    other, received, top = coupled(tmp_path, end)
    assert other.solver.steps == own.solver.steps > 20
    assert other.particles["position"] == pytest.approx(own.particles["position"], abs=1e-12)
    assert other.audit()["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], abs=1e-12)
    assert top == pytest.approx(own.audit()["plate_top_x"], abs=1e-12)
    assert_handed_over(other, received)


@pytest.mark.parametrize("scheme", [
    {"scheme": "serial-explicit"}, {"scheme": "serial-explicit", "first": "Solid"}, {"scheme": "parallel-explicit"}])
@pytest.mark.parametrize("names", [{}, {"velocity": None}])
def test_explicit_windows_of_several_steps(tmp_path, scheme, names):
    """Weak coupling to the first order of the window: 10 windows, each the sixth part of a period of the contact."""
    end = 0.06
    other, received, top = coupled(tmp_path, end, names, steps=3, size=end / 40, **scheme)
    assert other.audit()["plate_top_x"] == pytest.approx(0.04663, rel=0.03)
    if scheme.get("first") == "Solid" or scheme["scheme"] == "parallel-explicit":
        return
    assert_handed_over(other, received)


@pytest.mark.parametrize("scheme", ["serial-implicit", "parallel-implicit"])
def test_repeated_windows_of_one_step_are_strong_coupling(tmp_path, scheme):
    end, dt = 0.02, 0.001
    own = computed(scene(end, coupling="strong", dt=dt, density=150.0))
    other, received, top = coupled(tmp_path, end, density=150.0, keys={"dt": dt}, scheme=scheme, size=dt)
    assert other.dt_cause == "window" and other.solver.steps == 20
    row = other.audit()
    assert row["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], rel=1e-4)
    assert row["structure_unsettled"] == 0.0
    assert_handed_over(other, received)
