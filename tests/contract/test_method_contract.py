"""Nothing but the contract of a method is used by run loop, events, audit, maps, probes, settling, recorder,
description and advice: they work when all else of it is out of reach."""

import ast
from pathlib import Path

import pytest

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.methods import METHODS, Capabilities
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.contract import Particles
from snowmpm.particles.sorted_particles import SortedParticles
from snowmpm.running.failure import diagnose
from snowmpm.scenes.numerics import Output
from snowmpm.setup.model import Model
from snowmpm.sph.solver import SphSolver
from snowmpm.stepping.contract import Method
from tests.contract import strict
from tests.contract.method_examples import able, eventful, resting, scene


@pytest.fixture
def used(monkeypatch):
    """Members of the contracts that were asked for; every method of a scene is out of reach but for them."""
    made, found = Model.solver, set()
    monkeypatch.setattr(Model, "solver", lambda model: strict.strict(made(model), found))
    return found


def written(scene, end_time, interval, fields=("velocity", "p")):
    """A scene that ends then, with frames."""
    return scene.model_copy(update={"end_time": end_time, "output": Output(interval=interval, fields=fields)})


ASKED_OF_ALL = ("step", "totals", "state", "restore", "stable_dt")
ASKED_FOR = {"cuts": "sever", "loads": "push", "removal": "remove", "obstacles": "obstacle_totals"}


@pytest.mark.parametrize("method", METHODS)
def test_a_run_asks_for_nothing_else(method, used, tmp_path):
    """With events, forces, an obstacle and checkpoints; resumed to a later end."""
    snowmpm.run(written(eventful(method), 0.006, 0.006), tmp_path)
    run = snowmpm.run(written(eventful(method), 0.012, 0.006), tmp_path, resume=True)
    assert run.complete and run.times[-1] == pytest.approx(0.012)
    asked = *ASKED_OF_ALL, *(name for capability, name in ASKED_FOR.items() if METHODS[method].can(capability))
    assert {f"Method.{name}" for name in asked} <= used


@pytest.mark.parametrize("method", [name for name in METHODS if METHODS[name].can("settling")])
def test_settling_asks_for_nothing_else(method, used):
    assert snowmpm.Simulation(resting(method)).time == 0.0
    assert {"Method.damp", "Method.restart_clock"} <= used


@pytest.mark.parametrize("method", [name for name in METHODS if 3 in able(name).dimensions])
def test_maps_and_advice_ask_for_nothing_else(method, used, tmp_path):
    scene = written(eventful(method, 3, events=[]), 0.002, 0.001)
    assert "peak_depth" in snowmpm.run(scene, tmp_path).maps
    assert "Particles.sums_in_plan" in used
    advice = advise(scene)
    assert advice.facts["run_time"] > 0.0 and advice.facts["memory"] > 0
    assert {"Method.workload", "Method.memory", "Method.limits"} <= used


def test_a_saw_test_asks_for_nothing_else(used):
    scene = snowmpm.load_scene("pst_2d", {"solver.dx": 0.04, "saw_test.length": 1.2, "initial.stress": "geostatic"})
    simulation = snowmpm.Simulation(scene)
    for _ in range(2):
        simulation.step()
    simulation.crack._measure()
    assert "Particles.probe" in used


def test_a_failure_asks_for_nothing_else(used):
    simulation = snowmpm.Simulation(scene("mpm"))
    assert diagnose(simulation.scene.solver, simulation.solver, 1e-4) is None
    assert 'looks like "' in diagnose(simulation.scene.solver, simulation.solver, 1.0)


def test_more_than_the_contract_is_out_of_reach(used):
    solver = snowmpm.Simulation(scene("mpm")).solver
    with pytest.raises(AssertionError, match="grid is not of the contract Method"):
        getattr(solver, "grid", None)
    with pytest.raises(AssertionError, match="reals is not of the contract Particles"):
        _ = solver.particles.reals
    with pytest.raises(AssertionError, match="nobody may set steps"):
        solver.steps = 1


@pytest.mark.parametrize(("contract", "methods"), [(Method, [MpmSolver, SphSolver]), (Particles, [SortedParticles])])
def test_a_method_without_a_member_cannot_be_made(contract, methods):
    assert 8 <= len(contract.__abstractmethods__) <= 11
    for made in methods:
        assert not made.__abstractmethods__
    for name in contract.__abstractmethods__:
        lacking = type("Lacking", (methods[0],), {name: contract.__dict__[name]})
        with pytest.raises(TypeError, match=name):
            lacking()


@pytest.mark.parametrize("folder", ["running", "results", "setup", "saw_test", "io", "cli", "stepping", "particles",
                                    "handover"])
def test_nobody_asks_a_method_for_its_name(folder):
    """Capabilities decide. Advice has rules of single methods, and studies compare them by name."""
    for path in (Path(snowmpm.__file__).parent / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Compare):
                named = [part.value for part in ast.walk(node) if isinstance(part, ast.Constant)]
                assert "mpm" not in named and "sph" not in named, f"{path.name}: line {node.lineno}"


def test_every_method_is_a_row_of_capabilities():
    assert all(name == entry.name and isinstance(entry.capabilities, Capabilities) for name, entry in METHODS.items())


def test_options_of_a_method_are_a_table_of_the_solver():
    from snowmpm.scenes.numerics import Solver

    assert all(entry.options in Solver.model_fields for entry in METHODS.values() if entry.options)
