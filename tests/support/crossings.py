"""Where a series changes its sign."""

import numpy as np


def crossings(times, values):
    """When a series changes its sign."""
    n = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return times[n] - values[n] * (times[n + 1] - times[n]) / (values[n + 1] - values[n])
