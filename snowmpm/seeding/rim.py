"""Columns of snow at the free rim of a layer, divided so that a front resolves the depths to which it thins out.

Where snow of the depth h0 is let go at its rim, what lay s behind it is after a time t at

    x = 2 c t - 3 (c t)^(2/3) s^(1/3),    depth h0 (s / c t)^(2/3),    c = sqrt(g h0)        (Ritter 1892)

so that neighbours w apart are then w (c t / s)^(2/3) apart, and a last column of width w is 1.5 (w / 2 c t)^(1/3) of
the way short: 24 % with columns of 1/250 of it. Columns stay within half a cell dx of each other with the widths

    w(s) = dx/2 min(1, (s / L)^(2/3)) >= r dx/2

down to the depth r h0. L stands for c t: DEPTHS times h0, since a shorter one costs less and a front that has come
further is the sharper one (`tests/verification/test_depth_dam_break.py`).
"""

from dataclasses import dataclass

import numpy as np

from snowmpm import memory

DEPTHS = 3.0
"""L over the depth of the snow [-]."""


@dataclass(frozen=True)
class Rim:
    """How columns are divided at the rims of layers. least: r [-]; walls: sides of the domain that hold snow, lines of
    the plan as (axis, level) [m]."""

    least: float
    walls: tuple = ()

    def divided(self, region, plan, lattice, *, dx, depth):
        """`divided` for the columns of a region at plan (n, 2) in the middles of cells of a lattice; None where no rim
        is free."""
        import shapely

        rim = self.free(region)
        if rim is None:
            return None
        points = shapely.points(plan)
        foot = shapely.get_coordinates(shapely.line_interpolate_point(rim, shapely.line_locate_point(rim, points)))
        away = plan - foot
        across = np.abs(away @ lattice.axes.T) / np.maximum(np.linalg.norm(away, axis=1), 1e-300)[:, None]
        width = (lattice.steps / np.maximum(across, 1e-12)).min(axis=1)
        return divided(away, width, dx=dx, depth=depth, least=self.least)

    def free(self, region):
        """Lines at which the snow of a region ends without being held: its outline but for what lies on the walls.
        None where nothing is left."""
        import shapely

        outline = region.outline()
        reach = 1e-6 * float(np.max(region.upper - region.lower))
        for axis, level in self.walls:
            lower, upper = region.lower - 1.0, region.upper + 1.0
            lower[axis], upper[axis] = level - reach, level + reach
            outline = outline.difference(shapely.box(*lower, *upper))
        return None if outline.is_empty else outline


def counted(s, dx, length, least):
    """N(s): number of columns between the rim and a distance s (n,) [m] from it: ds / w added up."""
    s0 = length * least**1.5
    near = 2.0 * np.minimum(s, s0) / (dx * least)
    fan = 6.0 * length ** (2.0 / 3.0) / dx * (np.cbrt(np.clip(s, s0, length)) - np.cbrt(s0))
    return near + fan + 2.0 * np.maximum(s - length, 0.0) / dx


def distance_of(number, dx, length, least):
    """s (n,) [m] that has so many columns between it and the rim: the inverse of `counted`."""
    s0 = length * least**1.5
    near, fan = 2.0 * s0 / (dx * least), 6.0 * length ** (2.0 / 3.0) / dx * (np.cbrt(length) - np.cbrt(s0))
    root = np.cbrt(s0) + np.clip(number - near, 0.0, fan) * dx / (6.0 * length ** (2.0 / 3.0))
    far = length + 0.5 * dx * (number - near - fan)
    return np.where(number < near, 0.5 * dx * least * number, np.where(number < near + fan, root**3, far))


def divided(away, width, *, dx, depth, least):
    """Parts of columns near a rim.

    away (n, 2): from the nearest place of the rim to the column; width (n,): of the column in that direction [m];
    depth [m]: of the snow there; least: r. -> number of its column, shift in plan and share of its volume, each of (m,)
    parts. The parts of a column lie across the rim, in the interval that is centred on the column, as wide as it and on
    its side of the rim: so its mass centre stays. Columns beyond L from the rim stay whole. InputError for more parts
    than the memory holds.
    """
    length, s = DEPTHS * depth, np.linalg.norm(away, axis=1)
    half = np.minimum(0.5 * width, s)
    first, last = (counted(end, dx, length, least) for end in (s - half, s + half))
    near = (s - half < length) & (s > 1e-9 * width)
    parts = np.where(near, np.maximum(np.ceil(last - first - 1e-9), 1.0), 1.0).astype(int)
    memory.require(memory.PER_PARTICLE[3] * float(parts.sum()), "solver.depth.rim: the columns at the rims")
    number = np.repeat(np.arange(len(s)), parts)
    k = np.arange(len(number)) - np.repeat(np.cumsum(parts) - parts, parts)
    begin, each = first[number], ((last - first) / parts)[number]
    inner, outer = (distance_of(begin + (k + end) * each, dx, length, least) for end in (0, 1))
    split = parts[number] > 1
    share = np.where(split, (outer - inner) / np.where(split, 2.0 * half[number], 1.0), 1.0)
    along = np.where(split, 0.5 * (inner + outer) / np.where(split, s[number], 1.0) - 1.0, 0.0)
    return number, along[:, None] * away[number], share
