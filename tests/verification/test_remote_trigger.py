"""G14: a load on the flat releases a slope in 3-D, the snowman of Gaume et al. (2018), by the scene of the guide
(`docs/remote_trigger.toml`), whose weak layer is an interface. Three minutes."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.story import Story, at_rest

pytestmark = pytest.mark.slow

PAGE = str(Path(__file__).parents[2] / "docs" / "remote_trigger.toml")
LAYER_X, LAYER_Y = (12.0, 58.0), (4.0, 16.0)
FOOT = 42.0 + 10.0 * np.tan(np.radians(19.0))
"""Where the ground begins to rise [m]: the end of the fillet."""
LOAD, CELL = 53.0, 0.5


def test_a_load_on_the_flat_releases_the_slope():
    """The crack begins on the flat, runs to the upper end of the weak layer, 41 m from the load, before the slab has
    moved by a hand's breadth, and the slab tears where the weak layer ends, above and at both sides."""
    story = Story(PAGE)
    x, y = story.home[:, :2].T
    story.at(0.2)
    assert at_rest(story.fastest, 1.0)
    early = story.at(0.3)
    assert FOOT < story.crack(early)[0] < LOAD
    on_the_way = story.crack(story.at(0.7))[0]
    later = story.crack(story.at(0.8))[0]
    assert 40.0 < (on_the_way - later) / 0.1 / np.cos(np.radians(38.0)) < 130.0
    now = story.at(1.2)
    assert story.crack(now)[0] < LAYER_X[0] + CELL
    assert story.crack(now)[2] > 0.99
    assert np.linalg.norm(now["moved"][story.slab], axis=1).max() < 0.1
    end = story.at(3.2)
    speed, moved = (np.linalg.norm(end[name], axis=1) for name in ("velocity", "moved"))
    released = story.slab & (moved > 0.5)
    assert x[released].min() == pytest.approx(LAYER_X[0], abs=2.0 * CELL)
    assert [y[released].min(), y[released].max()] == pytest.approx(LAYER_Y, abs=2.0 * CELL)
    assert speed[story.slab & (x > 14.0) & (x < 34.0) & (y > 5.0) & (y < 15.0)].mean() > 0.5
    # What lies on the flat, above the crown and beside the flanks stays
    for stays in (x > 47.0, x < LAYER_X[0] - 2.0 * CELL, (y < LAYER_Y[0] - 2.0 * CELL), (y > LAYER_Y[1] + 2.0 * CELL)):
        assert speed[story.slab & stays].mean() < 0.1
    # Torn at crown and flanks
    near_crown = np.abs(x - LAYER_X[0]) < 2.0 * CELL
    near_flanks = (np.minimum(np.abs(y - LAYER_Y[0]), np.abs(y - LAYER_Y[1])) < 2.0 * CELL) & (x > 14.0) & (x < 34.0)
    for border in (near_crown & (y > 5.0) & (y < 15.0), near_flanks):
        assert (end["damage"][story.slab & border] > 0.9).mean() > 0.05
    assert story.audit_is_clean()


def test_a_tenth_of_the_load_does_nothing():
    story = Story(PAGE, **{"events.0.force": [0.0, 0.0, -2e3]})
    story.at(0.4)  # what it sets swinging has passed
    end = story.at(0.5)
    assert story.crack(end)[2] == 0.0
    assert at_rest(story.fastest, 1.0)


def test_a_light_slab_keeps_the_crack_where_the_load_is():
    """Below Maxwell's load of 1.4 kPa on the flat (here 1.2) the crack does not reach the slope."""
    story = Story(PAGE, **{"materials.slab.density": 125.0})
    lower, _, share = story.crack(story.at(1.0))
    assert not lower < FOOT
    assert share < 0.2
