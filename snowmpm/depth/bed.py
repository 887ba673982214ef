"""The ground under a depth-averaged flow: heights at the nodes of its plan grid."""

import numpy as np
from scipy import ndimage

from snowmpm.compiler.arrays import real_array
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.smoothing import smoothed_ground
from snowmpm.errors import InputError


class Bed:
    """The ground as a spline whose coefficients go the way of depths, so that a level surface b + h stays level: by the
    same spline, and partly over the corners of the cells (`depth.smoothing`),

        b(x) = sum_i N(x - x_i) b_i,   b_i = (1 - s) z'_i + s mean_c z'_c,   z'_i = sum_j N(x_i - x_j) z_j

    which moves the ground by (1 + s) dx^2 / 4 times its curvature.

    heights (nx + 2 MARGIN, ny + 2 MARGIN) [m]: b_i, continued beyond the sides, and `table`, the same in one row for
    kernels, which may lower it; cos2 (nx, ny): cos^2 of the slope at the nodes at time zero; holes (nx, ny): cells
    without ground.
    """

    def __init__(self, surface, grid, mirrored=((False, False), (False, False))):
        """surface: with `height(plan (k, 2))` -> (k,) [m], NaN where there is none; mirrored: for each end of each axis
        whether it is a wall, beyond which the ground is the mirror image; at the periodic sides of the grid it goes on
        as at the other end, otherwise straight. InputError for no ground at all."""
        z = surface.height(grid.places().reshape(-1, 2)).reshape(grid.shape)
        self.holes = np.isnan(z)
        if self.holes.all():
            raise InputError("terrain: has no ground inside the domain")
        if self.holes.any():
            nearest = ndimage.distance_transform_edt(self.holes, return_distances=False, return_indices=True)
            z = z[tuple(nearest)]
        self.plain = _continued(z, mirrored, grid.repeats)
        """Heights of the surface itself at the nodes and beyond (nx + 2 MARGIN, ny + 2 MARGIN) [m]."""
        heights = smoothed_ground(self.plain)
        slope = np.stack(np.gradient(heights, grid.dx))[:, MARGIN:-MARGIN, MARGIN:-MARGIN]
        self.cos2 = 1.0 / (1.0 + (slope**2).sum(axis=0))
        self._shape, self.table = heights.shape, real_array(heights.ravel())

    @property
    def stride(self):
        """Places in the table from one column of nodes to the next."""
        return self._shape[1]

    @property
    def heights(self):
        """As they are now."""
        return self.table.to_numpy().reshape(self._shape)


def _continued(z, mirrored, repeats):
    """Heights (nx, ny) with `MARGIN` more on all sides: mirrored at walls, repeated, else straight on."""
    for axis in (0, 1):
        z = np.moveaxis(z, axis, 0)
        if repeats[axis]:
            period, place = np.divmod(np.arange(-MARGIN, len(z) + MARGIN), len(z))
            z = z[place] + period[:, None] * _drop(z)
        else:
            for end in (0, 1):
                widths = [[0, 0], [0, 0]]
                widths[0][end] = MARGIN
                if mirrored[axis][end]:
                    z = np.pad(z, widths, mode="symmetric")
                else:
                    z = np.pad(z, widths, mode="reflect", reflect_type="odd")
        z = np.moveaxis(z, 0, axis)
    return z


def _drop(z):
    """How much higher a repeated ground lies one period on (ny,): it goes on by the cubic through two differences of
    heights (nx, ny) along the first axis at either end; by the mean one where there are fewer than five nodes."""
    d = np.diff(z, axis=0)
    if len(z) < 5:
        return d.mean(axis=0) * len(z)
    return z[-1] - z[0] + (4.0 * (d[-1] + d[0]) - d[-2] - d[1]) / 6.0
