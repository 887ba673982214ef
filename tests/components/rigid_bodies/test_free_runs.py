"""Scenes with free rigid bodies: what snow gives them, runs that are resumed, what is refused."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm import Simulation
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_same_runs, run_with_signal

G = 9.81
BOX = {"kind": "box", "min": [0.45, 0.0], "max": [0.85, 0.4]}
SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}


def scene(*obstacles, **more):
    """A block of soft snow that slides on level ground."""
    body = {"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]},
            "velocity": [3.0, 0.0]}
    return Scene.model_validate({
        "name": "pushed", "dimension": 2, "end_time": 0.2, "gravity": G, "output": {"interval": 0.05},
        "solver": {"dx": 0.1, "precision": "f64"}, "domain": {"min": [-1.0, -0.5], "max": [3.0, 2.0]},
        "terrain": {"kind": "plane", "contact": "separate", "friction": 0.2}, "materials": {"snow": SNOW},
        "bodies": [body], "obstacles": [{"name": "crate", "shape": BOX, **one} for one in obstacles], **more})


PUSHED = {"free": {"density": 400.0, "friction": 0.3}}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    snowmpm.run(scene(PUSHED), folder)
    return folder


def test_history_and_frames_tell_where_a_body_is(whole):
    run = snowmpm.Run(whole)
    history, crate = run.history, run.obstacles["crate"]
    assert history["crate_x"][0] == pytest.approx(0.65) and history["crate_x"][-1] > 0.75
    assert history["crate_velocity_x"].max() > 0.5
    # Frames show it where the history says
    corners = crate.placed(len(run) - 1)
    assert corners.mean(axis=0)[[0, 2]] + run.origin[[0, 2]] == pytest.approx(
        [history["crate_x"][-1], history["crate_z"][-1]], abs=1e-9)
    # It slides on the ground and does not sink in
    assert np.abs(corners[:, 2].min() + run.origin[2]) < 2e-3
    assert history["rigid_momentum_residual"].max() < 1e-12 and history["momentum_residual"].max() < 1e-10


def test_a_run_goes_on_as_if_it_had_not_stopped(whole, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(scene(PUSHED), tmp_path, signal.SIGTERM, 0.09)
    snowmpm.run(scene(PUSHED), tmp_path, resume=True)
    assert_same_runs(whole, tmp_path)
    one, other = (snowmpm.Run(folder).obstacles["crate"] for folder in (whole, tmp_path))
    assert one.rotation.tobytes() == other.rotation.tobytes()
    assert one.translation.tobytes() == other.translation.tobytes() and one.force.tobytes() == other.force.tobytes()


def test_a_body_of_the_mass_of_snow_takes_up_its_speed():
    """A crate as light as the grid allows, hit by an elastic block: no faster than what comes off one, and no gain."""
    crate = {"free": {"density": 320.0}, "shape": {**BOX, "min": [0.42, 0.0]}}
    simulation = Simulation(scene(crate, gravity=0.0, terrain=None))
    body, fastest = simulation.solver.adapters["rigid_bodies"].world.bodies[0], 0.0
    before = simulation.energies()["kinetic_energy"]
    while simulation.time < 0.2:
        simulation.step()
        fastest = max(fastest, np.linalg.norm(body.motion.velocity))
        assert body.motion.energy + simulation.energies()["kinetic_energy"] < before * (1.0 + 1e-9)
    # Two bodies of nearly one mass: between sticking together and a full exchange of their velocities
    assert 1.3 < body.motion.velocity[0] < 3.0 and fastest < 3.0


def test_a_body_is_held_until_its_start():
    simulation = Simulation(scene({"free": {"density": 400.0, "start": 0.1}}))
    crate = simulation.solver.adapters["rigid_bodies"].world.bodies[0]
    while simulation.time < 0.08:
        simulation.step()
    assert np.allclose(crate.motion.centre, [0.65, 0.2], rtol=0.0, atol=1e-15)
    assert simulation.solver.obstacle_totals[0, 0] > 0.0  # what held it took the push


def test_a_body_that_leaves_the_domain_is_let_go():
    simulation = Simulation(scene({"free": {"mass": 50.0, "velocity": [40.0, 0.0]}}, domain={
        "min": [-1.0, -0.5], "max": [1.2, 2.0]}))
    crate = simulation.solver.adapters["rigid_bodies"].world.bodies[0]
    for _ in range(60):
        simulation.step()
    assert crate.gone and not crate.motion.velocity.any() and crate.motion.centre[0] > 1.2


@pytest.mark.parametrize(("change", "words"), [
    ({"free": {}}, "obstacles.0.free = {}: needs density or mass"),
    ({"free.mass": 3.0}, "obstacles.0.free.density = 2600"),
    ({"free.density": -1.0}, "obstacles.0.free.density = -1"),
    ({"motion": {"velocity": [1.0, 0.0]}}, "does not go with motion"),
    ({"free.angular_velocity": [1.0, 0.0]}, "must be a number"),
    ({"free.density": 20.0}, "too light a free body for this grid"),
    ({"shape.points.0": [0.1, -0.6]}, "deep in the ground"),
    ({"shape.points": [[2.6, 0.01], [3.3, 0.01], [3.3, 0.5], [2.6, 0.5]]}, "deep in obstacle block_1"),
])
def test_what_cannot_be_is_refused_in_two_lines(change, words):
    with pytest.raises(InputError) as refusal:
        Simulation(snowmpm.load_scene("boulders_2d", {f"obstacles.0.{key}": value for key, value in change.items()}))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2


@pytest.mark.parametrize(("more", "words"), [
    ({"domain": {"min": [-1.0, -0.5], "max": [3.0, 2.0], "boundary": {"x_min": "periodic", "x_max": "periodic"}}},
     "does not go with periodic"),
])
def test_what_does_not_know_bodies_is_refused(more, words):
    with pytest.raises(InputError, match=words):
        Simulation(scene(PUSHED, **more))
