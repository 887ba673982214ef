"""The suite of `method_suite` over every method that is registered: a new method has its tests by being there."""

import contextlib
import inspect
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from snowmpm import components
from snowmpm.methods import CONTRACTS, METHODS, Capabilities
from tests.contract import toy_method
from tests.contract.capability_suite import CAPABILITIES, is_as_declared
from tests.contract.method_examples import EXAMPLES, Example, able, without_example
from tests.contract.method_suite import CHECKS
from tests.support.registered import registered
from tests.support.thread_counts import with_one_and_two_threads

VALUES = {"dimensions": (2, 3), "precisions": ("f32", "f64")}
"""What a scene may choose of a capability that is a set."""
CHOICES = {"filling", "usual_filling", "grid", "plan", "solves"}
"""Capabilities that no scene asks for: they say which of its choices count (`a_simulation_is_what_its_scene_says`)."""
ELSEWHERE = {"ground_friction": "scenes/test_ground_friction.py", "ground_cohesion": "scenes/test_ground_friction.py",
             "ground_rasters": "scenes/test_ground_friction.py", "contacts": "contract/test_depth_refusals.py",
             "sides": "contract/test_depth_refusals.py", "delays": "depth/test_depth_releases.py",
             "thickness_rasters": "depth/test_depth_releases.py", "moving_obstacles": "depth/test_depth_loads.py",
             "around_zone": "handover/test_zone.py", "within_zone": "handover/test_zone.py",
             "rows_of_jump": "verification/test_cracks_by_sph.py"}
"""Capabilities of the ground and the sides, and others, with the tests that ask for them and are refused."""
QUESTIONS = [(name, None) for name in CAPABILITIES] + [(name, value) for name in VALUES for value in VALUES[name]]
LONG = {("implicit", "dimensions", 3)}
"""Method, capability and value whose kernels take a minute to compile."""


def run(check, method, folder):
    check(*(method, folder)[:len(inspect.signature(check).parameters)])


def test_every_registered_method_has_an_example():
    assert not without_example()


def test_every_capability_is_asked_for():
    named = {*CONTRACTS, *(field.name for field in fields(Capabilities)), *(one.name for one in components.declared())}
    assert named == {*CAPABILITIES, *VALUES, *CHOICES, *ELSEWHERE}
    assert all((Path(__file__).parents[1] / file).is_file() for file in ELSEWHERE.values())


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("method", METHODS)
def test_method(method, check, tmp_path):
    run(check, method, tmp_path)


@pytest.mark.parametrize(("method", "capability", "value"), [
    pytest.param(method, *question, marks=[pytest.mark.slow] * ((method, *question) in LONG))
    for method in METHODS for question in QUESTIONS])
def test_capability(method, capability, value):
    is_as_declared(method, capability, value)


def bits(*dimension):
    """What `method_threads` prints with one thread and with two."""
    return [one["cases"] for one in with_one_and_two_threads("tests.contract.method_threads", *dimension)]


def assert_same_bits(one, two):
    assert one == two and one
    for case in one.values():
        assert case["sorts"] >= 1 and case["impulse"] > 0.0


def test_one_and_two_threads_leave_the_same_bits():
    one, two = bits()
    assert set(one) == set(METHODS)
    assert_same_bits(one, two)


@pytest.mark.slow
def test_one_and_two_threads_leave_the_same_bits_in_space():
    assert_same_bits(*bits(3))


# ---- the suite itself -----------------------------------------------------------------------------------------------


@pytest.fixture
def added(monkeypatch):
    """added(entry, example) adds a method and its example."""

    def add(entry, example=Example()):  # noqa: B008 - frozen
        assert entry.name not in METHODS
        stack.enter_context(registered(entry))
        assert without_example() == {entry.name}  # and the suite says so
        monkeypatch.setitem(EXAMPLES, entry.name, example)
        return entry.name

    with contextlib.ExitStack() as stack:
        yield add


def failures(method, folder):
    """Names of the checks and capabilities that a method does not pass."""
    failed = set()
    for check in CHECKS:
        (folder / check.__name__).mkdir()
        try:
            run(check, method, folder / check.__name__)
        except AssertionError:
            failed.add(check.__name__)
    for question in QUESTIONS:
        try:
            is_as_declared(method, *question)
        except (AssertionError, pytest.fail.Exception):
            failed.add(question[0])
    return failed


TOY = toy_method.ENTRY
IN_PLAN = replace(TOY, name="plan", capabilities=replace(TOY.capabilities, dimensions=(3,)))
"""As little as a method may be capable of: in space only, on the ground only, no obstacles."""


@pytest.mark.parametrize(("entry", "example"), [(TOY, Example()), (IN_PLAN, Example(grounded=True))])
def test_a_method_that_is_registered_gets_the_suite(added, entry, example, tmp_path):
    name = added(entry, example)
    assert not failures(name, tmp_path)
    assert not able(name).obstacles


class Forgetful(toy_method.Sliding):
    """Its state lacks the velocity of the last step."""

    def restore(self, state):
        super().restore({**state, "loaded": np.zeros(self.dim)})


class Unbooked(toy_method.Sliding):
    """Loads act and are not booked."""

    def step(self, dt):
        before = self._loaded.copy()
        super().step(dt)
        self._loaded[:] = before


class Drifting(toy_method.Sliding):
    """Its points are pulled to the left."""

    def _write(self, v, way):
        super()._write(v, way - 1e-6)


class Forgotten(toy_method.Sliding):
    """Removed points are not heard of again."""

    def remove(self, gone):
        count = self.particles.removed["count"]
        super().remove(gone)
        self.particles.removed["count"] = count


@pytest.mark.parametrize(("wrong", "found"), [
    (Forgetful, {"a_resumed_run_is_the_same_to_the_bit"}),
    (Unbooked, {"loads_and_pushes_are_booked", "mass_and_momentum_are_audited"}),
    (Drifting, {"rest_stays_at_rest", "translation_is_rigid"}),
    (Forgotten, {"what_is_taken_out_is_booked", "mass_and_momentum_are_audited"})])
def test_the_suite_finds_what_is_wrong(added, wrong, found, tmp_path):
    name = added(replace(TOY, name="wrong", builder=wrong))
    assert found <= failures(name, tmp_path)


def test_the_suite_finds_what_is_declared_and_not_done(added, tmp_path):
    name = added(replace(TOY, name="boastful", capabilities=replace(TOY.capabilities, obstacles=True)))
    assert "obstacles" in failures(name, tmp_path)
