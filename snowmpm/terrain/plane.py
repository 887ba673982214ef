"""A plane slope, as wide as the scene."""

import numpy as np

from snowmpm.errors import InputError


def plane_facets(point, angle, azimuth, lower, upper):
    """Vertices and facets of a plane over a plan box.

    point (dim,) [m] lies on it; it dips by `angle` [degrees] in the plan direction `azimuth` [degrees from +x towards
    +y; 0 = +x]; lower, upper (dim - 1,) [m]: the plan box.
    """
    point = np.asarray(point, float)
    d = len(point) - 1
    if not -89.0 <= angle <= 89.0:
        raise InputError.at("terrain.angle", angle, "must lie between -89 and 89 degrees")
    a, b = np.radians(angle), np.radians(azimuth)
    slope = -np.tan(a) * np.array([np.cos(b), np.sin(b)])[:d]
    if d == 1:
        plan = np.array([lower, upper])
        facets = [[0, 1]]
    else:
        plan = np.array([lower, [upper[0], lower[1]], upper, [lower[0], upper[1]]])
        facets = [[0, 1, 2], [0, 2, 3]]
    height = point[-1] + (plan - point[:-1]) @ slope
    return np.column_stack([plan, height]), np.array(facets)
