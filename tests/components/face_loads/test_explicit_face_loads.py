"""Forces on a body's own surface in explicit MPM: resultant, moment and work; the static answer; ties; resumed runs."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from tests.components.forcing_and_damping.forced_block import SNOW, centre, mean_velocity, run, scene_of, stage

TOP = {"min": [-1.0, 0.4], "max": [1.0, 0.4]}


def solid(dim):
    return {"kind": "box", "min": [0.03] + [0.0] * (dim - 1), "max": [0.43] + [0.4] * (dim - 1)}


SLOW = pytest.mark.slow


@SLOW
@pytest.mark.parametrize(("transfer", "dim"), [("apic", 2), ("aflip", 2), ("flip", 2), ("pic", 2), ("apic", 3)])
def test_resultant_moment_and_work(transfer, dim):
    """A shear on the top of a free block: momentum t A T to round-off, and in APIC and AFLIP its turn about the centre
    of mass; the work is what the block has, but for the energy that the scheme takes."""
    top = {"min": [-1.0] * (dim - 1) + [0.4], "max": [1.0] * dim}
    solver = {"dx": 0.1, "precision": "f64", "transfer": transfer, "flip_ratio": 0.97}
    if transfer in ("flip", "pic"):
        solver["gradient"] = "shape"
    sim = stage(shape=solid(dim), solver=solver, forces=[{
        "kind": "traction", "name": "wind", "body": "block", "within": top,
        "value": [200.0] + [0.0] * (dim - 2) + [-100.0]}])
    row = run(sim, 2e-3)
    area = 0.4 ** (dim - 1)
    mass = 400.0 * 0.4**dim
    if transfer in ("apic", "aflip"):
        turn = "angular_momentum" if dim == 2 else "angular_momentum_y"
        # From x towards z in 2-D; about y, from z towards x, in 3-D: arm (0, 0.2) over the centre
        expected = (-0.2 if dim == 2 else 0.2) * 200.0 * area * sim.time
        assert row[turn] == pytest.approx(expected, rel=1e-9 if transfer == "apic" else 1e-2)
    row = run(sim, 2e-2)
    assert row["momentum_residual"] < 1e-12
    assert mass * mean_velocity(sim)[0] == pytest.approx(200.0 * area * sim.time, rel=1e-9)
    assert row["wind_force_x"] == pytest.approx(200.0 * area, rel=1e-9)
    assert row["wind_impulse_z"] == pytest.approx(-100.0 * area * sim.time, rel=1e-9)
    kept = row["kinetic_energy"] + row["affine_energy"] + row["elastic_energy"]
    assert 0.0 < kept < row["force_work"]
    assert kept > (0.6 if transfer == "pic" else 0.85) * row["force_work"]


def bar(method, **changes):
    """A part of a bar between two symmetric sides, its end and its flank off the grid; explicit steps are damped."""
    solver = {"mpm": {"dx": 0.1, "precision": "f64"},
              "implicit": {"method": "implicit", "dx": 0.1, "implicit": {"time": "quasi_static", "dt": 0.05}}}[method]
    return Simulation(Scene.model_validate({
        "name": "bar", "dimension": 2, "end_time": 0.5, "gravity": 0.0, "solver": solver, "output": {"interval": 0.5},
        "domain": {"min": [0.0, 0.0], "max": [3.0, 2.0], "boundary": {"x_min": "symmetric", "z_min": "symmetric"}},
        "materials": {"snow": {**SNOW, "poisson_ratio": 0.2}},
        "bodies": [{"name": "bar", "material": "snow",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [1.04, 0.23]}}],
        **({"damping": {"coefficient": 40.0}} if method == "mpm" else {}), **changes}))


END = {"min": [1.04, -1.0], "max": [1.04, 1.0]}
LOADS = {"traction": {"kind": "traction", "value": ["1e4*step(0, 0.3, t)", "0"]},
         "follower_pressure": {"kind": "follower_pressure", "value": "-1e4*step(0, 0.3, t)"},
         "displacement": {"kind": "displacement", "value": ["0.01*step(0, 0.3, t)", "0"], "contact": "slip",
                          "penalty": 10.0}}


@SLOW
@pytest.mark.parametrize("kind", LOADS)
def test_explicit_steps_come_to_the_static_answer(kind):
    """The same forces on the same grid, damped to rest, and as a balance: displacement of the end and reaction."""
    found = []
    for method in ("mpm", "implicit"):
        sim = bar(method, forces=[{**LOADS[kind], "name": "end", "body": "bar", "within": END}])
        row = run(sim, 0.5)
        far = sim.solver.adapters["face_loads"].faces.points.way[:, 0].mean()
        found.append((far, row["end_force_x"], row["max_speed"]))
    assert found[0][2] < 2e-3
    np.testing.assert_allclose(found[0][:2], found[1][:2], rtol=3e-3)


def test_a_tie_carries_a_body_along():
    """Drawn along a circle, with the block's own motion behind: the mean place is the prescribed one."""
    sim = stage(shape=solid(2), forces=[{"kind": "displacement", "name": "grip", "body": "block", "penalty": 20.0,
                                         "value": ["0.1*step(0, 0.2, t)", "0.05*step(0, 0.2, t)"]}])
    plain = stage(shape=solid(2))
    assert sim.solver.stable_dt()[0] < plain.solver.stable_dt()[0]
    start = centre(sim)
    row = run(sim, 0.3)
    np.testing.assert_allclose(centre(sim) - start, [0.1, 0.05], atol=2e-3)
    assert row["momentum_residual"] < 1e-11 and row["max_speed"] < 0.2


def test_ties_are_stable_up_to_the_step_that_they_ask_for():
    """A block thrown against its tie swings on: its energy does not grow, at the longest step of stable_dt."""
    for penalty in (10.0, 300.0):
        sim = stage(shape=solid(2), velocity=[1.0, 0.3], forces=[{
            "kind": "displacement", "name": "grip", "body": "block", "penalty": penalty, "value": [0.0, 0.0]}])
        energy = sim.audit()["kinetic_energy"]
        for _ in range(300):
            sim.step()
        row = sim.audit()
        assert row["kinetic_energy"] + row["elastic_energy"] - row["force_work"] < 1.05 * energy


@pytest.mark.parametrize("method", ["mpm", pytest.param("implicit", marks=SLOW)])
def test_resumed_to_the_bit(method, tmp_path):
    solver = {"dx": 0.1, "precision": "f64"} if method == "mpm" else {
        "method": method, "dx": 0.1, "implicit": {"time": "newmark", "dt": 2e-3}}
    forces = [{"kind": "follower_pressure", "name": "push", "body": "block", "value": "1e4*t", "within": TOP},
              {"kind": "displacement", "name": "grip", "body": "block", "value": ["0.1*t", "0"],
               "within": {"min": [0.0, 0.0], "max": [0.03, 0.4]}}]

    def scene(end_time):
        return scene_of(shape=solid(2), forces=forces, solver=solver, output={"interval": 0.01}, end_time=end_time)

    whole = snowmpm.run(scene(0.02), tmp_path / "whole")
    snowmpm.run(scene(0.01), tmp_path / "part")
    resumed = snowmpm.run(scene(0.02), tmp_path / "part", resume=True)
    assert np.array_equal(whole.frame(2).points, resumed.frame(2).points)
    for name in ("grip_force_x", "push_impulse_z", "force_work"):
        assert whole.history[name][-1] == resumed.history[name][-1] != 0.0
    assert whole.history["momentum_residual"].max() < 1e-9


PUSH = {"kind": "traction", "name": "push", "body": "block", "value": [1.0, 0.0]}


@pytest.mark.parametrize(("changes", "named"), [
    ({"forces": [{**PUSH, "within": {"min": [3.0, 3.0], "max": [4.0, 4.0]}}]}, "forces.0.within"),
    ({"forces": [PUSH], "initial": {"stress": "settle"}}, "forces.0.kind"),
    ({"forces": [PUSH], "solver": {"method": "sph", "dx": 0.1}}, "forces.0.kind"),
    ({"forces": [PUSH], "solver": {"dx": 0.1, "kernel": "gimp", "gradient": "shape", "transfer": "pic"}},
     "forces.0.kind"),
    ({"forces": [PUSH], "obstacles": [{"name": "wall", "shape": {"kind": "box", "min": [0.2, -1.0],
                                                                 "max": [0.6, 1.0]}}]}, "forces.0.body")])
def test_what_cannot_be_is_refused(changes, named):
    with pytest.raises(InputError) as refusal:
        stage(shape=solid(2), **changes)
    assert named in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2


@pytest.mark.parametrize(("changes", "named"), [
    ({"value": [1.0, 0.0, 0.0]}, "must have 2 entries"), ({"value": None}, "needs value or file"),
    ({"body": "other"}, "must be one of the bodies"), ({"kind": "displacement", "penalty": 0.0}, "greater than 0"),
    ({"kind": "displacement", "contact": "open"}, "contact"), ({"name": "a b"}, "name"),
    ({"within": {"min": [1.0, 0.0], "max": [0.0, 1.0]}}, "must not be below min"),
    ({"kind": "follower_pressure"}, "value")])
def test_wrong_tables(changes, named):
    with pytest.raises(ValueError, match=named):
        scene_of(shape=solid(2), forces=[{**PUSH, **changes}])
    with pytest.raises(ValueError, match="another of this name"):
        scene_of(shape=solid(2), forces=[PUSH, PUSH])
