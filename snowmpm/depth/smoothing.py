"""What columns do within a cell, kept out of their forces: part of the depth goes over the corners of the cells.

    phi_i = g ((1 - s) cos^2_i H_i + s mean_c cos^2_c H_c),   H_c, cos^2_c = mean of the four nodes around corner c

On level ground the second part is [1 2 1] / 4 along both axes. The sum is symmetric in the depths of the nodes, so that
sum_i V_i phi_i / 2 stays the energy of the forces. Without it the grid holds back a slow drift and makes disorder of it
(finite-grid instability, as of particles in cells of a plasma, Birdsall and Maron 1980,
doi:10.1016/0021-9991(80)90171-0); with all of it (s = 1) waves of two cells have no force at all, and stand behind
shocks. Heights of the ground go the same way, so that a level surface stays level.
"""

import numpy as np

SMOOTHING = 0.32
"""s: at 0.25 a drift at a fifth of the speed of waves loses 1 % of its momentum in 16 cells, at 0.32 0.7 %; the dam
break's error grows by 2 % and 5 %."""


def corner_means(values, repeats):
    """Means of the four nodes around every corner (nx + 1, ny + 1), of values at the nodes (nx, ny). Beyond the sides
    lie mirror images of the nodes, or at `repeats` (2,) those of the other end."""
    for axis in (0, 1):
        values = np.moveaxis(values, axis, 0)
        ends = (values[-1:], values[:1]) if repeats[axis] else (values[:1], values[-1:])
        wide = np.concatenate([ends[0], values, ends[1]])
        values = np.moveaxis(0.5 * (wide[:-1] + wide[1:]), 0, axis)
    return values


def surface_heights(depth, cos2, repeats):
    """phi / g (nx, ny) [m] of depths and cos^2 at the nodes."""
    corners = corner_means(depth, repeats) * corner_means(cos2, repeats)
    around = 0.25 * (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:])
    return (1.0 - SMOOTHING) * depth * cos2 + SMOOTHING * around


def smoothed_ground(z):
    """b_i (nx, ny) of heights at the nodes: what the spline of depths gives there for coefficients z, [1 6 1] / 8 along
    both axes, then the way over the corners. Beyond the border it continues in a straight line."""
    b = _filtered(z, 1.0 / 8.0)
    return (1.0 - SMOOTHING) * b + SMOOTHING * _filtered(b, 1.0 / 4.0)


def _filtered(values, side):
    for axis in (0, 1):
        values = np.moveaxis(values, axis, 0)
        wide = np.concatenate([2.0 * values[:1] - values[1:2], values, 2.0 * values[-1:] - values[-2:-1]])
        values = np.moveaxis(side * (wide[:-2] + wide[2:]) + (1.0 - 2.0 * side) * wide[1:-1], 0, axis)
    return values
