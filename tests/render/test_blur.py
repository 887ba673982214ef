"""The blur of pictures beside SciPy's, and by the properties of a Gaussian."""

import numpy as np
import pytest
from scipy import ndimage

from snowmpm.render.blur import FINE, blur

SHAPE = (151, 203)  # no multiple of any block


def scene():
    """Noise of a few pixels, an area with sharp edges, and a step near the border; within 0 and 4."""
    rng = np.random.default_rng(3)
    values = ndimage.gaussian_filter(rng.random(SHAPE), 1.5)
    values[40:90, 30:80] += 1.0
    values[:, 190:] += 2.0
    return values.astype(np.float32)


@pytest.mark.parametrize("width", [0.6, 2.0, 1.99 * FINE])
def test_a_narrow_blur_is_that_of_scipy(width):
    assert (blur(scene(), width) == ndimage.gaussian_filter(scene(), width)).all()


@pytest.mark.parametrize(("width", "truncate"), [(2.0 * FINE, 4.0), (9.5, 4.0), (21.0, 2.5), (60.0, 2.5)])
def test_a_wide_blur_differs_from_scipy_by_less_than_a_grey_level(width, truncate):
    """Of 256 over the range of the picture, at the borders too; a blur 5 % wider is further off at its edges."""
    wanted = ndimage.gaussian_filter(scene(), width, truncate=truncate)
    found = blur(scene(), width, truncate)
    assert found.dtype == np.float32 and found.shape == SHAPE
    level = float(np.ptp(scene())) / 256.0
    assert np.abs(found - wanted).max() < level
    wider = ndimage.gaussian_filter(scene(), 1.05 * width, truncate=truncate)
    assert np.abs(wider - wanted).max() > level


@pytest.mark.parametrize("width", [7.0, 12.3, 30.0])
def test_a_point_spreads_with_the_variance_asked_for(width):
    """One pixel of light: its sum is kept, its middle to half a block, its variance is width squared."""
    picture = np.zeros((301, 301), np.float32)
    picture[150, 147] = 1.0
    spread = blur(picture, width).astype(float)
    assert spread.sum() == pytest.approx(1.0, abs=2e-3)
    for axis, middle in ((0, 150.0), (1, 147.0)):
        share, at = spread.sum(axis=1 - axis), np.arange(301.0)
        mean = (share * at).sum() / share.sum()
        assert mean == pytest.approx(middle, abs=0.5 * width / FINE)
        assert (share * (at - mean) ** 2).sum() / share.sum() == pytest.approx(width**2, rel=0.02)


def test_an_even_picture_stays_even():
    assert np.abs(blur(np.full(SHAPE, 0.7, np.float32), 25.0) - 0.7).max() < 1e-6
