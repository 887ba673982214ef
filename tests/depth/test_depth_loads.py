"""Loads of a depth-averaged flow on what stands in its way: from its depth and speed, without a reaction."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io.impact import impacts
from snowmpm.scenes import Scene
from tests.support.same_runs import assert_same_runs, run_with_signal

DENSITY, G, SPEED, DEPTH = 200.0, 9.81, 12.0, 1.0
WALL = {"name": "wall", "shape": {"kind": "box", "min": [40.0, 8.0, -1.0], "max": [40.5, 12.0, 8.0]}}
MAST = {"name": "mast", "drag": 1.5, "shape": {"kind": "cylinder", "base": [50.0, 10.0, -1.0], "axis": [0.0, 0.0, 1.0],
                                               "radius": 0.25, "height": 9.0}}
LOW = {"name": "low", "shape": {"kind": "box", "min": [40.0, 8.0, -1.0], "max": [40.5, 12.0, 0.4]}}


def scene(*obstacles, friction=0.0, angle=0.0, **changes):
    """A broad layer that passes over level ground at one speed."""
    return Scene.model_validate({
        "name": "passing", "dimension": 3, "end_time": 1.0, "output": {"interval": 0.25},
        "solver": {"method": "depth", "dx": 1.0, "precision": "f64", "depth": {"damping": 0.0, "mixing": 0.0}},
        "domain": {"min": [0.0, 0.0, -60.0], "max": [100.0, 20.0, 20.0],
                   "boundary": {"y_min": "slip", "y_max": "slip"}},
        "terrain": {"kind": "plane", "angle": angle, "friction": friction},
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "layer", "material": "snow", "velocity": [SPEED, 0.0, 0.0], "shape": {
            "kind": "layer", "top": DEPTH, "region": {"x": [10.0, 90.0], "y": [0.0, 20.0]}}}],
        "obstacles": list(obstacles), **changes})


def force(run, name):
    """Means between frames (n, 3)."""
    return np.column_stack([run.history[f"{name}_force_{axis}"] for axis in "xyz"])[1:]


def test_force_of_a_steady_stream(tmp_path):
    """(c_d rho v² / 2 + rho g d / 2) d b of a layer that passes at one depth and speed: on a wall, a mast, and a low
    wall that it overtops; its moment about the middle of the wall."""
    run = snowmpm.run(scene(WALL, MAST, LOW), tmp_path / "run")
    for name, drag, depth, width in (("wall", 2.0, DEPTH, 4.0), ("mast", 1.5, DEPTH, 0.5), ("low", 2.0, 0.4, 4.0)):
        pressure = 0.5 * drag * DENSITY * SPEED**2 + 0.5 * DENSITY * G * depth
        np.testing.assert_allclose(force(run, name)[:, 0], pressure * depth * width, rtol=2e-3)
        np.testing.assert_allclose(force(run, name)[:, 1:], 0.0, atol=1e-6 * pressure)
        found = impacts(run)[name].numbers
        assert found["impact_peak_pressure"] == pytest.approx(pressure, rel=0.02)
        assert found["impact_steady_pressure"] == pytest.approx(pressure, rel=0.02)
        assert found["wetted_area"] == pytest.approx(depth * width, rel=0.02)
    middle = 0.5 * (8.0 - 1.0)
    np.testing.assert_allclose(run.history["wall_moment_y"][1:], (0.5 * DEPTH - middle) * force(run, "wall")[:, 0],
                               rtol=1e-9)


def test_weight_of_slow_snow(tmp_path):
    """At 0.3 m/s, 2 % of the load is that of the speed: rho g d^2 b / 2 and c_d rho v^2 d b / 2, on a wall that stands
    above the snow and on one that it overtops, d = 0.4 m. Asked to 0.5 %. Seen: round-off."""
    slow = {"name": "layer", "material": "snow", "velocity": [0.3, 0.0, 0.0], "shape": {
        "kind": "layer", "top": DEPTH, "region": {"x": [10.0, 90.0], "y": [0.0, 20.0]}}}
    run = snowmpm.run(scene(WALL, LOW, bodies=[slow]), tmp_path / "run")
    for name, depth in (("wall", DEPTH), ("low", 0.4)):
        weight, push = 0.5 * DENSITY * G * depth**2 * 4.0, DENSITY * 0.3**2 * depth * 4.0
        np.testing.assert_allclose(force(run, name)[:, 0], weight + push, rtol=0.005)


def test_the_flow_does_not_feel_it():
    with_wall, bare = (snowmpm.Simulation(scene(*obstacles)) for obstacles in ((WALL,), ()))
    for simulation in (with_wall, bare):
        for _ in range(20):
            simulation.step()
    np.testing.assert_array_equal(with_wall.particles["velocity"], bare.particles["velocity"])


def test_pressure_of_a_flow_that_arrives_between_two_frames(tmp_path):
    """Its depth at any time follows from the lever of the load: force over area is the pressure of depth and speed."""
    given = scene(WALL, angle=25.0, output={"interval": 0.5}).model_dump(mode="json", exclude_unset=True)
    given["bodies"][0]["shape"]["region"]["x"] = [10.0, 36.0]
    run = snowmpm.run(Scene.model_validate(given), tmp_path / "run")
    load, wall = impacts(run)["wall"], run.obstacles["wall"]
    late = wall.time > 0.7
    force = np.linalg.norm(wall.force, axis=1)[late]
    # What a plane of 25 degrees gives to a block without friction, and the pressure of its weight
    angle = np.radians(25.0)
    speed = SPEED / np.cos(angle) + G * np.sin(angle) * wall.time[late]
    assert force / load.wetted_at(wall.time[late]) == pytest.approx(DENSITY * speed**2, rel=0.05)


@pytest.mark.slow
def test_the_weight_of_a_deposit_stays_on_it(tmp_path):
    """On rough ground: the load rises with the flow, and ends with the weight of what came to rest, along the flow."""
    run = snowmpm.run(scene(WALL, friction=0.8, end_time=4.0), tmp_path / "run")
    loads = force(run, "wall")[:, 0]
    depth = run.frame(-1).fields["depth"]
    assert run.history["max_speed"][-1] < 0.01
    x = run.frame(-1).points[:, 0] + run.origin[0]
    near = np.abs(x - 40.25) < 1.0
    assert loads[0] > 10.0 * loads[-1]
    assert loads[-1] == pytest.approx(0.5 * DENSITY * G * np.median(depth[near]) ** 2 * 4.0, rel=0.05)


def test_resumed_to_the_bit(tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    snowmpm.run(scene(WALL, angle=20.0, friction=0.3), whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene(WALL, angle=20.0, friction=0.3), parts, signal.SIGTERM, 0.6)
    snowmpm.run(scene(WALL, angle=20.0, friction=0.3), parts, resume=True)
    assert_same_runs(whole, parts)
    assert force(snowmpm.Run(whole), "wall")[:, 0].min() > 0.0


def test_one_that_moves_is_refused():
    moving = {**WALL, "motion": {"velocity": [1.0, 0.0, 0.0]}}
    with pytest.raises(InputError, match=r"obstacles\.0\.motion") as refused:
        snowmpm.Simulation(scene(moving))
    assert len(str(refused.value).splitlines()) <= 2
