"""Curved ground as data: a distance and a normal."""

import numpy as np


class Waves:
    """Ground in waves of 2 cm, one in 1.6 m."""

    def query(self, points):
        phase = 2.0 * np.pi / 1.6 * points[:, 0]
        normal = np.zeros_like(points)
        normal[:, 0], normal[:, -1] = -0.02 * 2.0 * np.pi / 1.6 * np.cos(phase), 1.0
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return (points[:, -1] - 0.02 * np.sin(phase)) * normal[:, -1], normal
