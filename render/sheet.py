"""Columns of snow as one sheet over the ground, thin where the flow is thin, instead of as single columns."""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class Sheet:
    """A depth-averaged flow on a raster of `cell` [m]: its places (row, column), x, y, height of the ground and depth
    (n,) [m], colours (n, 3) in linear light, opacity (n,)."""

    cell: float
    row: np.ndarray
    column: np.ndarray
    x: np.ndarray
    y: np.ndarray
    ground: np.ndarray
    depth: np.ndarray
    colours: np.ndarray
    opacity: np.ndarray


def sheet_raster(points, depth, spacing, colours, ground, finest=FINE):
    """The `Sheet` of a flow; None where the columns lie too far apart for a sheet of MOST places.

    points (n, 3): columns at half their depth (n,) [m], about `spacing` [m] apart; colours (n, 3) in linear light
    ground(x, y): its height [m], -inf where there is none; finest: places for one column, each way, at most

    A column counts around it by a quadratic B-spline of three spacings in plan, which add up to one where columns lie
    on a lattice. Where they are denser the mean is taken; where they are sparser, they are spread more widely, and the
    depth goes to zero.
    """
    low = points[:, :2].min(axis=0) - REACH * spacing
    extent = points[:, :2].max(axis=0) + REACH * spacing - low
    fine = next((fine for fine in (finest, 1) if np.prod(np.ceil(fine * extent / spacing) + 1.0) <= MOST), None)
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
    row, column = covered // shape[1], covered % shape[1]
    x, y = low[0] + cell * row, low[1] + cell * column
    height = ground(x, y)
    height = np.where(np.isfinite(height), height, (base / share)[:, 0])
    opacity = np.clip(found / (THIN * spacing), 0.0, 1.0)
    return Sheet(cell, row, column, x, y, height, found, red_green_blue / weight, opacity)


def sheet_of(points, depth, spacing, colours, ground):
    """`sheet_points` of a flow; None and arguments as of `sheet_raster`."""
    sheet = sheet_raster(points, depth, spacing, colours, ground)
    return None if sheet is None else sheet_points(sheet)


def sheet_points(sheet):
    """Points (m, 3) of a `Sheet` from the ground up, their distance [m], colours (m, 4) with their opacity."""
    levels = np.arange(0, int(np.ceil(sheet.depth.max(initial=0.0) / sheet.cell)) + 1)
    up, which = (part.ravel() for part in np.meshgrid(levels, np.arange(len(sheet.depth)), indexing="ij"))
    inside = (up * sheet.cell < sheet.depth[which]) & (sheet.opacity[which] > 0.02)
    up, which = up[inside], which[inside]
    # From the surface down, so that it is even
    top = np.column_stack([sheet.x, sheet.y, sheet.ground + sheet.depth])[which]
    places = top - up[:, None] * [0.0, 0.0, sheet.cell]
    return places, sheet.cell, np.column_stack([sheet.colours, sheet.opacity])[which].astype(np.float32)


def _spline(r):
    """Quadratic B-spline of a distance in spacings."""
    return np.where(r < 0.5, 0.75 - r**2, 0.5 * np.maximum(1.5 - r, 0.0) ** 2)
