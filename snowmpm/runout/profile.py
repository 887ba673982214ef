"""The profile of the ground along a path."""

import functools
import math
from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

SPACING = 10.0
"""Length in plan between points of a profile [m]."""
GENTLE = 20.0
"""Slope [degrees] from which on the foot of a path is looked for, of the parabola through its ends."""
STRETCH = 100.0
"""Length [m] over which ground counts as steep, or level."""
TURN = 50.0
"""Length [m] of the pieces between which a path turns."""
LEAST = 3
"""Points of a profile."""


@dataclass(frozen=True)
class Profile:
    """s (n,) [m]: length in plan from the upper end; plan (n, 2) [m]; z (n,) [m]: height of the ground."""

    s: np.ndarray
    plan: np.ndarray
    z: np.ndarray

    @property
    def drop(self):
        """Fall from the upper end (n,) [m]."""
        return self.z[0] - self.z

    @property
    def angles(self):
        """Angle of the piece that ends at each point (n,), downwards [degrees]; the first is that of the second."""
        pieces = np.degrees(np.arctan2(-np.diff(self.z), np.diff(self.s)))
        return np.concatenate([pieces[:1], pieces])

    @functools.cached_property
    def parabola(self):
        """(a, b, c): z = a s² + b s + c of least squares through all points [1/m], [-], [m]."""
        return np.polyfit(self.s, self.z, 2)

    def foot(self):
        """Length [m] from which on a path is gentle: where the parabola through its ends of least squares comes to
        GENTLE degrees. The upper end, where it never does, or always is."""
        s, end = self.s, self.s[-1]
        chord = self.z[0] + (self.z[-1] - self.z[0]) * s / end
        shape = s * (s - end)
        a = float(shape @ (self.z - chord) / max(shape @ shape, 1e-30))
        # Slope of chord + a s (s - end)
        steepness = (self.z[-1] - self.z[0]) / end + a * (2.0 * s - end)
        gentle = np.flatnonzero(-steepness <= math.tan(math.radians(GENTLE)))
        found = float(s[gentle[0]]) if len(gentle) else 0.0
        # A long flat tail draws it out beyond the foot: then from the last steep ground before it
        steep = np.flatnonzero((s < found) & (self.fall_over(STRETCH) >= STRETCH * math.tan(math.radians(GENTLE))))
        level = self.fall_over(STRETCH)[min(int(np.searchsorted(s, found - STRETCH)), len(s) - 1)]
        if len(steep) and level < STRETCH * math.tan(math.radians(0.5 * GENTLE)):
            return float(s[steep[-1]])
        return found

    def fall_over(self, length):
        """Fall [m] of the ground from each point (n,) over a length ahead [m]; to the end of the path at most."""
        return self.z - np.interp(self.s + length, self.s, self.z)

    @property
    def sharpest(self):
        """Sharpest turn of the path in plan [degrees], and the length where it is [m]; between places 50 m apart."""
        s = np.arange(0.0, self.s[-1] + 1e-9, TURN)
        pieces = np.diff(np.column_stack([np.interp(s, self.s, axis) for axis in self.plan.T]), axis=0)
        if len(pieces) < 2:
            return 0.0, 0.0
        units = pieces / np.maximum(np.linalg.norm(pieces, axis=1), 1e-9)[:, None]
        turns = np.degrees(np.arccos(np.clip((units[1:] * units[:-1]).sum(axis=1), -1.0, 1.0)))
        return float(turns.max()), float(s[1 + int(turns.argmax())])

    def nearest(self, place):
        """Length [m] of the point nearest to a place (2,)."""
        return float(self.s[np.argmin(np.linalg.norm(self.plan - place, axis=1))])

    def at(self, s):
        """Place in plan (2,) and height [m] at a length."""
        x, y, z = (float(np.interp(s, self.s, values)) for values in (*self.plan.T, self.z))
        return np.array([x, y]), z

    def where_reached(self, height, start=0.0):
        """Length [m] at which the ground comes up to a line of heights (n,) from the upper end, linear between points:
        the first beyond `start`, or the last before, where the line is below the ground there. 0 where the line is
        below the ground all along; None where the ground does not come up to it."""
        above = height - self.z
        if not (above > 0.0).any():
            return 0.0
        crossings = np.flatnonzero((above[:-1] > 0.0) & (above[1:] <= 0.0))
        share = above[crossings] / (above[crossings] - above[crossings + 1])
        found = (self.s[crossings] + share * (self.s[crossings + 1] - self.s[crossings])).tolist()
        before, beyond = [s for s in found if s <= start], [s for s in found if s > start]
        if before and float(np.interp(start, self.s, above)) <= 0.0:
            return before[-1]
        return beyond[0] if beyond else None


def profile_of(line, height, where, spacing=SPACING):
    """`Profile` along a line (k, 2) in plan, from its higher end, its points as far apart as `spacing` or less [m].

    height: function of places (n, 2) -> height of the ground (n,) [m], NaN where it is not known; where: the line is
    from, for messages. InputError for a line without length or off the ground.
    """
    line = np.asarray(line, float)
    line = line[np.concatenate([[True], np.linalg.norm(np.diff(line, axis=0), axis=1) > 0.0])]
    if len(line) < 2:
        raise InputError(f"{where}: has no length")
    ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    s = np.linspace(0.0, ways[-1], max(LEAST, math.ceil(ways[-1] / spacing) + 1))
    plan = np.column_stack([np.interp(s, ways, axis) for axis in line.T])
    z = np.asarray(height(plan), float)
    if not np.isfinite(z).all():
        x, y = plan[np.flatnonzero(~np.isfinite(z))[0]]
        raise InputError(f"{where}: leaves the ground at {x:.0f}, {y:.0f}")
    if z[-1] > z[0]:
        plan, z = plan[::-1], z[::-1]
    steps = np.linalg.norm(np.diff(plan, axis=0), axis=1)  # shorter than spacing where the line bends
    return Profile(np.concatenate([[0.0], np.cumsum(steps)]), plan, z)
