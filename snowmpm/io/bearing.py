"""The area over which columns of a depth-averaged flow bear on an obstacle, which they pass as if it were not there.

    A = d b,   d = min(vertical depth, height of the obstacle above the ground)

as in the load itself (`snowmpm.depth.loads`); b: width of the obstacle across the load. Frames give d at a few times
only. The load acts at d / 2 above the ground, so that its lever about the centre of the obstacle tells how d changes
between them:

    d(t) = d(t_0) + 2 (lever(t) - lever(t_0)),   lever = (M_y F_x - M_x F_y) / (F_x^2 + F_y^2)

with t_0 of the frame with the largest d.
"""

import numpy as np
import shapely

FLAT = 6
"""Fewest columns from which the slope is read; fewer are taken to lie on level ground."""


def bearing_depth(vertices, points, thickness, dx):
    """d [m]; 0 where no column is near.

    vertices (n, 3) [m]: of the obstacle; points (k, 3), thickness (k,) [m]: columns, at half their depth, and their
    thickness normal to the ground; dx [m]: cell of the plan grid.
    """
    outline = shapely.convex_hull(shapely.MultiPoint(vertices[:, :2]))
    near = (thickness > 0.0) & shapely.contains_xy(shapely.buffer(outline, 0.5 * dx), *points[:, :2].T)
    if not near.any():
        return 0.0
    points, mean = points[near].astype(float), float(thickness[near].mean())
    cosine = 1.0
    if len(points) >= FLAT:
        plane = np.column_stack([points[:, :2] - points[:, :2].mean(axis=0), np.ones(len(points))])
        slope = np.linalg.lstsq(plane, points[:, 2], rcond=None)[0][:2]
        cosine = 1.0 / np.sqrt(1.0 + slope @ slope)
    ground = float(points[:, 2].mean()) - 0.5 * mean * cosine
    return max(0.0, min(mean / cosine, float(vertices[:, 2].max()) - ground))


def width_across(vertices, direction):
    """b [m] of vertices (n, 3) across a direction (3,)."""
    across = np.array([-direction[1], direction[0]])
    return float(np.ptp(vertices[:, :2] @ across)) / max(float(np.linalg.norm(across)), 1e-300)


def bearing_areas(obstacle, direction, times, depths):
    """Times [s] and A [m2] of the record of an obstacle (`snowmpm.io.Obstacle`), from depths (k,) [m] at the times (k,)
    of frames."""
    width = width_across(obstacle.vertices, direction)
    force, moment = obstacle.force, obstacle.moment
    square = (force[:, :2] ** 2).sum(axis=1)
    lever = np.divide(moment[:, 1] * force[:, 0] - moment[:, 0] * force[:, 1], square, out=np.zeros(len(square)),
                      where=square > 0.0)
    loaded = square > 0.0
    if not len(depths) or max(depths) <= 0.0 or not loaded.any():
        return np.array(times), width * np.array(depths)
    at = int(np.argmax(depths))
    reference = np.interp(times[at], obstacle.time[loaded], lever[loaded])
    depth = np.where(loaded, depths[at] + 2.0 * (lever - reference), 0.0)
    return obstacle.time, width * np.maximum(0.0, depth)
