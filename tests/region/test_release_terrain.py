"""Slope, curvature and ruggedness on ground where they are known."""

import numpy as np
import pytest

from snowmpm.region.release_terrain import HALO, RULES, can_release, measures

CELL = 5.0
INNER = np.s_[HALO:-HALO, HALO:-HALO]


def places(n=60):
    x = CELL * (np.arange(n) - n / 2)
    return np.meshgrid(x, -x)  # rows from the north


@pytest.mark.parametrize(("angle", "aspect"), [(28.0, 0.0), (35.0, 90.0), (45.0, 213.0)])
def test_a_plane_has_its_slope_and_no_curvature(angle, aspect):
    x, y = places()
    down = np.array([np.sin(np.radians(aspect)), np.cos(np.radians(aspect))])
    found = measures(-np.tan(np.radians(angle)) * (down[0] * x + down[1] * y), CELL)
    assert np.allclose(found.slope[INNER], angle, atol=1e-9)
    assert np.allclose(found.curvature[INNER], 0.0, atol=1e-9)
    assert np.allclose(found.ruggedness[INNER], 0.0, atol=1e-12)
    assert np.allclose(found.down[0][INNER], down[0]) and np.allclose(found.down[1][INNER], down[1])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cone_has_the_curvature_of_its_contours(sign):
    """Contours of a cone are circles: their curvature times the slope is 1/r; positive on a hill."""
    x, y = places(120)
    r = np.hypot(x - 400.0, y)
    found = measures(1000.0 - sign * 0.6 * r, CELL)
    expected = 100.0 * sign * 0.6 * 2.0 / 2.0 / r
    far = (r > 150.0) & np.isfinite(found.curvature)
    assert np.abs(found.curvature[far] / expected[far] - 1.0).max() < 0.02


def test_holes_are_unknown_and_so_is_what_needs_them():
    x, _ = places()
    z = -0.6 * x
    z[30, 30] = np.nan
    found = measures(z, CELL)
    assert np.isnan(found.slope[28:33, 28:33]).all()
    assert np.isfinite(found.slope[30, 36])
    mask = can_release(z, found, RULES["rare"])
    assert not mask[28:33, 28:33].any() and mask[30, 40]


def test_bounds_hold():
    steep = -np.tan(np.radians(np.linspace(20.0, 65.0, 200))) * CELL
    z = np.cumsum(np.broadcast_to(steep, (200, 200)), axis=1)
    found = measures(z, CELL)
    for name, least in (("frequent", 30.0), ("rare", 28.0)):
        mask = can_release(z, found, RULES[name])[INNER]
        slopes = found.slope[INNER][mask]
        assert slopes.min() > least - 0.6 and slopes.max() < 55.6  # half a cell by the smoothing of the mask
    assert not can_release(z, found, RULES["rare"], np.ones_like(z, bool)).any()
    rough = z + 12.0 * ((np.indices(z.shape) // 5).sum(axis=0) % 2)
    assert can_release(rough, measures(rough, CELL), RULES["rare"])[INNER].sum() < 0.25 * mask.sum()
