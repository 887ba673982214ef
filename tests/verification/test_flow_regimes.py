"""Four kinds of snow on one slope make four kinds of avalanche (S5).

The library scenes flow_*, at dx = 0.2 m. Published order of the fronts, on the slope and at rest: I > II > IV > III. A
slab that slides is as fast as a block, sqrt(2 g s (sin - mu cos)). It cracks at the arc; the plug does not; warm shear
snow breaks into granules. tests/benchmarks/flow_regimes.py draws fronts, profiles, pieces and plastic share.
"""

import numpy as np
import pytest

import snowmpm
from tests.benchmarks.flow_regimes import PUBLISHED, SCENES, block_excess, cracks, depth_profile, front, pieces

pytestmark = pytest.mark.slow
I, II, III, IV = SCENES


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("regimes"), {}
    for regime, name in SCENES.items():
        scene = snowmpm.load_scene(name, {"solver.dx": 0.2, "solver.cfl": 0.7, "end_time": 14.0,
                                          "output.interval": 0.25})
        made[regime] = snowmpm.run(scene, folder / name)
    return made


def fronts(runs, time):
    return [float(np.interp(time, runs[regime].history["time"], front(runs[regime]))) for regime in (I, II, IV, III)]


def test_order_of_the_fronts_on_the_slope(runs):
    for time in (6.0, 8.0):
        found = fronts(runs, time)
        assert found == sorted(found, reverse=True)


def test_order_of_the_fronts_at_rest(runs):
    cold, warm, plug, slab = fronts(runs, 14.0)
    assert cold > warm + 20.0 and warm > max(plug, slab) + 2.0


@pytest.mark.xfail(strict=True, reason="the slab opens gaps at the arc, and its front comes to rest a metre beyond the"
                                       " plug's: 1.4 m at dx = 0.2 m, 0.8 m at 0.1 m, of 105 m")
def test_the_plug_comes_further_than_the_slab(runs):
    _, _, plug, slab = fronts(runs, 14.0)
    assert plug > slab


def test_the_slab_is_as_fast_as_a_block(runs):
    assert block_excess(runs[III]) == pytest.approx(1.0, abs=0.1)
    assert block_excess(runs[I]) > 1.3  # what shears instead of sliding is faster


def test_cracks_and_granules(runs):
    large = {regime: pieces(run, 14.0) for regime, run in runs.items()}
    assert len(large[IV]) == 1 and cracks(runs[IV], 14.0) == 0.0
    assert large[III][0] < 0.5 * 40.0 and cracks(runs[III], 14.0) > 0.1
    assert large[II][0] < large[III][0]
    sizes = {regime: (area @ np.sqrt(area)) / area.sum() for regime, area in large.items()}
    assert sizes[I] < sizes[II] < sizes[III] < sizes[IV]


def test_what_shears_and_what_slides(runs):
    """Velocity at the bed over that at the surface, with the front at three quarters of the slope."""
    slip = {}
    for regime, run in runs.items():
        time = float(np.interp(61.0, np.maximum.accumulate(front(run)), run.history["time"]))
        speed = depth_profile(run, time)[1]
        slip[regime] = speed[0] / speed[-1]
    assert slip[I] < 0.4
    assert all(slip[regime] > 0.95 for regime in (II, III, IV))


@pytest.mark.xfail(strict=True, reason="32, 6, 3 and 59 % of I, II, III and IV; 77, 26, 10 and 34 % published")
def test_plastic_shares_as_published(runs):
    """At 10 s; the published slope is not known, nor what counts as plastic."""
    for regime, run in runs.items():
        share = np.interp(10.0, run.history["time"], run.history["plastic_fraction"])
        assert share == pytest.approx(PUBLISHED[regime], rel=0.1)


def test_order_of_the_plastic_shares(runs):
    """Published at 10 s on another slope: 77, 34, 26 and 10 % of I, IV, II and III. The order holds on the slope; the
    shares are smaller than those, for all but the plug."""
    share = {}
    for regime, run in runs.items():
        on_slope = (run.history["time"] > 2.0) & (run.history["time"] < 6.0)
        share[regime] = run.history["plastic_fraction"][on_slope].mean()
    assert sorted(share, key=share.get) == sorted(PUBLISHED, key=PUBLISHED.get)
