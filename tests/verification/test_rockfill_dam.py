"""Water seeps through a dam of rockfill by SPH (P9): what comes in goes out, and the free surface stands."""

import numpy as np
import pytest

from snowmpm.study.problems.rockfill_dam import WIDTH, Q, depth_at, dupuit, feed, rockfill_dam

GAUGES = np.array([0.8, 1.3, 1.8, 2.3])
DT = 5e-3


@pytest.fixture(scope="module")
def flowed():
    """After 20 s, and the following 20 s: depths at the gauges once a second (20, 4), and volume that left in them."""
    seepage, rng, depths = rockfill_dam(), np.random.default_rng(1), []
    while seepage.time < 20.0:
        feed(seepage, rng, DT)
        seepage.step(DT)
    before = seepage.left
    while seepage.time < 40.0:
        feed(seepage, rng, DT)
        seepage.step(DT)
        if seepage.time >= 20.0 + len(depths):
            depths.append([depth_at(seepage, x) for x in GAUGES])
    return seepage, np.array(depths), seepage.left - before


@pytest.mark.slow
def test_discharge(flowed):
    """24.46 L/s, within 5 %."""
    _, _, left = flowed
    assert left / 20.0 * WIDTH == pytest.approx(24.46e-3, rel=0.05)
    assert pytest.approx(24.46e-3) == Q * WIDTH


@pytest.mark.slow
def test_free_surface_is_steady(flowed):
    """Its means over the first and the second half of the time differ by less than 5 %, and it lies where theory has
    it, to a spacing of the particles."""
    seepage, depths, _ = flowed
    first, second = depths[: len(depths) // 2].mean(axis=0), depths[len(depths) // 2 :].mean(axis=0)
    np.testing.assert_allclose(second, first, rtol=0.05)
    np.testing.assert_allclose(second, dupuit(GAUGES), atol=seepage.spacing)
    assert (np.diff(second) < 0.0).all()
