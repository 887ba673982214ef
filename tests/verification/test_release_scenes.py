"""How slabs are released, told in numbers: the library's whumpf, remote trigger, skier and new snow. Minutes each.

A crack is weak layer that has lost all its bonds (damage 1); its front the outermost of it, without the last hundredth.
"""

import numpy as np
import pytest

from tests.support.story import Story, at_rest

pytestmark = pytest.mark.slow

def test_whumpf_collapses_and_slides_nowhere():
    """On the flat the crack runs by itself both ways at 25-45 m/s (Heierli's estimate and 0.6 c_s, as for the saw test)
    to the ends of the slab, which sinks by the collapse and moves sideways by less than a twentieth of that."""
    story = Story("whumpf_2d")
    story.at(0.1)
    assert at_rest(story.fastest, 0.5)
    early, late = story.crack(story.at(0.2)), story.crack(story.at(0.3))
    for end in (0, 1):
        assert 25.0 < abs(late[end] - early[end]) / 0.1 < 45.0
    end = story.at(0.8)
    lower, upper, _ = story.crack(end)
    assert lower < 2.5 and upper > 21.5  # the slab lies from 2 to 22 m, the load was at 12 m
    sunk = -end["moved"][story.slab, 1].mean()
    assert 0.002 < sunk < 0.01  # of 0.2 m of weak layer
    assert abs(end["moved"][story.slab, 0].mean()) < 0.05 * sunk
    assert np.linalg.norm(end["velocity"][story.slab], axis=1).mean() < 0.02
    assert story.audit_is_clean()


def test_a_light_slab_does_not_whumpf():
    """Below the Maxwell load of 0.91 kPa (here 0.54) the same weight leaves a crack that does not run."""
    story = Story("whumpf_2d", **{"materials.slab.density": 100.0})
    lower, upper, _ = story.crack(story.at(0.5))
    assert not upper - lower > 6.0  # the load covers 0.6 m; the slab is 20 m long


def test_a_skier_releases_the_slab_and_a_fifth_of_one_does_not():
    story = Story("skier_trigger")
    story.at(0.2)
    assert at_rest(story.fastest, 0.3)
    end = story.at(1.1)
    *_, share = story.crack(end)
    assert share > 0.95
    crown = story.crown(end)
    assert 4.5 < crown < 5.6  # where the weak layer ends, 5.0 m
    below = story.slab & (story.home[:, 0] > crown) & (story.home[:, 0] < 13.0)
    above = story.slab & (story.home[:, 0] < crown - 0.5)
    speed = np.linalg.norm(end["velocity"], axis=1)
    assert speed[below].mean() > 0.4 and speed[above].mean() < 0.05
    torn = story.slab & (np.abs(story.home[:, 0] - crown) < 0.5)
    crushed = story.slab & (np.abs(story.home[:, 0] - 14.5) < 1.0)  # above the firm part that begins at 15 m
    for band in (torn, crushed):
        assert (end["damage"][band] > 0.9).mean() > 0.05
    assert story.audit_is_clean()

    fifth = Story("skier_trigger", **{"events.0.force": [0.0, -157.0]})
    end = fifth.at(0.8)
    assert fifth.crack(end)[2] == 0.0
    assert at_rest(fifth.fastest, 0.3)


def test_new_snow_releases_the_slab_when_there_is_enough_of_it():
    story = Story("natural_release")
    end = story.at(0.5)  # a fifth of the new snow
    assert story.crack(end)[2] == 0.0 and at_rest(story.fastest, 0.3)
    end = story.at(1.2)  # two thirds of it
    assert story.crack(end)[2] > 0.95
    assert 4.5 < story.crown(end) < 5.6
    moving = story.slab & (story.home[:, 0] > 6.0) & (story.home[:, 0] < 13.0)
    assert np.linalg.norm(end["velocity"][moving], axis=1).mean() > 0.3
    assert story.audit_is_clean()


def test_a_load_on_the_flat_releases_the_slope():
    """The crack starts on the flat, 2.4 m away from where the ground begins to rise (31.6 m), runs up the slope ahead
    of all motion to the end of the weak layer, and the slab up there tears off and slides."""
    story = Story("remote_trigger_2d")
    story.at(0.2)
    assert at_rest(story.fastest, 0.5)
    early = story.crack(story.at(0.3))
    assert early[0] > 27.0  # not yet on the slope proper, which ends at 25.2 m
    now = story.at(0.75)
    assert story.crack(now)[0] < 10.0  # up the slope, 24 m away from the load
    assert np.linalg.norm(now["moved"][story.slab], axis=1).max() < 0.1  # before the slab has moved by a hand's breadth
    end = story.at(2.0)
    assert story.crack(end)[0] < 5.5  # the weak layer ends at 5 m
    crown = story.crown(end)
    assert 4.5 < crown < 5.6
    speed = np.linalg.norm(end["velocity"], axis=1)
    assert speed[story.slab & (story.home[:, 0] > 6.0) & (story.home[:, 0] < 17.0)].mean() > 0.5
    # Crushed at the foot of the slope: what lies on the flat stays
    assert speed[story.slab & (story.home[:, 0] > 26.0)].mean() < 0.1
    assert speed[story.slab & (story.home[:, 0] < crown - 0.5)].mean() < 0.05
    assert story.audit_is_clean()
