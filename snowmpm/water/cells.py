"""Cells of the grid that hold material: the control volumes of what flows through it.

Cell i of the grid reaches from node i to node i + 1. Its volume is that of the material in it, the sum of its
particles (Nøst 2019, Iteratively coupled implicit dynamic MPM-FVM, NTNU, eq. 7.2); faces and distances are those of the
grid.
"""

import numpy as np


class MaterialCells:
    """The cells that particles are in, in the order of their coordinates.

    coordinates (cells, dim): of each; of (n,): row of the cell of each particle. For each of the `faces` between two of
    them, first and second (faces,) are their rows and axis (faces,) its normal, from first to second. Each cell has 2
    dim faces; those with no material behind them are in border (rows), border_axis and border_sign (1: upper side).
    """

    def __init__(self, coordinates, period=None):
        """coordinates (n, dim): integer cell of each particle; period (dim,): cells after which an axis repeats, 0
        where it does not."""
        coordinates = np.asarray(coordinates, np.int64)
        dim = coordinates.shape[1]
        self.period = np.zeros(dim, np.int64) if period is None else np.asarray(period, np.int64)
        around = self.period > 0
        coordinates = np.where(around, coordinates % np.maximum(self.period, 1), coordinates)
        # One empty cell on each side, so that the neighbours of two cells never share a key
        low, size = np.zeros(dim, np.int64), np.ones(dim, np.int64)
        if len(coordinates):
            low = coordinates.min(axis=0) - 1
            size = coordinates.max(axis=0) - low + 2
        low, size = np.where(around, 0, low), np.where(around, self.period, size)
        stride = np.r_[np.cumprod(size[::-1])[-2::-1], 1].astype(np.int64)
        keys, self.of = np.unique((coordinates - low) @ stride, return_inverse=True)
        self.coordinates = low + (keys[:, None] // stride) % size
        first, second, axes, border, border_axis, border_sign = [], [], [], [], [], []
        for axis in range(dim):
            for sign in (1, -1):
                step = np.zeros(dim, np.int64)
                step[axis] = sign
                beyond = self.coordinates + step
                beyond = np.where(around, beyond % np.maximum(self.period, 1), beyond)
                wanted = (beyond - low) @ stride
                place = np.minimum(np.searchsorted(keys, wanted), max(0, len(keys) - 1))
                found = keys[place] == wanted if len(keys) else np.zeros(0, bool)
                if sign > 0:
                    first.append(np.flatnonzero(found))
                    second.append(place[found])
                    axes.append(np.full(found.sum(), axis))
                border.append(np.flatnonzero(~found))
                border_axis.append(np.full((~found).sum(), axis))
                border_sign.append(np.full((~found).sum(), sign))
        self.first, self.second, self.axis = (np.concatenate(part) for part in (first, second, axes))
        self.border, self.border_axis, self.border_sign = (
            np.concatenate(part) for part in (border, border_axis, border_sign))

    def __len__(self):
        return len(self.coordinates)

    @property
    def beyond(self):
        """Centre of the empty cell behind each border face, in cells, (faces, dim)."""
        centre = self.coordinates[self.border] + 0.5
        centre[np.arange(len(centre)), self.border_axis] += self.border_sign
        return centre

    def sums(self, values):
        """Sum of `values` (n,) over the particles of each cell, in their order."""
        return np.bincount(self.of, values, len(self))

    def mean(self, values, weights):
        """Mean of `values` (n,) over the particles of each cell by `weights` (n,) > 0 (Nøst 2019, eq. 7.4)."""
        return self.sums(values * weights) / self.sums(weights)
