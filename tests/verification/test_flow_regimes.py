"""Four kinds of snow on one slope make four kinds of avalanche (S5).

The library scenes flow_*, at dx = 0.2 m. Published order of the fronts, on a slope whose measures are not:
I > II > IV > III. A slab that slides is as fast as a block, sqrt(2 g s (sin - mu cos)). It cracks at the arc; the plug
does not; warm shear snow breaks into granules. tests/benchmarks/flow_regimes.py draws fronts, profiles, pieces and
plastic share.
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


def test_order_of_the_fronts(runs):
    """On the slope, and until the slab comes apart behind the arc."""
    for time in (6.0, 8.0, 10.0):
        found = fronts(runs, time)
        assert found == sorted(found, reverse=True)


def test_order_of_the_fronts_at_rest(runs):
    cold, warm, plug, slab = fronts(runs, 14.0)
    assert cold > warm + 20.0 and warm > max(plug, slab) + 2.0


@pytest.mark.xfail(strict=True, reason="the slab opens gaps at the arc, and its front rests 1.4 m beyond the plug's")
def test_the_plug_comes_further_than_the_slab(runs):
    """As published, on another slope; why not here: below. Nor is it so on others that fit what is said of that one (a
    plane, an arc, a flat, 20 s, 140 m), at dx = 0.25 m, where the slab breaks into more pieces: with an arc of 10 m its
    front rests 4.6 m ahead of the plug's, with a release of 4 m 6.5 m. Their middles stay within 0.6 m of each other.
    """
    _, _, plug, slab = fronts(runs, 14.0)
    assert plug > slab


def test_slab_and_plug_come_equally_far(runs):
    """Both slide on one bed, so the energy line takes both as far: their mass comes to rest within 0.1 m of 113.3 m.

    Of their fronts at rest the longer deposit decides, which was published to be the plug's. Here it is the slab's: it
    opens gaps, and gets 24.0 m long at dx = 0.2 m and 22.1 m at 0.1 m, while the plug stays 20.3 m. So its front is 1.4
    and 0.8 m further, of 105 m: half of what it is longer.
    """
    middle, length = {}, {}
    for regime in (III, IV):
        run = runs[regime]
        x = run.frame(int(np.abs(run.times - 14.0).argmin()), []).points[:, 0]
        middle[regime], length[regime] = x.mean(), np.ptp(np.quantile(x, [0.005, 0.995]))
    assert middle[III] == pytest.approx(middle[IV], abs=0.3)
    assert length[IV] == pytest.approx(20.0, abs=1.0) and length[III] > length[IV]
    _, _, plug, slab = fronts(runs, 14.0)
    assert slab - plug == pytest.approx(0.5 * (length[III] - length[IV]), abs=0.6)


def test_the_slab_is_as_fast_as_a_block(runs):
    assert block_excess(runs[III]) == pytest.approx(1.0, abs=0.1)
    assert block_excess(runs[I]) > 1.3  # what shears instead of sliding is faster


def test_cracks_and_granules(runs):
    large = {regime: pieces(run, 14.0) for regime, run in runs.items()}
    assert len(large[IV]) == 1 and cracks(runs[IV], 14.0) == 0.0
    assert large[III][0] < 0.5 * 40.0 and cracks(runs[III], 14.0) > 0.1
    # The mean, not the largest one: that of II has come out at 8.2 and at 10.0 m2 beside 8.1 of III
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


@pytest.mark.xfail(strict=True, reason="32, 4, 3 and 65 % of I, II, III and IV in a step; 77, 26, 10, 34 % published")
def test_plastic_shares_as_published(runs):
    """At 10 s, of real terrain in three dimensions; what counts as plastic is not said. Ways to count it, in per cent
    (changes of p0 are those of the plastic volume):

        .                                               I    II   III  IV
        published                                       77   26   10   34
        yields in a step, at 10 s (in the arc)          32    4    3   65
        yields in a step, 2 to 6 s (on the slope)       70    2    2   18
        p0 changed by 0.1 % since the start, at 5 s    100   52   44   68
        plane of 260 m, dx = 0.5 m, release of 1 m: yields in a step at 10 s
                                                        32    0    0   18
            p0 changed by 0.1 %, 10 % since the start  100    6    0   95
                                                       100    3    0   38
        the same with a release of 2 m                  40    4    0   17
                                                       100   56   12   75
                                                       100   46    4   32
            p0 changed by 1 % in half a second          50    9    3   44

    None meets all four. On the paper's grid and depth a slab on a plane yields nowhere: its 10 % are of its terrain.
    """
    for regime, run in runs.items():
        share = np.interp(10.0, run.history["time"], run.history["plastic_fraction"])
        assert share == pytest.approx(PUBLISHED[regime], rel=0.1)


def test_order_of_the_plastic_shares(runs):
    """Published at 10 s, on another slope: 77, 34, 26 and 10 % of I, IV, II and III. What counts as plastic is not
    said; here it is what yields in a step, and what has yielded since the start.

    In both the order is the published one while all slide on the slope. In a step 70, 18, 2 and 2 %; since the start
    100, 68, 52 and 44 %: what was published lies between. At 10 s, where all cross the arc, which bends them: 32, 65, 4
    and 3 % in a step. The cold snow, which shears all the way, is within a tenth of its 77 %.
    """
    order = sorted(PUBLISHED, key=PUBLISHED.get)
    in_a_step, since = {}, {}
    for regime, run in runs.items():
        time = run.history["time"]
        in_a_step[regime] = run.history["plastic_fraction"][(time > 2.0) & (time < 6.0)].mean()
        first, later = (run.frame(int(np.abs(run.times - t).argmin()), ["p0"]).fields["p0"] for t in (0.0, 5.0))
        since[regime] = (np.abs(later / first - 1.0) > 1e-3).mean()
    assert sorted(in_a_step, key=in_a_step.get) == order and sorted(since, key=since.get) == order
    for regime in SCENES:
        assert in_a_step[regime] < PUBLISHED[regime] < since[regime]
    assert in_a_step[I] == pytest.approx(PUBLISHED[I], rel=0.15)
