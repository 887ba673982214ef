"""Structures that another program computes, by preCICE itself: the same plate in a program of its own.

Without the library (docs/precice.md) these are skipped; `test_external` has the same by a stand-in.
"""

import contextlib
import importlib.util
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from snowmpm import Simulation, load_scene
from tests.components.precice.coupled_plate import computed, config, scene
from tests.support.project import ROOT

BINDINGS = importlib.util.find_spec("precice")
pytestmark = pytest.mark.skipif(BINDINGS is None or BINDINGS.loader is None or BINDINGS.origin is None,
                                reason="preCICE is not installed")


@pytest.fixture(autouse=True)
def _logs_of_the_library(monkeypatch, tmp_path):
    """preCICE writes them to the folder that a program is started in."""
    monkeypatch.chdir(tmp_path)


@contextlib.contextmanager
def program(said, *words):
    """Another program while it is entered, which writes to the file `said`; -> its `subprocess.Popen`."""
    words, surroundings = [sys.executable, *map(str, words)], {**os.environ, "PYTHONPATH": str(ROOT)}
    with said.open("w") as out, subprocess.Popen(words, cwd=said.parent, env=surroundings, stdout=out) as other:
        try:
            yield other
        finally:
            other.kill()


def coupled(folder, end, names=None, steps=1, density=900.0, keys=None, **scheme):
    """(simulation at its end, impulse (2,) that the other program received [N s/m], displacement of its top [m])."""
    file = config(folder, end, **scheme)
    said = folder / "said.txt"
    plate = "tests.components.precice.coupled_plate"
    with program(said, "-m", plate, file, steps, json.dumps({"density": density})) as other:
        simulation = computed(scene(end, file, names=names, **(keys or {})))
        assert other.wait(timeout=120) == 0
    *received, top = map(float, said.read_text().splitlines()[-1].split())
    return simulation, np.array(received), top


def assert_handed_over(simulation, received, waiting=0.0, within=1e-12):
    """Momentum that the snow lost is what the other program received; waiting [s]: length of the last window, where
    that program is ahead, and its force comes too late; within: relative difference."""
    row = simulation.audit()
    last = np.array([row["plate_force_x"], row["plate_force_z"]])
    lost = simulation.obstacle_totals[:, :2].sum(axis=0) - waiting * last
    assert received == pytest.approx(lost, abs=within * np.abs(lost).max())
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
    other, received, _ = coupled(tmp_path, end, {"velocity": None}, density=150.0, keys={"dt": dt}, scheme=scheme,
                                 size=dt)
    assert other.dt_cause == "window" and other.solver.steps == 20
    row = other.audit()
    assert row["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], rel=1e-4)
    assert row["structure_unsettled"] == 0.0
    # Where both programs compute at once, the force is sought as well, to the same limit
    assert_handed_over(other, received, within=1e-12 if scheme == "serial-implicit" else 1e-4)


@pytest.mark.slow
def test_the_wall_of_the_library(tmp_path):
    """Strong coupling in steps of the snow against windows of several, without velocities, on a coarser grid, while the
    grains push the wall; gate chosen before."""
    end, coarse = 0.36, {"solver.dx": 0.008, "end_time": 0.36, "output.interval": 0.02}
    file = tmp_path / "wall.xml"
    text = (ROOT / "docs" / "precice_wall.xml").read_text().replace('directory="."', f'directory="{tmp_path}"')
    file.write_text(text.replace('<max-time value="0.4" />', f'<max-time value="{end}" />'))
    with program(tmp_path / "said.txt", ROOT / "docs" / "precice_wall.py", file) as other:
        simulation = Simulation(load_scene(ROOT / "docs" / "precice_wall.toml",
                                           coarse | {"structures.0.precice.file": str(file)}))
        found = tops(simulation)
        assert other.wait(timeout=120) == 0
    wanted = tops(Simulation(load_scene("flexible_wall_2d", coarse)))
    assert np.abs(wanted).max() > 1e-3
    assert np.abs(found - wanted).max() < 0.05 * np.abs(wanted).max()
    row = simulation.audit()
    assert row["structure_momentum_residual"] < 1e-12 and row["structure_unsettled"] == 0.0


def tops(simulation):
    """Displacement of the top of the wall [m] every 0.02 s."""
    found = []
    for k in range(1, round(simulation.scene.end_time / 0.02) + 1):
        while simulation.time < 0.02 * k - 1e-9:
            simulation.step(until=0.02 * k)
        found.append(simulation.audit()["wall_top_x"])
    return np.array(found)
