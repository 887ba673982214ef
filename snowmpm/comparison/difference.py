"""Difference between two runs."""

import numpy as np


def profile_difference(one, other):
    """Mean distance of two `Profile`s over all that either covers, over the greatest depth of the first [-].

    Beyond the end of a profile, its surface is taken as its own lowest ground.
    """
    s = np.union1d(one.s, other.s)
    heights = [np.where(np.isnan(found.at(s)), np.min(found.bottom), found.at(s)) for found in (one, other)]
    depth = float(np.max(one.top - one.bottom))
    apart = np.abs(heights[0] - heights[1])
    return float(np.sum(0.5 * (apart[1:] + apart[:-1]) * np.diff(s)) / (s[-1] - s[0]) / depth) if len(s) > 1 else 0.0
