"""Where a slab tears that is released in three dimensions: crown, flanks, stauchwall, of which the scene knows nothing.

The library's `crown_and_flanks`: a weak layer of 13 m by 12 m within firm snow, below a slab that reaches beyond it on
all sides. What tears is told where it lay before the release. It has torn where its two sides have come apart by a
tenth of a metre within three, twenty times what it can be strained before.
"""

import numpy as np
import pytest

from tests.support.story import Story, at_rest

pytestmark = pytest.mark.slow

DOWN, ACROSS = (5.0, 18.0), (4.0, 16.0)
"""The weak layer in plan [m]."""
NEAR = 1.5
"""How far from the end of the weak layer a fracture may be [m]."""
APART = 0.1  # m
CELL = 0.5  # m
TORN = 0.9
"""Share of the strength whose loss is a crack."""
END = 1.6  # s


@pytest.fixture(scope="module")
def story():
    """The `Story`, what was to be seen at some times [s], and the largest speed before the cut [m/s]."""
    told = Story("crown_and_flanks")
    seen = {0.3: told.at(0.3)}
    before = told.fastest
    return told, seen | {time: told.at(time) for time in (0.7, 1.0, END)}, before


def on_a_map(told, values):
    """Mean of what the slab's particles have (n,) in columns of CELL by CELL, by their place at the start."""
    ends = [np.arange(low, high + 0.5 * CELL, CELL) for low, high in ((2.0, 21.5), (1.0, 19.0))]
    x, y = told.home[told.slab, :2].T
    total, count = (np.histogram2d(x, y, ends, weights=w)[0] for w in (values[told.slab].astype(float), None))
    return total / np.maximum(count, 1), *(0.5 * (edges[1:] + edges[:-1]) for edges in ends)


def bands(told, values):
    """Columns (across, along) a fracture, by its name: within NEAR of the end of the weak layer, but for corners."""
    grid, x, y = on_a_map(told, values)
    along, across = ((at > low + NEAR) & (at < high - NEAR) for at, (low, high) in ((x, DOWN), (y, ACROSS)))
    upper, lower = (grid[np.abs(x - end) < NEAR][:, across] for end in DOWN)
    right, left = (grid[along][:, np.abs(y - end) < NEAR].T for end in ACROSS)
    return {"crown": upper, "stauchwall": lower, "right flank": right, "left flank": left}


def come_apart(told, now):
    """Share of each fracture's length along which its sides have moved APART."""
    moved = bands(told, np.linalg.norm(now["moved"], axis=1))
    return {name: (np.ptp(band, axis=0) > APART).mean() for name, band in moved.items()}


def torn(told, now):
    """Share of each fracture's length along which half of the slab's thickness has no strength."""
    return {name: (band.max(axis=0) >= 0.5).mean() for name, band in bands(told, now["damage"] > TORN).items()}


def parts(told):
    """Slab over the weak layer, and well above and beside it (n,)."""
    x, y = told.home[:, 0], told.home[:, 1]
    inside = (x > DOWN[0] + NEAR) & (x < DOWN[1] - NEAR) & (y > ACROSS[0] + NEAR) & (y < ACROSS[1] - NEAR)
    beyond = (x < DOWN[0] - NEAR) | (y < ACROSS[0] - NEAR) | (y > ACROSS[1] + NEAR)
    return told.slab & inside, told.slab & beyond


def test_at_rest_before_the_cut(story):
    told, seen, before = story
    assert at_rest(before, 0.75)
    assert set(come_apart(told, seen[0.3]).values()) == {0.0} and told.crack(seen[0.3])[2] == 0.0


def test_the_crack_is_through_before_the_slab_has_moved(story):
    told, seen, _ = story
    assert told.crack(seen[0.7])[2] > 0.85
    assert np.linalg.norm(seen[0.7]["moved"][told.slab], axis=1).max() < 0.2


def test_the_slab_tears_at_the_crown_first(story):
    """Above in tension, then at the sides, and at last it is crushed below."""
    told, seen, _ = story
    found = torn(told, seen[1.0])
    assert found["crown"] > 0.9 and found["stauchwall"] < 0.2
    assert found["stauchwall"] < min(found["right flank"], found["left flank"]) < found["crown"]


def test_it_tears_all_round(story):
    told, seen, _ = story
    found = come_apart(told, seen[END])
    print(found)
    assert set(found) == {"crown", "stauchwall", "right flank", "left flank"}
    assert min(found.values()) > 0.9


def test_what_lies_beyond_stays(story):
    told, seen, _ = story
    inside, beyond = parts(told)
    now, speed = seen[END], np.linalg.norm(seen[END]["velocity"], axis=1)
    assert speed[inside].mean() > 0.4 and speed[beyond].mean() < 0.05
    assert np.linalg.norm(now["moved"][beyond], axis=1).max() < APART
    assert (now["damage"][beyond] > TORN).mean() < 0.02
    assert told.audit_is_clean()
