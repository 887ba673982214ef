"""Dams raised on an elevation raster.

    z(x) <- max(z(x), z(c) + H - tan(slope) max(0, |x - c| - w / 2)),   c: the point of the crest's line nearest to x

H: height of the crest above the ground under it, w: its width. So a side is the plane of the given slope where the line
is straight, and a cone around its ends.
"""

import math
import warnings
from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError

LEAST_CELLS = 2.0
"""Width of a dam's foot [cells] below which the raster cannot carry its shape."""


def with_dams(raster, dams):
    """A `Raster` on which `scenes.dams.Dam`s stand, each on the ground as it was before.

    Warns of one too narrow for the cells. InputError: a dam off the raster or over cells without data.
    """
    heights = raster.z.copy()
    for i, dam in enumerate(dams):
        _raise_along(heights, raster, dam, f"terrain.dams.{i} ({dam.name})")
    return replace(raster, z=heights) if dams else raster


def _raise_along(heights, raster, dam, where):
    """Raise heights (ny, nx) to the ridge of a dam."""
    import shapely  # slow to import, and few scenes have a dam

    line, steepness = shapely.LineString(dam.line), math.tan(math.radians(dam.slope))
    cell = max(np.ptp(axis) / (len(axis) - 1) for axis in (raster.x, raster.y))
    foot = dam.crest_width + 2.0 * dam.height / steepness
    if foot < LEAST_CELLS * cell:
        warnings.warn(f"{where}: its foot is {foot:.3g} m wide, less than {LEAST_CELLS:g} cells of {cell:g} m: the"
                      " raster cannot carry its shape", stacklevel=5)
    # The sides reach further than the foot where the ground falls away from the crest
    reach = 0.5 * dam.crest_width + (dam.height + np.nanmax(raster.z) - np.nanmin(raster.z)) / steepness
    reach = min(reach, 0.5 * dam.crest_width + 6.0 * dam.height / steepness + 2.0 * cell)
    lower, upper = np.array(line.bounds[:2]) - reach, np.array(line.bounds[2:]) + reach
    columns, rows = (np.flatnonzero((axis >= a) & (axis <= b))
                     for axis, a, b in zip((raster.x, raster.y), lower, upper, strict=True))
    if not (len(columns) and len(rows)):
        raise InputError.at(f"{where}: line", [list(point) for point in dam.line], "lies off the terrain")
    points = shapely.points(*np.meshgrid(raster.x[columns], raster.y[rows]))
    nearest = shapely.line_interpolate_point(line, shapely.line_locate_point(line, points))
    ground = _bilinear(raster, shapely.get_x(nearest), shapely.get_y(nearest))
    along = shapely.line_interpolate_point(line, np.linspace(0.0, line.length, 2 + int(line.length / cell)))
    if np.isnan(_bilinear(raster, shapely.get_x(along), shapely.get_y(along))).any():
        raise InputError.at(f"{where}: line", [list(point) for point in dam.line],
                            "lies partly off the terrain, or where it has no data")
    side = ground + dam.height - steepness * np.maximum(0.0, shapely.distance(points, line) - 0.5 * dam.crest_width)
    window = np.ix_(rows, columns)
    heights[window] = np.where(np.isnan(raster.z[window]), np.nan, np.fmax(heights[window], side))


def _bilinear(raster, x, y):
    """Heights [m] between cell centres; NaN outside and beside cells without data."""
    place = []
    for axis, at in ((raster.y, y), (raster.x, x)):
        step = np.ptp(axis) / (len(axis) - 1)
        cell = (at - axis[0]) / step
        low = np.clip(np.floor(cell).astype(int), 0, len(axis) - 2)
        outside = (cell < -1e-6) | (cell > len(axis) - 1 + 1e-6)
        place.append((low, np.where(outside, np.nan, np.clip(cell - low, 0.0, 1.0))))
    (row, v), (column, u) = place
    z = raster.z
    return ((1 - v) * ((1 - u) * z[row, column] + u * z[row, column + 1])
            + v * ((1 - u) * z[row + 1, column] + u * z[row + 1, column + 1]))
