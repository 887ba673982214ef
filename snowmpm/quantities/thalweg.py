"""The line along which lengths of an avalanche are counted, beyond its end at the run-out."""

import numpy as np

STRAIGHT = 12
"""Points at the end of a thalweg that give the direction in which it goes on."""


def ahead_of(line: np.ndarray) -> np.ndarray:
    """Unit vector (2,) in which a thalweg (n, 2) [m] is extended straight; zero where its last points are one."""
    ahead = line[-1] - line[max(0, len(line) - 1 - STRAIGHT)]
    return ahead / max(float(np.linalg.norm(ahead)), 1e-12)
