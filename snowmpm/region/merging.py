"""Single basins out of steep ground: neighbouring parts are merged while they face the same way.

Region growing by local mutual best fitting (Baatz and Schäpe, 2000): two parts merge if each is the best neighbour of
the other, and the merged part is not too unlike within itself. With U the sum of the downhill unit vectors of the cells
of a part, merging a and b costs

    (|U_a| + |U_b| - |U_a + U_b|) cell² (1 + RIDGE max(d, 0)) + SHAPE (s_a+b - s_a - s_b) cell²   [m2]

The first part is about a quarter of the area times the square of the angle between two parts of one size. d is the mean
over their common border of (u_b - u_a) · e, e from a to b: positive where the flow divides, on a ridge. The second part
is their compactness s = l sqrt(n), of n cells with a perimeter l in cell sides, without which parts of even slopes are
stripes. Merging ends where the least cost is above the scale, or the area above its largest. It does not depend on the
order of parts.
"""

from dataclasses import dataclass

import numpy as np

RIDGE = 4.0
"""How much more it costs to merge over a ridge than over a gully: chosen."""
SHAPE = 0.04
"""Weight of compactness: that of 23 degrees between two squares. Chosen."""


@dataclass
class Parts:
    """sums (n, k): by part: SIZE [cells], ROUND (perimeter) [cell sides], EAST, NORTH (of downhill unit vectors), and
    others that add up; edges (m, 2): pairs of neighbours, a < b; borders (m, 2): length of their border [cell sides],
    and the sum of (u_b - u_a) · e."""

    sums: np.ndarray
    edges: np.ndarray
    borders: np.ndarray


SIZE, ROUND, EAST, NORTH = range(4)


def costs(parts, cell):
    """Cost [m2] of each edge."""
    a, b = parts.edges.T
    one, other = parts.sums[a, EAST : NORTH + 1], parts.sums[b, EAST : NORTH + 1]
    loss = np.hypot(*one.T) + np.hypot(*other.T) - np.hypot(*(one + other).T)
    length, divides = parts.borders.T
    size, perimeter = parts.sums[:, SIZE], parts.sums[:, ROUND]
    shape = perimeter * np.sqrt(size)
    merged = (perimeter[a] + perimeter[b] - 2.0 * length) * np.sqrt(size[a] + size[b])
    return cell**2 * (np.maximum(loss, 0.0) * (1.0 + RIDGE * np.maximum(divides / length, 0.0))
                      + SHAPE * (merged - shape[a] - shape[b]))


def merge(parts, cell, scale, largest=np.inf):
    """Merge `Parts`; -> (merged `Parts`, number of the merged part of each one (n,)). scale [m2]: largest cost;
    largest: plan area [m2] of a part."""
    label = np.arange(len(parts.sums))
    while len(parts.edges):
        cost = costs(parts, cell)
        size = parts.sums[:, SIZE]
        a, b = parts.edges.T
        possible = (cost <= scale) & ((size[a] + size[b]) * cell**2 <= largest)
        if not possible.any():
            break
        partner = _best(len(parts.sums), a[possible], b[possible], cost[possible])
        mutual = np.flatnonzero((partner >= 0) & (partner[np.maximum(partner, 0)] == np.arange(len(partner))))
        new = np.arange(len(parts.sums))
        new[mutual] = np.minimum(mutual, partner[mutual])
        kept, new = np.unique(new, return_inverse=True)
        parts = _joined(parts, new, len(kept))
        label = new[label]
    return parts, label


def _best(n, a, b, cost):
    """The best neighbour of each of n parts, -1 of none; of equal ones the first."""
    node, other, price = np.concatenate([a, b]), np.concatenate([b, a]), np.concatenate([cost, cost])
    least = np.full(n, np.inf)
    np.minimum.at(least, node, price)
    first = np.full(n, n)
    best = price == least[node]
    # Of equal costs the pair with the lowest numbers, which is one pair to both of its parts
    pair = np.minimum(node, other)[best] * n + np.maximum(node, other)[best]
    lowest = np.full(n, np.iinfo(np.int64).max)
    np.minimum.at(lowest, node[best], pair)
    there = lowest < np.iinfo(np.int64).max
    low, high = np.divmod(lowest[there], n)
    index = np.flatnonzero(there)
    first[there] = np.where(low == index, high, low)
    return np.where(there, first, -1)


def _joined(parts, new, n):
    """`Parts` whose numbers are replaced by `new`, 0 to n - 1."""
    sums = np.stack([np.bincount(new, column, n) for column in parts.sums.T], axis=1)
    a, b = new[parts.edges].T
    within = a == b
    sums[:, ROUND] -= 2.0 * np.bincount(a[within], parts.borders[within, 0], n)
    return Parts(sums, *edges_of(a, b, parts.borders))


def edges_of(a, b, borders):
    """(edges, borders) of pairs of neighbours in any order, each once; those of one part with itself are left out."""
    apart = a != b
    a, b, borders = a[apart], b[apart], borders[apart]
    if not len(a):
        return np.empty((0, 2), np.int64), np.empty((0, 2))
    low, high = np.minimum(a, b), np.maximum(a, b)
    # (u_b - u_a) · e is the same from either side
    span = int(high.max()) + 1
    key, where = np.unique(low * span + high, return_inverse=True)
    summed = np.stack([np.bincount(where, column, len(key)) for column in borders.T], axis=1)
    return np.stack(np.divmod(key, span), axis=1), summed


def cells_as_parts(mask, down, others=()):
    """(`Parts` of one cell each, number (rows, columns) of the part of a cell, -1 outside of the mask).

    down (2, rows, columns): downhill unit vectors; others: further arrays (rows, columns) that are added up.
    """
    number = np.full(mask.shape, -1, np.int64)
    number[mask] = np.arange(np.count_nonzero(mask))
    n = np.count_nonzero(mask)
    sums = np.stack([np.ones(n), np.full(n, 4.0), *(one[mask] for one in (*down, *others))], axis=1)
    edges, borders = [], []
    for first, second, axis, sign in ((np.s_[:, :-1], np.s_[:, 1:], 0, 1.0), (np.s_[:-1], np.s_[1:], 1, -1.0)):
        both = mask[first] & mask[second]
        edges.append(np.stack([number[first][both], number[second][both]], axis=1))
        divides = sign * (down[axis][second][both] - down[axis][first][both])
        borders.append(np.stack([np.ones(len(divides)), divides], axis=1))
    return Parts(sums, *edges_of(*np.concatenate(edges).T, np.concatenate(borders))), number
