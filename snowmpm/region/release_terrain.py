"""Where slabs can release: slope, curvature and ruggedness of the ground, and its forest.

On heights H, smoothed by a kernel of 5 x 5 cells (weights 3, 1.5, 0.625 of the centre and its rings):

    slope        atan |grad H|, differences of Horn (1981), doi:10.1109/PROC.1981.11918
    curvature    100 · (-2)(D Hy² + E Hx² - F Hx Hy) / (Hx² + Hy²)  [1/100 m], positive on ridges; the plan curvature of
                 Zevenbergen and Thorne (1987), doi:10.1002/esp.3290120107, with D = Hxx / 2, E = Hyy / 2, F = Hxy
    ruggedness   1 - |mean of the unit normals over 7 x 7 cells|; Sappington et al. (2007), doi:10.2193/2005-723

A cell can release where its slope, curvature and ruggedness lie in the bounds of a `Rule`: those of Bühler et al.
(2018), doi:10.5194/nhess-18-3235-2018. Holes and spots of less than half of nine cells are smoothed away.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

KERNEL = np.full((5, 5), 0.625)
KERNEL[1:4, 1:4], KERNEL[2, 2] = 1.5, 3.0
KERNEL /= KERNEL.sum()
RUGGED = 7
"""Side of the square [cells] over which ruggedness is measured."""
HALO = 8
"""Cells around a window that its inner cells depend on."""
MAJORITY = 5
"""Of nine cells."""


@dataclass(frozen=True)
class Rule:
    """What can release. least, most: slope [degrees]; curvature: largest size [1/100 m]; ruggedness: largest [-];
    altitude: least [m]; mean: least mean slope of an area [degrees]; scale [m2]: how unlike parts of an area may be
    (`merging`); smallest, largest: plan area [m2]; period: for which return periods it is meant [years]."""

    least: float = 30.0
    most: float = 55.0
    curvature: float = 5.5
    ruggedness: float = 0.035
    altitude: float = -500.0
    mean: float = 30.0
    scale: float = 450.0
    smallest: float = 1000.0
    largest: float = 30_000.0
    period: float = 30.0


RULES = {
    "frequent": Rule(),
    "rare": Rule(least=28.0, mean=28.0, scale=800.0, largest=80_000.0, period=100.0),
    "extreme": Rule(least=28.0, mean=28.0, scale=3200.0, largest=250_000.0, period=300.0),
}


@dataclass(frozen=True)
class Measures:
    """Of each cell (rows, columns): slope [degrees]; curvature [1/100 m]; ruggedness [-]; down (2, rows, columns): unit
    vector downhill, east and north; NaN where the ground is not known."""

    slope: np.ndarray
    curvature: np.ndarray
    ruggedness: np.ndarray
    down: np.ndarray


def smoothed(z):
    """Heights smoothed by KERNEL; NaN beside missing ones."""
    known = np.isfinite(z)
    smooth = ndimage.convolve(np.where(known, z, 0.0), KERNEL, mode="constant")
    smooth[~ndimage.binary_erosion(known, np.ones((5, 5)), border_value=0)] = np.nan
    return smooth


def measures(z, cell):
    """`Measures` of heights (rows from the north, columns) [m] in cells [m]."""
    h = smoothed(z)
    east, north = np.full((2, *h.shape), np.nan)
    c = h[1:-1, 1:-1]
    w, e, n, s = h[1:-1, :-2], h[1:-1, 2:], h[:-2, 1:-1], h[2:, 1:-1]
    nw, ne, sw, se = h[:-2, :-2], h[:-2, 2:], h[2:, :-2], h[2:, 2:]
    inner = np.s_[1:-1, 1:-1]
    east[inner] = (ne + 2.0 * e + se - nw - 2.0 * w - sw) / (8.0 * cell)
    north[inner] = (nw + 2.0 * n + ne - sw - 2.0 * s - se) / (8.0 * cell)
    gx, gy = (e - w) / (2.0 * cell), (n - s) / (2.0 * cell)
    d, g = (0.5 * (w + e) - c) / cell**2, (0.5 * (n + s) - c) / cell**2
    f = (ne + sw - nw - se) / (4.0 * cell**2)
    curvature = np.full(h.shape, np.nan)
    curvature[inner] = -200.0 * (d * gy**2 + g * gx**2 - f * gx * gy) / np.maximum(gx**2 + gy**2, 1e-6)
    steep = np.hypot(east, north)
    return Measures(np.degrees(np.arctan(steep)), curvature, _ruggedness(east, north),
                    -np.stack([east, north]) / np.maximum(steep, 1e-12))


def _ruggedness(east, north):
    up = 1.0 / np.sqrt(1.0 + east**2 + north**2)
    known = np.isfinite(up)
    total = sum(ndimage.uniform_filter(np.where(known, part * up, 0.0), RUGGED, mode="constant") ** 2
                for part in (-east, -north, 1.0))
    found = 1.0 - np.sqrt(total)
    found[~ndimage.binary_erosion(known, np.ones((RUGGED, RUGGED)), border_value=0)] = np.nan
    return np.maximum(found, 0.0)


def can_release(z, found, rule, forest=None):
    """Mask (rows, columns) of cells that can release. found: their `Measures`; forest: mask of what trees protect."""
    mask = ((found.slope >= rule.least) & (found.slope <= rule.most) & (np.abs(found.curvature) <= rule.curvature)
            & (found.ruggedness <= rule.ruggedness) & (z >= rule.altitude))
    if forest is not None:
        mask &= ~forest
    return _smooth_mask(mask)


def _smooth_mask(mask):
    """Twice what most of nine cells are."""
    for _ in range(2):
        mask = ndimage.uniform_filter(mask.astype(np.float32), 3, mode="constant") > (MAJORITY - 0.5) / 9.0
    return mask
