"""When the bonds of a saw test are expected to break, and what that does to the number of steps."""

import pytest

from snowmpm import load_scene
from snowmpm.advice.breaking import breaking_between
from snowmpm.advice.facts import SceneFacts
from snowmpm.setup.build import build


def facts(**settings):
    scene = load_scene("pst_2d", settings)
    model = build(scene)
    return SceneFacts(scene, model, model.solver())


def test_it_begins_beside_the_saw_and_ends_with_the_crack():
    """A run of pst_2d counts breaking bonds from 0.09 to 0.32 s."""
    begin, end = breaking_between(load_scene("pst_2d"))
    assert begin == pytest.approx(0.09, rel=0.2) and end == pytest.approx(0.32, rel=0.3)


def test_what_moves_it():
    begin, end = breaking_between(load_scene("pst_2d"))
    later = breaking_between(load_scene("pst_2d", {"saw_test.saw_start": 0.12}))
    assert later == pytest.approx((begin + 0.1, end + 0.1))
    longer = breaking_between(load_scene("pst_2d", {"saw_test.length": 12.0}))
    assert longer[0] == begin and longer[1] - begin > 1.9 * (end - begin)
    notched = breaking_between(load_scene("pst_2d", {"saw_test.notch": 0.5}))
    assert notched[0] == 0.02  # longer than the critical cut: the first touch sets it off
    assert breaking_between(load_scene("pst_2d", {"materials.weak_layer.p0": 2.7e4}))[0] > begin


@pytest.mark.parametrize(("name", "settings"), [("slab_release_resolved", {}), ("pst_2d", {"gravity": 0.0})])
def test_where_nothing_breaks(name, settings):
    assert breaking_between(load_scene(name, settings)) == (0.0, 0.0)


def test_steps_are_short_meanwhile():
    found = facts()
    begin, end = breaking_between(found.scene)
    long, short = found.solver.expected_dt()[0], found.solver.expected_dt(breaking=True)[0]
    assert short == pytest.approx(long * 0.4 / found.solver.cfl)
    assert found.steps_until(begin) == pytest.approx(begin / long)
    assert found.steps_until(end) - found.steps_until(begin) == pytest.approx((end - begin) / short)
    assert found.steps == pytest.approx((end - begin) / short + (0.45 - end + begin) / long)


@pytest.mark.parametrize("settings", [{"solver.cfl": 0.4}, {"solver.dt": 1e-5}], ids=str)
def test_a_step_that_is_given_stays(settings):
    found = facts(**settings)
    assert found.steps == pytest.approx(0.45 / (found.scene.solver.dt or found.solver.expected_dt()[0]))
