"""Unit quaternions (w, x, y, z): orientations in space that do not drift away from rotations."""

import math

import numpy as np

from snowmpm.solids.rotation import SMALL

NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])


def product(p, q):
    """Rotation q first, then p."""
    (a, b, c, d), (w, x, y, z) = p, q
    return np.array([a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x,
                     a * z + b * y - c * x + d * w])


def of_turn(turn):
    """Quaternion of a rotation vector (3,) [rad]: (cos t/2, sin(t/2) turn / t)."""
    x, y, z = turn
    angle = math.sqrt(x * x + y * y + z * z)
    share = 0.5 - angle**2 / 48.0 if angle < SMALL else math.sin(0.5 * angle) / angle
    return np.array([math.cos(0.5 * angle), share * x, share * y, share * z])


def matrix(q):
    """R (3, 3) of a unit quaternion."""
    w, x, y, z = q
    return np.array([[1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                     [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                     [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]])
