"""Columns of snow spread over a lattice in plan, as their method spreads them over the nodes of its grid.

A column of volume V at x gives the lattice point x_l the share N((x_l - x) / dx) / m^2, with the quadratic B-spline N
of the plan grid of spacing dx in both directions, and a lattice of spacing dx / m. Splines of whole shifts add up to 1
and reproduce places, so that over each of the m^2 lattices of spacing dx, and so over all, mass, centre of mass and
momentum are those of the column.
"""

import numpy as np

from snowmpm import memory
from snowmpm.handover.heaps import Heaps


def spread(columns, corner, dx, m, ground):
    """`Heaps` on the points corner + (i + 1/2) dx / m of a lattice, of the columns (`Heaps`, of one body); a column
    whose spline reaches where there is no ground stays as it is. -> (on the lattice, as they were)

    ground: places (k, 2) [m] -> heights (k,) [m], NaN where there is none.
    """
    spacing = dx / m
    at = (columns.plan - corner) / spacing - 0.5
    first = np.ceil(at - 1.5 * m).astype(np.int64)
    low, high = first.min(axis=0), first.max(axis=0) + 3 * m + 1
    shape = high - low
    memory.require(8.0 * (6 + columns.velocity.shape[1] + columns.more.shape[1]) * shape.prod(),
                   "switch: the snow on the lattice of its particles")
    offsets = np.arange(3 * m + 1)
    weight = _spline((first[:, None, :] + offsets[:, None] - at[:, None, :]) / m) / m
    number = ((first - low) @ np.array([shape[1], 1]))[:, None]

    def each():
        """(points (n, 3 m + 1), share of each column that they get) row by row."""
        for i in offsets:
            yield number + i * shape[1] + offsets, weight[:, i, 0, None] * weight[:, :, 1]

    there = np.zeros(shape.prod(), bool)
    for points, share in each():
        there[points[share > 0.0]] = True
    rows = np.flatnonzero(there)
    places = corner + spacing * (np.stack(np.divmod(rows, shape[1]), axis=1) + low + 0.5)
    lost = np.zeros(shape.prod(), bool)
    lost[rows] = np.isnan(ground(places))
    stays = np.zeros(len(columns), bool)
    for points, share in each():
        stays |= (lost[points] & (share > 0.0)).any(axis=1)
    carried = np.column_stack([np.ones(len(columns)), columns.velocity, columns.more])
    sums = np.zeros((shape.prod(), carried.shape[1]))
    moves = ~stays
    for points, share in each():
        volume = share[moves] * columns.volume[moves, None]
        for k, values in enumerate(carried[moves].T):
            np.add.at(sums[:, k], points[moves].ravel(), (volume * values[:, None]).ravel())
    filled = sums[rows, 0] > 0.0
    rows, places = rows[filled], places[filled]
    means = sums[rows, 1:] / sums[rows, :1]
    n = columns.velocity.shape[1]
    heaps = Heaps(places, sums[rows, 0], means[:, :n], means[:, n:], np.full(len(rows), columns.body[0]))
    return heaps, columns.chosen(stays)


def _spline(u):
    """Quadratic B-spline at distances u [cells]."""
    u = np.abs(u)
    return np.where(u <= 0.5, 0.75 - u * u, 0.5 * np.maximum(0.0, 1.5 - u) ** 2)
