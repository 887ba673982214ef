"""`snowmpm check` says where steps that are solved for are cheaper than those of waves, and where they are dearer (I9).

Each advice is followed here: the scene is run both ways, and both the answer and the processor time are as said.
"""

import time

import numpy as np
import pytest

from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.savings import savings
from snowmpm.advice.solved_steps import in_explicit_steps, in_solved_steps, slow
from snowmpm.measured.explicit_or_implicit import at_equal_error, in_words
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build

ELASTIC = {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}


def scene(solver=None, push="-2*tanh(3*t)", end_time=20.0, snow=None, **changes):
    """A block of snow between smooth walls whose load grows, and stays."""
    return Scene.model_validate({
        "name": "pressed", "dimension": 2, "end_time": end_time, "output": {"interval": 0.25 * end_time},
        "solver": {"dx": 0.1, "precision": "f64", **(solver or {})}, "materials": {"snow": snow or ELASTIC},
        "initial": {"stress": "geostatic"}, "forces": [{"kind": "acceleration", "value": ["0", push]}],
        "domain": {"min": [0.0, 0.0], "max": [0.5, 1.0],
                   "boundary": {"x_min": "slip", "x_max": "slip", "z_min": "stick"}},
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.5, 0.5]}}], **changes})


NEWMARK = {"implicit": {"time": "newmark"}}


def facts_of(given):
    model = build(given)
    return SceneFacts(given, model, model.solver())


def advised(facts):
    return [one for one in savings(facts.budget) if one.key == "solver.method"]


def run(given):
    """Heights of the particles at the end [m], and processor seconds of the steps, but for those to the first frame, in
    which kernels are compiled."""
    simulation, spent = Simulation(given), 0.0
    for frame in np.arange(1, 5) * given.output.interval:
        start = time.process_time()
        while simulation.time < frame * (1.0 - 1e-9):
            simulation.step(until=frame)
        spent += (time.process_time() - start) * (simulation.time > 1.5 * given.output.interval)
    particles = simulation.particles
    heights = np.empty(simulation.solver.particles.count)
    heights[particles["id"]] = particles["position"][:, 1]
    return heights, spent


def test_a_load_that_grows_slowly_is_seen():
    facts = facts_of(scene())
    [saving] = advised(facts)
    assert "quasi_static" in saving.says and in_words("slow_loading") in saving.says
    assert saving.seconds == pytest.approx(facts.budget.total - in_solved_steps(facts)[1].budget.total)


@pytest.mark.slow
def test_balances_for_a_load_that_grows_slowly():
    """Followed: the same settlement to 3 % of it, within which the waves still swing, in less time."""
    given = scene(end_time=2.0)
    facts = facts_of(given)
    overrides, _ = in_solved_steps(facts)
    heights, seconds = run(given)
    followed, less = run(with_overrides(given, overrides))
    start = facts.model.population.positions[:, 1]
    np.testing.assert_allclose(followed, heights, rtol=0, atol=0.03 * (start - heights).max())
    assert less < seconds


def test_waves_that_steps_are_solved_for_are_seen():
    facts = facts_of(scene(NEWMARK, push="-20", end_time=5.0))
    [saving] = advised(facts)
    assert '"mpm"' in saving.says and in_words("column") in saving.says
    assert saving.seconds == pytest.approx(facts.budget.total - in_explicit_steps(facts)[1].budget.total)


@pytest.mark.slow
def test_waves_in_place_of_steps_that_are_solved_for():
    """Followed: the other way round, in time."""
    given = scene(NEWMARK, push="-20", end_time=0.05)
    facts = facts_of(given)
    overrides, _ = in_explicit_steps(facts)
    heights, seconds = run(given)
    followed, less = run(with_overrides(given, overrides))
    start = facts.model.population.positions[:, 1]
    assert np.abs(followed - heights).max() < 0.2 * (start - heights).max()
    assert less < seconds


SAND = {"kind": "mohr_coulomb", "density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "friction_angle": 30.0,
        "dilation_angle": 0.0, "cohesion": 0.0}


@pytest.mark.parametrize("changes", [
    {"end_time": 0.4}, {"forces": []}, {"snow": SAND},
    {"bodies": [{"name": "block", "material": "snow", "velocity": [0.0, -1.0],
                 "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.5, 0.5]}}], "initial": {}}])
def test_what_swings_falls_apart_or_is_not_loaded_is_not_slow(changes):
    facts = facts_of(scene(**changes))
    assert not slow(facts) and in_solved_steps(facts) is None


def test_long_steps_are_left_alone():
    assert not advised(facts_of(scene({"implicit": {"time": "newmark", "dt": 1.0}})))
    assert not advised(facts_of(scene({"implicit": {"time": "quasi_static"}})))


def test_the_table_has_both_at_an_equal_error():
    """Where implicit steps win, and where they lose."""
    factors = {}
    for case in ("column", "beam", "settling", "saw_test", "slow_loading"):
        error, explicit, implicit = at_equal_error(case)
        assert 0.0 < error < 0.3 and explicit > 0.0 and implicit > 0.0
        factors[case] = explicit / implicit
    assert factors["column"] < 1.0 < factors["slow_loading"]
