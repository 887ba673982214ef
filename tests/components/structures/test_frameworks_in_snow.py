"""Frameworks in snow: balances, both couplings, resume, names in the run file, refusals."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm import Simulation
from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_same_runs, run_with_signal

SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
RACK = {"name": "rack", "joints": {"a": [0.6, 0.0], "b": [0.6, 0.8], "c": [1.5, 0.0]},
        "feet": {"a": "fixed", "c": "pinned"}, "members": [{"ends": ["a", "b"], "segments": 3},
                                                           {"ends": ["c", "b"], "pinned": ["b"], "segments": 2}],
        "width": 0.2, "youngs_modulus": 2e6, "density": 900.0, "damping": 0.3, "friction": 0.0}


def scene(push, end_time=0.5, velocity=0.0, also=(), method="mpm", **rack):
    """A block of snow on a smooth floor, pressed or thrown against a screen with a strut behind it."""
    return Scene.model_validate({
        "name": "pressed", "dimension": 2, "end_time": end_time, "gravity": [push, 0.0], "output": {"interval": 0.05},
        "solver": {"dx": 0.1, "precision": "f64", "method": method}, "damping": {"coefficient": 20.0},
        "domain": {"min": [-1.0, 0.0], "max": [3.0, 2.0], "boundary": {"z_min": "slip"}}, "materials": {"snow": SNOW},
        "bodies": [{"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.5, 0.4]},
                    "velocity": [velocity, 0.0]}], "structures": [RACK | rack, *also]})


@pytest.fixture(scope="module", params=["mpm", "sph"])
def pressed(request, tmp_path_factory):
    return snowmpm.run(scene(0.5, end_time=0.8, method=request.param), tmp_path_factory.mktemp("pressed"))


def test_the_feet_bear_what_the_snow_gives(pressed):
    """At rest: snow and weight (which points along x here) on one side, both feet on the other; moments about the
    fixed foot likewise; the strut bears along itself, and more than half of it."""
    history, last = pressed.history, pressed.times > 0.7
    force, moment = np.zeros(2), 0.0
    for name, one in pressed.obstacles.items():
        load = one.force[one.time > 0.7].mean(axis=0)[[0, -1]]
        centre = (one.placed(0).mean(axis=0) + pressed.origin)[[0, -1]] - [0.6, 0.0]
        force += load
        moment += centre[0] * load[1] - centre[1] * load[0] + one.moment[one.time > 0.7].mean()
        assert name.startswith("rack_a-b_") or not load.any()
    assert force[0] == pytest.approx(300.0 * 0.2 * 0.5, rel=0.05)
    weight = 900.0 * 0.2 * 0.5 * np.array([0.8, np.hypot(0.9, 0.8)])

    def mean(name):
        return history[f"rack_{name}"][last].mean()

    feet = np.array([[mean(f"{foot}_force_{axis}") for axis in "xz"] for foot in "ac"])
    # Means of few rows of the history, and of all steps
    assert feet.sum(axis=0) == pytest.approx(force + np.array([weight.sum(), 0.0]), abs=0.005 * feet[:, 0].sum())
    turning = moment - 0.4 * weight.sum()
    assert mean("a_moment") + 0.9 * feet[1, 1] == pytest.approx(turning, rel=0.02)
    assert mean("c-b_axial") < 0.0 < mean("b_x") and abs(mean("c-b_last_moment")) < 0.02 * abs(mean("a_moment"))


def test_its_momentum_is_accounted_for(pressed):
    history = pressed.history
    assert history["structure_momentum_residual"].max() < 1e-9 and history["momentum_residual"].max() < 1e-10
    assert history["rack_largest_moment"][-1] == pytest.approx(
        max(history["rack_a-b_largest_moment"][-1], history["rack_c-b_largest_moment"][-1]))


def test_frames_show_it_bent(pressed):
    bent = pressed.obstacles["rack_a-b_3"]
    middle = bent.placed(len(pressed) - 1).mean(axis=0) - bent.placed(0).mean(axis=0)
    assert middle[0] > 0.5 * pressed.history["rack_b_x"][-1] > 0.0


def test_a_run_goes_on_as_if_it_had_not_stopped(tmp_path):
    struck = scene(0.0, end_time=0.12, velocity=5.0, yield_stress=2e3, strength=2.5e4)
    whole, folder = tmp_path / "whole", tmp_path / "stopped"
    run = snowmpm.run(struck, whole)
    with pytest.raises(KeyboardInterrupt):
        run_with_signal(struck, folder, signal.SIGTERM, 0.09)
    snowmpm.run(struck, folder, resume=True)
    assert_same_runs(whole, folder)
    assert run.history["rack_yielded"][-1] > 0 and run.history["rack_broken"][-1] > 0


def test_a_light_one_with_strong_coupling():
    """Lighter than the snow around it, which gives no energy: refused weak, calm strong."""
    light = {"density": 60.0, "youngs_modulus": 2e6, "damping": 0.0}
    with pytest.raises(InputError, match="too light for this grid"):
        Simulation(scene(0.0, velocity=2.0, **light))
    simulation = Simulation(scene(0.0, velocity=2.0, coupling="strong", **light))
    start = simulation.audit()["kinetic_energy"]
    while simulation.time < 0.15:
        simulation.step()
    row = simulation.audit()
    assert row["structure_unsettled"] == 0 < row["structure_rounds"] and row["rack_b_x"] != 0.0
    assert row["kinetic_energy"] + row["structure_energy"] < start
    assert row["structure_momentum_residual"] < 1e-9 and row["momentum_residual"] < 1e-10


def tripod(**more):
    """A light tripod of three legs that a cube of snow is thrown at, in space."""
    return Scene.model_validate({
        "name": "thrown", "dimension": 3, "end_time": 1.0, "gravity": [0.0, 0.0, 0.0],
        "solver": {"dx": 0.2, "precision": "f64"}, "materials": {"snow": SNOW},
        "domain": {"min": [-1.0, -1.5, 0.0], "max": [3.0, 1.5, 2.5]},
        "bodies": [{"name": "snow", "material": "snow", "velocity": [4.0, 0.0, 0.0],
                    "shape": {"kind": "box", "min": [-0.6, -0.4, 0.2], "max": [0.2, 0.4, 1.0]}}],
        "structures": [{"name": "tripod", "joints": {"a": [0.4, -0.5, 0.0], "b": [0.4, 0.5, 0.0], "c": [1.4, 0.0, 0.0],
                                                     "top": [0.5, 0.0, 1.2]},
                        "feet": dict.fromkeys("abc", "fixed"), "segments": 2, "friction": 0.2,
                        "members": [{"ends": ["a", "top"]}, {"ends": ["b", "top"]},
                                    {"ends": ["c", "top"], "pinned": ["top"]}],
                        "width": 0.12, "youngs_modulus": 2e8, "density": 300.0, "damping": 0.0, **more}]})


def test_a_light_one_in_space_with_strong_coupling():
    """The same: each leg is a third of the snow around it. Both give each other the same impulse."""
    with pytest.raises(InputError, match="too light for this grid"):
        Simulation(tripod())
    simulation = Simulation(tripod(coupling="strong"))
    start = simulation.audit()["kinetic_energy"]
    while simulation.time < 0.06:
        simulation.step()
    row = simulation.audit()
    assert row["structure_unsettled"] == 0 < row["structure_rounds"] and row["tripod_top_x"] > 1e-3
    assert row["kinetic_energy"] + row["structure_energy"] < start
    assert row["structure_momentum_residual"] < 1e-9 and row["momentum_residual"] < 1e-10
    # The blow comes in the middle: both legs in front bear it alike, and their feet
    both = [row[f"tripod_{leg}-top_axial"] for leg in "ab"]
    assert both[0] == pytest.approx(both[1], rel=0.02) and row["tripod_top_y"] == pytest.approx(
        0.0, abs=0.01 * row["tripod_top_x"])


def test_one_way_snow_meets_it_as_it_stood():
    one = Simulation(scene(0.5, coupling="one_way"))
    for _ in range(60):
        one.step()
    assert all(obstacle.still for obstacle in one.model.obstacles)
    assert one.audit()["rack_b_x"] > 0.0 and one.audit()["structure_momentum_residual"] < 1e-9


def mean_row(simulation, begin, end):
    """Numbers of the history, as means over the steps from `begin` to `end` [s]."""
    rows = []
    while simulation.time < end:
        simulation.step()
        if simulation.time > begin:
            rows.append(simulation.audit())
    return {name: np.mean([row[name] for row in rows]) for name in rows[0] if name.startswith(("rack", "structure"))}


def test_one_way_loads_have_their_static_answer():
    """Damped motion comes to the same, but for what it still swings; feet give in each step what the snow gives."""
    swings, rests = (mean_row(Simulation(scene(0.5, coupling="one_way", response=response)), 0.7, 0.8)
                     for response in ("dynamic", "static"))
    for name in ("rack_b_x", "rack_a_moment", "rack_c-b_axial", "rack_a_force_x"):
        assert rests[name] == pytest.approx(swings[name], rel=0.015)
    assert rests["structure_momentum_residual"] < 1e-12


def test_where_snow_begins_settled_it_begins_at_rest():
    """Under its weight and the snow that leans on it; else it swings under both."""
    swings = {}
    for stress in ("none", "settle"):
        made = scene(0.0, damping=0.02).model_dump()
        made.update(gravity=9.81, damping=None, initial={"stress": stress})
        simulation, ways = Simulation(Scene.model_validate(made)), []
        while simulation.time < 0.1:
            simulation.step()
            ways.append(simulation.audit()["rack_b_x"])
        assert simulation.audit()["structure_momentum_residual"] < 1e-12
        swings[stress] = np.std(ways) / np.abs(np.mean(ways))
    assert swings["settle"] < 1e-3 < 0.1 < swings["none"]


@pytest.mark.slow
def test_one_that_breaks_lets_the_snow_through():
    passed = []
    for strength in ({}, {"strength": 5e3}):
        simulation = Simulation(scene(0.0, velocity=6.0, damping=0.02, **strength))
        while simulation.time < 0.2:
            simulation.step()
        passed.append(simulation.audit())
    assert passed[0]["rack_broken"] == 0 < passed[1]["rack_broken"]
    held, broke = (np.hypot(row["rack_b_x"], row["rack_b_z"]) for row in passed)
    assert broke > 5.0 * held


PINNED = [{"ends": ["a", "b"], "pinned": ["a", "b"]}, {"ends": ["c", "b"], "pinned": ["c"]}]


@pytest.mark.parametrize(("change", "words"), [
    ({"feet": {"a": "pinned"}}, "a mechanism, not a structure: nothing holds joint"),
    ({"feet": {"e": "fixed"}}, "structures.0.feet = \"e\": must name one of the joints: a, b, c"),
    ({"feet": {}}, "structures.0.feet"), ({"feet": {"a": "glued"}}, "structures.0.feet.a"),
    ({"members": [{"ends": ["a", "x"]}]}, "structures.0.members.0.ends"),
    ({"members": [{"ends": ["a", "a"]}]}, "must be two different joints"),
    ({"members": [{"ends": ["a", "b"]}]}, "structures.0.joints.c"),
    ({"members": [*RACK["members"], {"ends": ["b", "a"]}]}, "two members join the same joints"),
    ({"members": [{"ends": ["a", "b"], "pinned": ["c"]}]}, "must be among its ends, a and b"),
    ({"width": 0.5}, "three times its width"), ({"wall": 0.05}, "is for tubes, in 3-D scenes"),
    ({"foot": [0.0, 0.0]}, "structures.0.foot"), ({"joints": {**RACK["joints"], "b": [0.6, 0.8, 1.0]}}, "2 numbers"),
    ({"joints": {**RACK["joints"], "c": [3.2, 0.0]}}, "structures.0.joints.c"),
    ({"segments": 33}, "structures.0.segments"), ({"density": 50.0}, "too light for this grid"),
    ({"response": "static"}, 'must be "dynamic" where coupling is not'),
])
def test_what_cannot_be_is_refused_in_two_lines(change, words, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(scene(0.0).to_toml())
    with pytest.raises(InputError) as refusal:
        Simulation(snowmpm.load_scene(file, {f"structures.0.{key}": value for key, value in change.items()}))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2
    assert "scene.toml" in str(refusal.value)


def test_names_that_begin_with_its_own_are_refused():
    with pytest.raises(InputError, match="must not be how the name of another begins: rack_2"):
        Simulation(scene(0.0, also=[RACK | {"name": "rack_2"}]))


def test_check_counts_its_segments():
    found = advise(scene(0.0, members=[{"ends": ["a", "b"], "segments": 20}, {"ends": ["c", "b"]}]))
    assert "structures.0.members.0.segments" in str(found)
