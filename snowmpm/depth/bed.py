"""The ground under a depth-averaged flow: heights at the nodes of its plan grid."""

import numpy as np
from scipy import ndimage

from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.spline import smoothed
from snowmpm.errors import InputError


class Bed:
    """The ground as a spline whose coefficients are smoothed by the same spline as depths are, so that a level surface
    b + h stays level:

        b(x) = sum_i N(x - x_i) b_i,   b_i = sum_j N(x_i - x_j) z_j

    which moves the ground by dx^2 / 4 times its curvature.

    heights (nx + 2 MARGIN, ny + 2 MARGIN) [m]: b_i, continued beyond the sides; cos2 (nx, ny): cos^2 of the slope at
    the nodes; holes (nx, ny): cells without ground.
    """

    def __init__(self, surface, grid):
        """surface: with `height(plan (k, 2))` -> (k,) [m], NaN where there is none. InputError for no ground at all."""
        z = surface.height(grid.places().reshape(-1, 2)).reshape(grid.shape)
        self.holes = np.isnan(z)
        if self.holes.all():
            raise InputError("terrain: has no ground inside the domain")
        if self.holes.any():
            nearest = ndimage.distance_transform_edt(self.holes, return_distances=False, return_indices=True)
            z = z[tuple(nearest)]
        self.heights = smoothed(np.pad(z, MARGIN, mode="reflect", reflect_type="odd"))
        slope = np.stack(np.gradient(self.heights, grid.dx))[:, MARGIN:-MARGIN, MARGIN:-MARGIN]
        self.cos2 = 1.0 / (1.0 + (slope**2).sum(axis=0))
