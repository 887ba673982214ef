"""Structures in snow (X5): moments and deflections against beams under the same loads, balances, resume, refusals."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm import Simulation
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_same_runs, run_with_signal

SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
PLATE = {"name": "plate", "foot": [0.5, 0.0], "top": [0.5, 0.6], "width": 0.2, "youngs_modulus": 2e6, "density": 900.0,
         "segments": 6, "damping": 0.3, "friction": 0.0}
STIFF = 2e6 * 0.2**3 / 12.0


def scene(push, end_time=0.5, velocity=0.0, **plate):
    """A block of snow on a smooth floor, pressed against a plate."""
    body = {"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]},
            "velocity": [velocity, 0.0]}
    return Scene.model_validate({
        "name": "pressed", "dimension": 2, "end_time": end_time, "gravity": [push, 0.0], "output": {"interval": 0.05},
        "solver": {"dx": 0.1, "precision": "f64"}, "damping": {"coefficient": 20.0},
        "domain": {"min": [-1.0, 0.0], "max": [3.0, 2.0], "boundary": {"z_min": "slip"}}, "materials": {"snow": SNOW},
        "bodies": [body], "structures": [PLATE | plate]})


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pressed")
    return snowmpm.run(scene(0.5, end_time=0.8), folder)


def test_moment_at_the_foot_is_that_of_the_loads(pressed):
    history, moment = pressed.history, 0.0
    for s in range(6):
        load = pressed.obstacles[f"plate_{s + 1}"]
        last = load.time > 0.7
        force, own = load.force[last].mean(axis=0), load.moment[last].mean()
        centre = np.array([0.5, 0.05 + 0.1 * s])
        moment += (centre[0] - 0.5) * force[2] - centre[1] * force[0] + own
    last = pressed.times > 0.7
    # The weight of the plate, which points along x here, bends it too
    weight = 900.0 * 0.2 * 0.6 * 0.5
    assert history["plate_foot_moment"][last].mean() == pytest.approx(moment - 0.3 * weight, rel=0.02)
    assert moment < -1.0


def test_the_plate_bends_as_a_beam_under_its_loads(pressed):
    """w = integral of M (L - z) / E I by the trapezoidal rule, which is what the chain does: 1.4 to 2.8 % beyond the
    beam with six segments."""
    loads = []
    for s in range(6):
        load = pressed.obstacles[f"plate_{s + 1}"]
        last = load.time > 0.7
        loads.append((0.05 + 0.1 * s, load.force[last].mean(axis=0)[0], load.moment[last].mean()))

    def tip(n):
        z, moment = 0.6 * np.arange(n + 1) / n, 0.0
        for a, force, couple in loads:
            moment = moment + np.where(z < a, force * (a - z) - couple, 0.0)
        moment = moment + 0.5 * 900.0 * 0.2 * 0.5 * (0.6 - z) ** 2  # its own weight
        return float(((y := moment * (0.6 - z))[1:] + y[:-1]).sum()) * 0.3 / n / STIFF

    found = pressed.history["plate_top_x"][pressed.times > 0.7].mean()
    assert found == pytest.approx(tip(6), rel=0.015)
    assert found == pytest.approx(tip(6000), rel=0.045)


def test_its_momentum_is_accounted_for(pressed):
    history = pressed.history
    assert history["structure_momentum_residual"].max() < 1e-9 and history["momentum_residual"].max() < 1e-10
    # At rest the snow's weight along x is what the segments take
    force = sum(one.impulse[-1, 0] - np.interp(0.7, one.time, one.impulse[:, 0])
                for one in pressed.obstacles.values()) / 0.1
    assert force == pytest.approx(300.0 * 0.16 * 0.5, rel=0.05)


def test_frames_show_it_bent(pressed):
    top = pressed.obstacles["plate_6"]
    middle = top.placed(len(pressed) - 1).mean(axis=0) + pressed.origin
    assert middle[0] - 0.5 > 0.5 * pressed.history["plate_top_x"][-1] > 0.0
    assert pressed.obstacles["plate_1"].rotation.shape == (len(pressed), 3, 3)


def test_one_way_snow_meets_it_as_it_stood():
    one = Simulation(scene(0.5, coupling="one_way"))
    for _ in range(60):
        one.step()
    assert all(obstacle.still for obstacle in one.model.obstacles)
    assert one.audit()["plate_top_x"] > 0.0 and one.audit()["structure_momentum_residual"] < 1e-9


def test_a_run_goes_on_as_if_it_had_not_stopped(tmp_path):
    struck = scene(0.0, end_time=0.15, velocity=3.0, yield_stress=2e3)
    whole, folder = tmp_path / "whole", tmp_path / "stopped"
    snowmpm.run(struck, whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(struck, folder, signal.SIGTERM, 0.09)
    run = snowmpm.run(struck, folder, resume=True)
    assert_same_runs(whole, folder)
    assert run.history["plate_yielded"][-1] > 0 and run.history["plate_largest_moment"][-1] > 0.0
    one, other = (snowmpm.Run(each).obstacles["plate_6"] for each in (whole, folder))
    assert one.translation.tobytes() == other.translation.tobytes()


def test_a_plate_that_breaks_lets_the_snow_through():
    passed = []
    for strength in ({}, {"strength": 2e3}):
        simulation = Simulation(scene(0.0, velocity=6.0, damping=0.02, **strength))
        while simulation.time < 0.3:
            simulation.step()
        passed.append(simulation.audit())
    assert passed[0]["plate_broken"] == 0 < passed[1]["plate_broken"]
    assert passed[1]["plate_top_x"] > 2.0 * passed[0]["plate_top_x"]


@pytest.mark.parametrize(("change", "words"), [
    ({"width": 0.9}, "structures.0.width = 0.9"), ({"wall": 0.4}, "at most half of width"),
    ({"segments": 1}, "structures.0.segments = 1"), ({"density": 20.0}, "too light for this grid"),
    ({"foot": [90.0, 0.0, 0.0], "top": [90.0, 0.0, 2.0]}, "snow cannot reach any of it"),
    ({"top": [1.0, 2.0]}, "must be 3 numbers"), ({"coupling": "stiff"}, "structures.0.coupling"),
])
def test_what_cannot_be_is_refused_in_two_lines(change, words):
    with pytest.raises(InputError) as refusal:
        Simulation(snowmpm.load_scene("mast", {f"structures.0.{key}": value for key, value in change.items()}))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2
