"""Packings of spheres as images."""

import numpy as np

ZICK_HOMSY = {0.027: 4.0988, 0.064: 1.2357, 0.125: 0.41421, 0.216: 0.13824, 0.343: 0.04207, 0.45: 0.017574,
              0.5236: 0.010081}
"""Permeability over the square of the radius of a simple cubic packing, by its solid fraction (Zick and Homsy 1982,
doi:10.1017/S0022112082000627, through k / a^2 = 2 / (9 phi K))."""


def simple_cubic(n, fraction):
    """Ice (n, n, n) of a sphere in a periodic cell of n voxels, and its radius [voxels]."""
    radius = n * (3.0 * fraction / (4.0 * np.pi)) ** (1.0 / 3.0)
    x = np.arange(n) + 0.5 - 0.5 * n
    return x[:, None, None] ** 2 + x[None, :, None] ** 2 + x[None, None] ** 2 <= radius**2, radius
