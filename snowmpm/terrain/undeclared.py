"""Cells without data that a raster does not declare: numbers that stand for "none" taken as heights."""

from typing import NamedTuple

import numpy as np

MARKS = (-32768.0, -32767.0, 32767.0, 65535.0, -9999.0, 9999.0, -99999.0, 99999.0, -999999.0, -999.0)
"""Numbers that programs write where there is no value."""

HUGE = 1e19
"""So is what is larger: the ends of single and double precision, and round numbers towards them."""

TORN = 1000.0, 5.0
"""Step between neighbouring cells that no ground has: both higher than this [m] and steeper than this (height over
distance). The highest walls of the Earth are as high and less steep."""

PIT = 50.0, 2.0
"""The same for cells that all hold one number, where each of their borders is such a step."""

LEVEL = 4
"""Steps beside cells of one number, other than 0, from which on they are looked at."""

MOST_LEVELS = 20
"""Numbers, of those that most cells hold, that are looked at."""


class Undeclared(NamedTuple):
    """Cells without data that a raster takes for heights. where: mask; value: the number of most of them; off: how far
    it lies above the middle height of the others [m]."""

    where: np.ndarray
    value: float
    off: float


def marked(values):
    """Mask of the values that are one of MARKS or HUGE."""
    return np.isin(values, MARKS) | (np.abs(values) >= HUGE)


def undeclared_heights(z, distance, metre=1.0):
    """`Undeclared` cells of heights z (rows, columns) in units of `metre` [m], NaN where a cell has none; None: none.

    distance [m]: between the cells.

    Ground without steps beyond TORN in itself is one piece. Everything torn off the largest piece stands for "none":
    -32768, 32767 or -3.4e38 beside heights, and what interpolation made of them, with the cells beside it. So do cells
    of 0, -1 or another number that lie beyond PIT of all that is around them: ground has no level floor with walls on
    all sides. Pieces of one of MARKS are never the ground.
    """
    from scipy.ndimage import binary_dilation  # slow to import

    found = np.zeros(z.shape, bool)
    step = max(TORN[0], TORN[1] * distance) / metre
    number, count = _pieces(z, step)
    ground, suspect = None, marked(z)
    if count > 1:
        known = number >= 0
        sizes = np.bincount(number[known & ~suspect], minlength=count)
        if sizes.max() > 0:
            ground = int(sizes.argmax())
            found |= known & (number != ground)
    elif suspect.any() and (suspect | np.isnan(z)).all():
        found |= suspect
    left = np.where(found, np.nan, z)
    wall = max(PIT[0], PIT[1] * distance) / metre
    for level in _levels(left, wall):
        found |= _pits(left, level, wall)
    if not found.any():
        return None
    if len(np.unique(z[found & ~suspect & (z != 0.0)])) > 1:  # interpolated with heights, as cells beside them were
        found |= binary_dilation(found, np.ones((3, 3), bool)) & np.isfinite(z)
    values, counts = np.unique(z[found], return_counts=True)
    value = float(values[counts.argmax()])
    rest = np.where(found, np.nan, z)
    off = (value - float(np.nanmedian(rest))) * metre if not np.isnan(rest).all() else np.nan
    return Undeclared(found, value, off)


def _pieces(z, step):
    """Number of the piece (rows, columns) that each cell belongs to, -1 without a value, and how many there are: cells
    of one piece are joined by steps smaller than `step`."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    known = np.isfinite(z)
    # Most rasters have no such step at all
    across, along = np.abs(np.diff(z, axis=1)), np.abs(np.diff(z, axis=0))
    if not ((across > step).any() or (along > step).any()):
        return np.where(known, 0, -1), 1
    index = np.arange(z.size).reshape(z.shape)
    ends = [(index[:, :-1][across <= step], index[:, 1:][across <= step]),
            (index[:-1][along <= step], index[1:][along <= step])]
    a, b = (np.concatenate([pair[k] for pair in ends]) for k in (0, 1))
    _, number = connected_components(coo_matrix((np.ones(len(a), bool), (a, b)), (z.size, z.size)), directed=False)
    number = number.reshape(z.shape)
    kept, number[known] = np.unique(number[known], return_inverse=True)
    number[~known] = -1
    return number, len(kept)


def _levels(z, wall):
    """Numbers that several cells beside a step of at least `wall` hold exactly, the most frequent first, and 0."""
    beside = []
    for axis in (0, 1):
        height = np.moveaxis(z, axis, 0)
        steep = np.abs(np.diff(height, axis=0)) >= wall
        beside += [height[:-1][steep], height[1:][steep]]
    values, counts = np.unique(np.concatenate(beside), return_counts=True)
    often = np.argsort(-counts)[:MOST_LEVELS]
    return dict.fromkeys([0.0, *(float(values[k]) for k in often if counts[k] >= LEVEL)] if len(values) else [])


def _pits(z, level, step):
    """Mask of the cells at a `level` that are `step` [m] and more off all that borders on them."""
    from scipy.ndimage import label

    level_cells = z == level
    found = np.zeros(z.shape, bool)
    if not level_cells.any() or not (np.abs(np.nan_to_num(z) - level) >= step).any():
        return found
    number, count = label(level_cells)
    least = np.full(count + 1, np.inf)
    for axis in (0, 1):
        first = np.moveaxis(number, axis, 0)
        height = np.moveaxis(z, axis, 0)
        for inner, outer in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            border = (first[inner] > 0) & (first[outer] == 0) & np.isfinite(height[outer])
            np.minimum.at(least, first[inner][border], np.abs(height[outer][border] - level))
    least[0] = 0.0
    return np.isfinite(least)[number] & (least >= step)[number]
