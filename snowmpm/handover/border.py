"""The border of a region in plan, across which snow goes from one method to another."""

import numpy as np

SPREAD = 2
"""Cells beyond the region as far as which columns are spread that have entered it (`handover.spreading`), so that snow
leaves it only there."""

REACH = 3
"""Cells between snow of two methods that still press on each other."""

AROUND = np.ones((3, 3), bool)


class Border:
    """A region in whole cells of side `side` [m] over the plan box from `lower` to `upper` (2,) [m]."""

    def __init__(self, inside, lower, upper, side):
        """inside: places in plan (k, 2) [m] -> whether they lie in the region (k,)."""
        self._lower, self._side = np.asarray(lower, float)[:2], float(side)
        shape = np.maximum(1, np.ceil((np.asarray(upper, float)[:2] - self._lower) / side - 1e-6)).astype(int)
        from scipy.ndimage import binary_dilation  # slow to import

        i, j = np.indices(shape)
        places = self._lower + side * (np.stack([i.ravel(), j.ravel()], axis=1) + 0.5)
        self._inside = inside(places).reshape(shape)
        self._reached = binary_dilation(self._inside, AROUND, iterations=SPREAD)

    def __bool__(self):
        """Whether the region has a cell."""
        return bool(self._inside.any())

    def box(self, more):
        """Lower and upper corner (2,) [m] of the box around the region, `more` cells wider on all sides."""
        cells = np.argwhere(self._inside)
        return (self._lower + self._side * (cells.min(axis=0) - more),
                self._lower + self._side * (cells.max(axis=0) + 1 + more))

    def _cells(self, plan):
        return np.floor((plan - self._lower) / self._side).astype(np.int64)

    def _of(self, mask, plan):
        cells = self._cells(plan)
        there = ((cells >= 0) & (cells < mask.shape)).all(axis=1)
        there[there] = mask[tuple(cells[there].T)]
        return there

    def entered(self, plan):
        """Whether places (n, 2) [m] lie in the region (n,)."""
        return self._of(self._inside, plan)

    def left(self, plan):
        """Whether places (n, 2) [m] lie beyond what is still held by it (n,)."""
        return ~self._of(self._reached, plan)

    def beside(self, plan, others):
        """Whether places (n, 2) [m] lie within `REACH` cells of one of the others (k, 2) (n,)."""
        if not len(plan) or not len(others):
            return np.zeros(len(plan), bool)
        from scipy.ndimage import binary_dilation

        cells, other = self._cells(plan), self._cells(others)
        low = cells.min(axis=0) - REACH
        shape = np.ptp(cells, axis=0) + 1 + 2 * REACH
        other = other[((other >= low) & (other < low + shape)).all(axis=1)] - low
        mask = np.zeros(shape, bool)
        mask[tuple(other.T)] = True
        return binary_dilation(mask, AROUND, iterations=REACH)[tuple((cells - low).T)]
