"""Snow against obstacles, from the scene to the run file: what the snow loses, the obstacle gets."""

import numpy as np
import pytest

import snowmpm
from snowmpm import Simulation
from snowmpm.errors import InputError
from snowmpm.render import render_history, render_run
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build

GRAVITY = 9.81
BLOCK = {2: ([0.0, 0.1], [0.4, 0.3]), 3: ([0.0, 0.0, 0.1], [0.4, 0.2, 0.3])}


def scene(dim, obstacle, *, velocity=None, gravity=0.0, end_time=0.3, **more):
    lower, upper = BLOCK[dim]
    material = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
    body = {"name": "block", "material": "snow", "shape": {"kind": "box", "min": lower, "max": upper},
            "velocity": velocity or [0.0] * dim}
    return Scene.model_validate({
        "name": "impact", "dimension": dim, "end_time": end_time, "gravity": gravity,
        "solver": {"dx": 0.1, "precision": "f64"}, "domain": {"min": [-2.0] * dim, "max": [3.0] * dim},
        "materials": {"snow": material}, "bodies": [body], "obstacles": [{"name": "wall", **obstacle}], **more})


def run_to(simulation, time):
    """Impulse that the snow lost until then [N s], gravity's left out, and the totals of the obstacle."""
    mass = simulation.particles["mass"]
    before = mass @ simulation.particles["velocity"]
    while simulation.time < time:
        simulation.step(until=time)
    lost = before + simulation.solver.weight_impulse - mass @ simulation.particles["velocity"]
    return lost, simulation.solver.obstacle_totals[0]


def test_a_wall_gets_the_momentum_of_what_hits_it_and_no_work():
    wall = {"shape": {"kind": "box", "min": [0.53, -1.0], "max": [0.73, 1.0]}, "friction": 0.2}
    simulation = Simulation(scene(2, wall, velocity=[2.0, 0.5]))
    lost, totals = run_to(simulation, 0.3)
    momentum = 2.0 * simulation.solver.particles.mass
    assert np.allclose(totals[:2], lost, rtol=0.0, atol=1e-12 * momentum)
    assert momentum < totals[0] < 2.0 * momentum  # it bounces off
    assert 0.0 < totals[1] <= 0.2 * totals[0]  # friction, at most Coulomb's
    # About the middle of the wall, at z = 0: pressed between the heights of the block, its face at the wall's.
    arms = np.array([(0.53 - 0.63) * totals[1] - z * totals[0] for z in (0.6, 0.1)])
    assert arms[0] < totals[2] < arms[1]
    assert totals[3] == 0.0
    assert simulation.particles["position"][:, 0].max() < 0.53


def test_a_floor_carries_the_weight_at_its_place():
    floor = {"shape": {"kind": "box", "min": [-1.0, -0.5], "max": [1.5, 0.1]}, "contact": "separate"}
    simulation = Simulation(scene(2, floor, gravity=GRAVITY, end_time=2.0))
    lost, totals = run_to(simulation, 2.0)
    weight = 2.0 * GRAVITY * simulation.solver.particles.mass
    assert np.allclose(totals[:2], lost, rtol=0.0, atol=1e-12 * weight)
    assert totals[1] == pytest.approx(-weight, rel=0.01)  # what is left is the momentum of its bouncing
    assert totals[2] == pytest.approx((0.2 - 0.25) * totals[1], rel=0.01)  # the arm from the middle of the floor


PADDLES = {
    2: ({"kind": "polygon", "points": [[0.45, 0.0], [0.5, 0.0], [0.5, 0.5], [0.45, 0.5]]}, [-0.5, 0.1], 60.0),
    3: ({"kind": "cylinder", "base": [0.5, -0.2, 0.0], "axis": [0.1, 1.0, 0.5], "radius": 0.08, "height": 0.8},
        [-0.5, 0.1, 0.0], [20.0, -40.0, 60.0]),
}


@pytest.mark.parametrize("dim", [2, 3])
def test_work_on_a_moving_obstacle_is_that_of_force_and_moment(dim):
    """W = J . v + L . omega for a motion that is uniform all the time: an identity of rigid bodies."""
    shape, velocity, turning = PADDLES[dim]
    moving = {"shape": shape, "motion": {"velocity": velocity, "angular_velocity": turning}, "contact": "slip"}
    simulation = Simulation(scene(dim, moving))
    lost, totals = run_to(simulation, 0.2)
    assert np.allclose(totals[:dim], lost, rtol=0.0, atol=1e-11 * np.abs(lost).max())
    omega = np.radians(np.atleast_1d(turning))
    work = totals[:dim] @ velocity + totals[dim:-1] @ omega
    assert totals[-1] == pytest.approx(work, rel=1e-9) and totals[-1] < -1.0  # it pushes the snow, not the snow it
    assert np.abs(totals[dim:-1]).min() > 0.0


def test_loads_reach_the_run_file_and_go_on_after_a_stop(tmp_path):
    shape, velocity, turning = PADDLES[2]
    moving = {"shape": shape, "motion": {"velocity": velocity, "angular_velocity": turning, "ramp": 0.03}}
    output = {"interval": 0.02}
    whole = snowmpm.run(scene(2, moving, end_time=0.1, output=output), tmp_path / "whole")
    snowmpm.run(scene(2, moving, end_time=0.06, output=output), tmp_path / "parts")
    parts = snowmpm.run(scene(2, moving, end_time=0.1, output=output), tmp_path / "parts", resume=True)
    one, other = whole.obstacles["wall"], parts.obstacles["wall"]
    for name in ("vertices", "facets", "rotation", "translation", "time", "force", "moment", "impulse", "work"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert len(one.time) == int(whole.history["steps"][-1])  # few steps: each has its row
    spans = np.diff(one.time, prepend=0.0)
    assert np.allclose(spans @ one.force, one.impulse[-1], rtol=1e-12, atol=0.0) and one.impulse[-1, 0] > 0.1
    last = one.time > 0.08
    mean = spans[last] @ one.force[last] / spans[last].sum()
    assert whole.history["wall_force_x"][-1] == pytest.approx(mean[0], rel=1e-9)
    assert whole.history["wall_force_x"][0] == 0.0 and whole.units["wall_moment"] == "N m/m"
    causes = [whole.history[f"steps_{cause}"][-1] for cause in ("elastic", "advective", "deformation", "output")]
    assert sum(causes) == whole.history["steps"][-1]
    # Where the film shows it: at 0.1 s it has turned by 60 degrees/s (0.1 s - half the ramp).
    angle = np.radians(60.0 * 0.085)
    assert one.rotation[-1] == pytest.approx(np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0],
                                                       [np.sin(angle), 0, np.cos(angle)]]))
    middle = one.placed(-1)[:, [0, 2]].mean(axis=0) + whole.origin[[0, 2]]
    assert middle == pytest.approx(np.array([0.475, 0.25]) + 0.085 * np.array(velocity))
    assert render_run(whole, tmp_path / "film.png", size=(320, 180)).is_file()
    assert render_history(whole, tmp_path / "history.png", dpi=50).is_file()


@pytest.mark.parametrize("dim", [2, 3])
def test_no_snow_starts_inside_an_obstacle(dim):
    mast = {"shape": {"kind": "sphere", "centre": [0.2] * dim, "radius": 0.09}}
    with_mast, without = (build(scene(dim, {"shape": {**mast["shape"], "radius": radius}})).population
                          for radius in (0.09, 1e-6))
    assert np.linalg.norm(with_mast.positions - 0.2, axis=1).min() > 0.09
    gone = np.linalg.norm(without.positions - 0.2, axis=1) < 0.09
    assert gone.sum() > 2 and np.array_equal(with_mast.positions, without.positions[~gone])
    with pytest.raises(InputError, match=r"bodies\.0 \(block\): lies wholly inside obstacles"):
        build(scene(dim, {"shape": {**mast["shape"], "radius": 2.0}}))


def test_a_wrong_obstacle_is_named(tmp_path):
    crossed = {"shape": {"kind": "polygon", "points": [[0, 0], [1, 1], [1, 0], [0, 1]]}}
    with pytest.raises(InputError, match=r"impact: obstacles\.0 \(wall\)\.shape\.points: .*crosses itself"):
        snowmpm.run(scene(2, crossed), tmp_path / "run")
    assert not (tmp_path / "run").exists()
