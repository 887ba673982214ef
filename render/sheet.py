"""Columns of snow as one sheet over the ground, thin where the flow is thin, instead of as single columns."""

import numpy as np
from scipy import ndimage

from snowmpm.render.blur import blur

FINE = 2
"""Places of the sheet for one column, each way; one where there would be more of them than MOST."""

MOST = 1_000_000
"""Places of the box around a sheet: some 130 MB."""

THIN = 0.03
"""Depth in spacings below which the ground shines through."""

WIDE = 2.0
"""Spacings over which snow is spread where columns are farther apart than their spacing."""

TRUNCATE = 2.0
"""Of that spread: where it ends, in its standard deviations."""

FEW = (0.7, 1.0)
"""Largest sum of columns nearby up to which they are spread in full, and from which not at all."""

REACH = 6.0
"""Spacings around the columns that snow can be spread to."""


def sheet_of(points, depth, spacing, colours, ground):
    """A depth-averaged flow as points of a sheet.

    points (n, 3): columns at half their depth (n,) [m], about `spacing` [m] apart; colours (n, 3) in linear light
    ground(x, y): its height [m], -inf where there is none
    -> points (m, 3) from the ground to the surface, their distance [m], colours (m, 4) with their opacity; None where
    the columns lie too far apart for a sheet of MOST places

    A column counts around it by a quadratic B-spline of three spacings in plan, which add up to one where columns lie
    on a lattice. Where they are denser the mean is taken; where they are sparser, they are spread more widely, and the
    depth goes to zero.
    """
    low = points[:, :2].min(axis=0) - REACH * spacing
    extent = points[:, :2].max(axis=0) + REACH * spacing - low
    fine = next((fine for fine in (FINE, 1) if np.prod(np.ceil(fine * extent / spacing) + 1.0) <= MOST), None)
    if fine is None:
        return None
    cell = spacing / fine
    shape = tuple(np.ceil(extent / cell).astype(int) + 1)
    values = np.column_stack([np.ones(len(points)), depth, colours * np.maximum(depth, 1e-9)[:, None],
                              np.maximum(depth, 1e-9), points[:, 2] - 0.5 * depth])
    sums = np.zeros((shape[0] * shape[1], values.shape[1]))
    at = (points[:, :2] - low) / cell
    begin = np.round(at).astype(int)
    reach = int(np.ceil(1.5 * fine))
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            node = begin + np.array([i, j])
            weight = np.prod(_spline(np.abs(node - at) / fine), axis=1)
            number = node[:, 0] * shape[1] + node[:, 1]
            for k in range(values.shape[1]):
                sums[:, k] += np.bincount(number, weight * values[:, k], len(sums))
    # Where columns are too few to add up to one, the rest is taken from farther around, but not at the rim of the flow
    near = ndimage.maximum_filter(sums[:, 0].reshape(shape), 2 * int((TRUNCATE * WIDE + 2.5) * fine) + 1)
    sparse = np.clip((FEW[1] - near.ravel()) / (FEW[1] - FEW[0]), 0.0, 1.0) * np.maximum(1.0 - sums[:, 0], 0.0)
    for part in sums.T:
        part += sparse * (blur(part.reshape(shape), WIDE * fine, TRUNCATE).ravel() - part)
    covered = np.flatnonzero(sums[:, 0] > 1e-3)
    share, total, red_green_blue, weight, base = np.split(sums[covered], (1, 2, 5, 6), axis=1)
    found = (total / np.maximum(share, 1.0))[:, 0]
    x, y = low[0] + cell * (covered // shape[1]), low[1] + cell * (covered % shape[1])
    height = ground(x, y)
    height = np.where(np.isfinite(height), height, (base / share)[:, 0])
    opacity = np.clip(found / (THIN * spacing), 0.0, 1.0)
    levels = np.arange(0, int(np.ceil(found.max(initial=0.0) / cell)) + 1)
    up, which = (part.ravel() for part in np.meshgrid(levels, np.arange(len(found)), indexing="ij"))
    inside = (up * cell < found[which]) & (opacity[which] > 0.02)
    up, which = up[inside], which[inside]
    # From the surface down, so that it is even
    places = np.column_stack([x[which], y[which], height[which] + found[which] - up * cell])
    shade = np.column_stack([red_green_blue / weight, opacity])[which]
    return places, cell, shade.astype(np.float32)


def _spline(r):
    """Quadratic B-spline of a distance in spacings."""
    return np.where(r < 0.5, 0.75 - r**2, 0.5 * np.maximum(1.5 - r, 0.0) ** 2)
