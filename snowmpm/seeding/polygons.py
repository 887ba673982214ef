"""Areas bounded by straight lines, with holes."""

import numpy as np

ASIDE = np.array([1e-9, 0.37e-9])
"""By how much, of the size, points are moved before it is asked what they are inside of: those on an edge, as rows of a
lattice may be, are then all inside or all outside, whatever the round-off; along edges of any usual slope."""


class Rings:
    """An area bounded by one or more rings: inside is where a ray crosses the rings an odd number of times.

    rings: list of (n, 2) arrays of corners [m], closed by themselves; a ring inside another is a hole.
    """

    def __init__(self, rings):
        self.rings = [self._opened(np.asarray(ring, float)[:, :2]) for ring in rings]
        self.rings = [ring for ring in self.rings if len(ring) > 2]

    @staticmethod
    def _opened(ring):
        return ring[:-1] if len(ring) > 1 and (ring[0] == ring[-1]).all() else ring

    def bounds(self):
        """Lower and upper corner (2,) [m]."""
        corners = np.concatenate(self.rings)
        return corners.min(axis=0), corners.max(axis=0)

    def area(self):
        """Area [m2]; rings inside an odd number of others are subtracted."""
        total = 0.0
        for i, ring in enumerate(self.rings):
            x, y = (ring - ring[0]).T
            own = 0.5 * abs(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()))
            others = sum(bool(Rings([r]).contains(ring[:1])[0]) for j, r in enumerate(self.rings) if j != i)
            total += own if others % 2 == 0 else -own
        return total

    def contains(self, points):
        """Which of the points (k, 2) lie inside; shape (k,). Those on left and lower edges do, on others not."""
        if not self.rings:
            return np.zeros(len(points), bool)
        lower, upper = self.bounds()
        points = points + ASIDE * np.max(upper - lower)
        order = np.argsort(points[:, 1], kind="stable")
        x, y = points[order].T
        odd = np.zeros(len(x), bool)
        for ring in self.rings:
            for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                if y0 == y1:
                    continue
                # Only points at the height of the edge can be crossed: with sorted points the work stays linear.
                first, last = np.searchsorted(y, [min(y0, y1), max(y0, y1)], side="left")
                span = slice(first, last)
                odd[span] ^= x[span] < x0 + (y[span] - y0) * ((x1 - x0) / (y1 - y0))
        inside = np.empty(len(x), bool)
        inside[order] = odd
        return inside

    def moved(self, axes):
        """The same area in coordinates along the rows of `axes` (2, 2)."""
        return Rings([ring @ np.asarray(axes).T for ring in self.rings])
