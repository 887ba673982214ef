"""The weight of a node on an axis, by its distance, and the mass of a node beside a plane that snow fills.

For tables that are made once, in double precision; the transfers have their own form (`transfer.stencil`)."""

import numpy as np

from snowmpm.schemes import BASES


def node_weight(x, kernel):
    """Weight of a node at the distance x [cells]."""
    if box := BASES[kernel].box:
        return (_filled(x + 0.5 * box) - _filled(x - 0.5 * box)) / box
    x = np.abs(x)
    if kernel == "cubic":
        return np.where(x < 1.0, 2.0 / 3.0 - x * x * (1.0 - 0.5 * x), np.maximum(2.0 - x, 0.0) ** 3 / 6.0)
    return np.where(x < 0.5, 0.75 - x * x, 0.5 * np.maximum(1.5 - x, 0.0) ** 2)


def _filled(x):
    """Integral of the linear hat up to x."""
    tail = 0.5 * np.maximum(1.0 - np.abs(x), 0.0) ** 2
    return np.where(x > 0.0, 1.0 - tail, tail)


def half_space(z, kernel):
    """Mass of a node at z [cells] of snow that fills z > 0, over its mass far above: the weight's integral up to z."""
    if box := BASES[kernel].box:
        return (_twice(z + 0.5 * box) - _twice(z - 0.5 * box)) / box
    if kernel == "quadratic":
        u = np.clip(z, -1.5, 1.5)
        tail = (1.5 - np.abs(u)) ** 3 / 6.0
        return np.where(np.abs(u) < 0.5, 0.5 + u * (0.75 - u**2 / 3.0), np.where(u > 0.0, 1.0 - tail, tail))
    a = np.abs(np.clip(z, -2.0, 2.0))
    half = np.where(a < 1.0, 2.0 / 3.0 * a - a**3 / 3.0 + a**4 / 8.0, 0.5 - (2.0 - a) ** 4 / 24.0)
    return 0.5 + np.where(z > 0.0, half, -half)


def _twice(z):
    """Integral of the linear hat's integral up to z."""
    return np.maximum(z, 0.0) + np.maximum(1.0 - np.abs(z), 0.0) ** 3 / 6.0
