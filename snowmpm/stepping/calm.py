"""What counts as calm: the scale of `solver.sleeping`."""

import math

import numpy as np


def calm(share, dx, gravity):
    """-> (speed [m/s] that snow keeps below, for how long [s]) until it counts as calm.

    share sqrt(g dx) and sqrt(dx / g): for so long snow in free fall takes up the speed sqrt(g dx), so that calm snow
    is in balance to 2 share of its weight. dx [m]; gravity (dim,) [m/s2]; without gravity never (0, inf).
    """
    g = float(np.linalg.norm(gravity))
    return (share * math.sqrt(g * dx), math.sqrt(dx / g)) if g > 0.0 else (0.0, math.inf)
