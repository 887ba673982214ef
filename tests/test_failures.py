"""What goes wrong in a run is found at once and said in two lines, with the last checkpoint."""

from pathlib import Path

import pytest

import snowmpm
import snowmpm.setup.build
from snowmpm import memory
from snowmpm.cli.app import app
from snowmpm.errors import InputError, SimulationError
from snowmpm.mpm.solver import MpmSolver
from snowmpm.scenes import load_scene
from snowmpm.sph.solver import SphSolver

BLOCK = Path(__file__).parent / "cli" / "block.toml"


METHODS = {"mpm": MpmSolver, "sph": SphSolver}


@pytest.fixture(params=["mpm", pytest.param("sph", marks=pytest.mark.slow)])
def block(request):
    return load_scene(BLOCK, {"solver.method": request.param})


@pytest.fixture
def solver(block):
    return METHODS[block.solver.method]


def test_collapse_of_the_time_step(block, solver, tmp_path, monkeypatch):
    stable = solver.stable_dt
    monkeypatch.setattr(solver, "stable_dt",
                        lambda self: (stable(self)[0] * (1e-6 if self.steps > 2 else 1.0), "advective"))
    with pytest.raises(SimulationError, match=r"step fell to .* advective limit.*\n.*; last checkpoint: .* t = 0 s"):
        snowmpm.run(block, tmp_path)
    assert len(snowmpm.Run(tmp_path)) >= 1


def test_a_particle_that_is_no_more(block, tmp_path, monkeypatch):
    """Which, when and where, what helps, and where a run may go on from: in two lines."""
    step = snowmpm.Simulation.step

    def failing(self, until=None):
        if self.solver.steps == 3:
            store = self.solver.particles
            table = store.table()
            table[5, store.layout.columns("velocity")] = float("nan")
            store.overwrite(table)
        step(self, until)

    monkeypatch.setattr(snowmpm.Simulation, "step", failing)
    with pytest.raises(SimulationError, match=r"^.*particle \d+.* t = .*\n.*last checkpoint: .*$") as error:
        snowmpm.run(block, tmp_path)
    assert str(error.value).count("\n") == 1


def test_a_time_step_that_is_no_number(block, solver, tmp_path, monkeypatch):
    stable = solver.stable_dt
    monkeypatch.setattr(solver, "stable_dt",
                        lambda self: (stable(self)[0] if self.steps < 5 else float("nan"), "elastic"))
    with pytest.raises(SimulationError, match="time step fell to nan s"):
        snowmpm.run(block, tmp_path)


def test_an_unconverged_return_map_is_told_once(block, solver, tmp_path, monkeypatch):
    step = solver.step

    def failing(self, dt):
        step(self, dt)
        self.unconverged += 1

    monkeypatch.setattr(solver, "step", failing)
    with pytest.warns(UserWarning, match=r"return map did not converge at t = .*\n.*checkpoint") as told:
        run = snowmpm.run(block, tmp_path)
    assert sum("return map" in str(one.message) for one in told) == 1
    assert run.history["unconverged"][-1] > 1


@pytest.mark.parametrize("command", ["check", "run"])
def test_memory_is_asked_before_it_is_taken(command, tmp_path, monkeypatch, capsys):
    """A scene of 4e11 particles is refused at once, whatever the machine."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        app([command, str(BLOCK), "--set", "solver.dx=1e-6", "--set", "bodies.0.shape.max=[1.0,1.1]"])
    message = capsys.readouterr().err
    assert end.value.code == 2 and not any(tmp_path.iterdir())
    assert "its particles: needs about" in message and "are free; a coarser solver.dx needs less" in message


def test_memory_that_just_suffices(block, monkeypatch):
    particles = len(snowmpm.setup.build.build(block).population.volumes)
    monkeypatch.setattr(memory, "available", lambda: 2 * memory.PER_PARTICLE[2] * particles)
    snowmpm.setup.build.build(block)
    monkeypatch.setattr(memory, "available", lambda: 0.5 * memory.PER_PARTICLE[2] * particles)
    with pytest.raises(InputError, match=r"bodies\.0 \(block\): shape: its particles: needs about"):
        snowmpm.setup.build.build(block)


@pytest.mark.parametrize("height", [1e7, 1e12])
def test_an_obstacle_far_larger_than_the_snow_is_refused_by_sph(height):
    """Its dummies would fill the memory: a box of 5 km that moves, for cells of 0.1 m, took 5 GiB and minutes."""
    piston = {"name": "piston", "shape": {"kind": "box", "min": [-1.0, 1.0], "max": [2.0, height]},
              "contact": "separate", "motion": {"velocity": [0.0, -1.0]}}
    with pytest.raises(InputError, match=r"dummy particles of SPH .* a smaller obstacle"):
        snowmpm.Simulation(load_scene(BLOCK, {"solver.method": "sph", "obstacles": [piston]}))
