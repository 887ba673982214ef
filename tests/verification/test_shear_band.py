"""BM-7, dry: localisation on a whole specimen and on a quarter of it, a biaxial test of sand that softens, by the two
scenes of the guide, `docs/shear_band.toml` and `docs/shear_band_quarter.toml` (Sun, ALERT Doctoral School 2020, section
4.5, finds for a wet cylinder that the whole one softens more strongly).

In one band through the whole specimen the blocks above and below slide by u / sin(theta) for an approach u of the
plates; in a cross of two bands, all that planes of symmetry allow, each arm slides by half of that. So the quarter
needs twice the way to lose the same strength.
"""

import numpy as np
import pytest

from tests.support.shear_band import HEIGHT, WIDTH, Specimen, scene_of


def test_both_scenes_are_one_specimen():
    whole, quarter = scene_of("shear_band"), scene_of("shear_band_quarter")
    for table in ("solver", "materials", "forces", "initial", "damping", "end_time", "gravity"):
        assert getattr(whole, table) == getattr(quarter, table), table
    assert whole.obstacles[1] == quarter.obstacles[0]
    areas = [sum(np.prod(np.subtract(body.shape.max, body.shape.min)) for body in scene.bodies)
             for scene in (whole, quarter)]
    assert areas == pytest.approx([WIDTH * HEIGHT, 0.25 * WIDTH * HEIGHT])


@pytest.fixture(scope="module")
def tests():
    return Specimen("shear_band", WIDTH), Specimen("shear_band_quarter", 0.5 * WIDTH)


def band_of(test):
    """Correlation of x and z, weighted by the plastic shear: 1 or -1 for a straight band, 0 for a symmetric cross."""
    weight = test.shear / test.shear.sum()
    centred = test.x - weight @ test.x
    across, with_both, along = (weight @ (centred[:, i] * centred[:, j]) for i, j in ((0, 0), (0, 1), (1, 1)))
    return with_both / np.sqrt(across * along)


@pytest.mark.slow
def test_peak_is_that_of_the_whole_specimen(tests):
    whole, quarter = tests
    assert quarter.peak == pytest.approx(whole.peak, rel=0.02)


@pytest.mark.slow
def test_whole_specimen_fails_in_one_band(tests):
    """Plastic shear is correlated with one diagonal, most of the specimen takes no part, and the upper block has slid
    past the lower one: what planes of symmetry forbid."""
    whole, _ = tests
    assert abs(band_of(whole)) > 0.7
    assert (whole.shear < 0.1 * whole.shear.max()).mean() > 0.6
    top = whole.x[whole.x[:, 1] > 0.08, 0].mean()
    bottom = whole.x[whole.x[:, 1] < -0.08, 0].mean()
    way = 2.0 * 0.01 * (0.3 - 0.02)  # of the plates
    assert abs(top - bottom) > 0.4 * way


@pytest.mark.slow
def test_quarter_shears_in_a_cross_and_softens_half_as_fast(tests):
    whole, quarter = tests
    assert quarter.shear.max() < 0.75 * whole.shear.max()
    # The band of the quarter begins at its weak corner and runs to its free side
    arm = quarter.shear > 0.5 * quarter.shear.max()
    assert quarter.x[arm, 0].max() > 0.04 and quarter.x[arm].min() < 0.005
    ratio = quarter.softened(0.4) / whole.softened(0.4)
    print(f"way to lose 40 % of the peak over the residual: {ratio:.2f} times as long")
    assert 1.5 < ratio < 2.5
    assert quarter.deviator[-10:].mean() - whole.deviator[-10:].mean() > 0.1 * whole.peak


@pytest.mark.slow
def test_balances(tests):
    """Momentum where the plates' impulses do not cancel: that of the quarter."""
    for test in tests:
        assert test.audit["unconverged"] == 0
        print(f"momentum {test.audit['momentum_residual']:.1e}, peak {test.peak:.0f} Pa")
    assert tests[1].audit["momentum_residual"] < 1e-4
