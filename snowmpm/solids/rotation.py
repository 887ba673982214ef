"""Finite rotations, in the plane of a 2-D scene and in space.

A turn is a number theta [rad] in 2-D, positive from +x towards +z, and a vector along its axis, right-handed, in 3-D.
"""

import numpy as np

SMALL = 1e-4
"""Angle [rad] below which sines over angles are taken from their series, exact to round-off there."""


def no_turn(dim):
    """The zero rotation: 0.0, or (3,) zeros."""
    return 0.0 if dim == 2 else np.zeros(3)


def rotation_matrix(turn):
    """R (dim, dim) of a turn.

        2-D: [[cos, -sin], [sin, cos]];  3-D (Rodrigues): R = I + sin t / t W + (1 - cos t) / t^2 W^2,  W = [turn x]
    """
    if np.ndim(turn) == 0:
        c, s = np.cos(turn), np.sin(turn)
        return np.array([[c, -s], [s, c]])
    W = cross_matrix(turn)
    first, second, _ = _series(np.linalg.norm(turn))
    return np.eye(3) + first * W + second * W @ W


def turn_velocity(turn, rate):
    """Angular velocity omega [rad/s] of R(turn(t)) for d turn / dt = rate.

        2-D: the rate;  3-D: omega = (I + (1 - cos t) / t^2 W + (t - sin t) / t^3 W^2) rate

    the left Jacobian of SO(3): J. Sola, J. Deray, D. Atchuthan (2018), arXiv:1812.01537, appendix B.
    """
    if np.ndim(turn) == 0:
        return float(rate)
    W = cross_matrix(turn)
    _, second, third = _series(np.linalg.norm(turn))
    return (np.eye(3) + second * W + third * W @ W) @ rate


def spin(omega, arm):
    """Velocities (k, dim) [m/s] of points at `arm` (k, dim) [m] from the point about which a body turns by `omega`."""
    if np.ndim(omega) == 0:
        return omega * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    return arm @ cross_matrix(omega).T


def cross_matrix(w):
    """W (3, 3) with W a = w x a."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def _series(t):
    """sin t / t, (1 - cos t) / t^2, (t - sin t) / t^3."""
    if t < SMALL:
        return 1.0 - t**2 / 6.0, 0.5 - t**2 / 24.0, 1.0 / 6.0 - t**2 / 120.0
    return np.sin(t) / t, (1.0 - np.cos(t)) / t**2, (t - np.sin(t)) / t**3
