"""Nothing but the contract of a method is used by run loop, events, audit, maps, probes, settling, recorder,
description and advice: they work when all else of it is out of reach."""

import ast
from pathlib import Path

import pytest
import strict

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.methods import METHODS, Capabilities
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.contract import Particles
from snowmpm.particles.sorted_particles import SortedParticles
from snowmpm.running.failure import diagnose
from snowmpm.scenes.schema import Scene
from snowmpm.setup.model import Model
from snowmpm.sph.solver import SphSolver
from snowmpm.stepping.contract import Method

WEAK = {"kind": "anticrack_cam_clay", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "critical_slope": 1.0, "cohesion": 0.3, "hardening": 0.5, "p0": 2e4, "softening": 0.5}


@pytest.fixture
def used(monkeypatch):
    """Members of the contracts that were asked for; every method of a scene is out of reach but for them."""
    made, found = Model.solver, set()
    monkeypatch.setattr(Model, "solver", lambda model: strict.strict(made(model), found))
    return found


SOFT = {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}


def blocks(method, dimension, **changes):
    """Two blocks on a floor; what a run can have of events, forces, obstacles and output."""
    across = [] if dimension == 2 else [0.0]
    size = [] if dimension == 2 else [0.4]
    shape = {"kind": "box", "min": [0.0, *across, 0.0], "max": [0.4, *size, 0.4]}
    other = {"kind": "box", "min": [0.8, *across, 0.0], "max": [1.2, *size, 0.4]}
    flat = {f"{axis}_{end}": "slip" for axis in "yz"[3 - dimension:] for end in ("min",)}
    tables = {
        "name": "blocks", "dimension": dimension, "end_time": 0.008, "seed": 1,
        "solver": {"method": method, "dx": 0.2, "precision": "f64"},
        "output": {"interval": 0.004, "fields": ["velocity", "p"]},
        "domain": {"min": [-1.0, *across, 0.0], "max": [3.0, *size, 2.0],
                   "boundary": {**flat, **({"y_max": "slip"} if dimension == 3 else {})}},
        "materials": {"weak": WEAK if dimension == 2 else SOFT},
        "bodies": [{"name": "one", "material": "weak", "shape": shape},
                   {"name": "two", "material": "weak", "shape": other}],
        "initial": {"stress": "settle", "tolerance": 10.0}}
    return Scene.model_validate({**tables, **changes})


HAPPENS = {
    "events": [{"kind": "cut", "body": "one", "path": [[0.0, 0.2], [0.4, 0.2]], "start": 0.001},
               {"kind": "load", "body": "one", "centre": [0.2, 0.3], "radius": 0.3, "force": [0.0, -10.0]},
               {"kind": "load", "body": "one", "force": [0.0, -10.0]},
               {"kind": "remove", "body": "two", "start": 0.002}],
    "obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [1.6, 0.0], "max": [1.8, 1.0]}}],
    "forces": [{"kind": "acceleration", "value": ["0.1", "0.0"]}],
}


@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_a_run_asks_for_nothing_else(method, used, tmp_path):
    """With events, forces, an obstacle and checkpoints; resumed to a later end."""
    snowmpm.run(blocks(method, 2, **HAPPENS, end_time=0.004), tmp_path)
    run = snowmpm.run(blocks(method, 2, **HAPPENS), tmp_path, resume=True)
    assert run.complete and run.times[-1] == pytest.approx(0.008)
    asked = ("step", "sever", "push", "remove", "set_loads", "damp", "totals", "state", "restore", "obstacle_totals")
    assert {f"Method.{name}" for name in asked} <= used


@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_maps_and_advice_ask_for_nothing_else(method, used, tmp_path):
    scene = blocks(method, 3, initial={"stress": "none"}, end_time=0.002, output={"interval": 0.001})
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
    simulation = snowmpm.Simulation(blocks("mpm", 2))
    assert diagnose(simulation.scene.solver, simulation.solver, 1e-4) is None
    assert 'looks like "' in diagnose(simulation.scene.solver, simulation.solver, 1.0)


def test_more_than_the_contract_is_out_of_reach(used):
    solver = snowmpm.Simulation(blocks("mpm", 2, initial={"stress": "none"})).solver
    with pytest.raises(AssertionError, match="grid is not of the contract Method"):
        getattr(solver, "grid", None)
    with pytest.raises(AssertionError, match="reals is not of the contract Particles"):
        _ = solver.particles.reals
    with pytest.raises(AssertionError, match="nobody may set steps"):
        solver.steps = 1


@pytest.mark.parametrize(("contract", "methods"), [(Method, [MpmSolver, SphSolver]), (Particles, [SortedParticles])])
def test_a_method_without_a_member_cannot_be_made(contract, methods):
    assert 9 <= len(contract.__abstractmethods__) <= 15
    for made in methods:
        assert not made.__abstractmethods__
    for name in contract.__abstractmethods__:
        lacking = type("Lacking", (methods[0],), {name: contract.__dict__[name]})
        with pytest.raises(TypeError, match=name):
            lacking()


@pytest.mark.parametrize("folder", ["running", "results", "setup", "saw_test", "io", "cli", "stepping", "particles"])
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
