"""Ways of the snow down a map: to each cell the one that took least time, and where along them the snow lies.

A way goes over cells that snow touched. Its time is that at the peak speeds of the maps, with these weights, which
decide between branches and keep ways off the rim of the flow:

    speed       at least `LEAST` of the largest one where the flow was deep enough, `DRY` of it elsewhere
    climb       a metre of it takes as long as `CLIMB` metres of way
    backwards   a step to a cell that the flow reached earlier takes `BACK` times as long

Lengths are those in plan. With steps in 32 directions they are up to 1.3 % too long; a line that is `straightened` is
not.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

LEAST, DRY, CLIMB, BACK = 0.02, 0.002, 5.0, 3.0

REACH, MOST = 3, 100_000
"""Cells that a step spans at most, and touched cells beyond which it spans one less: steps are many."""

SLACK = 2.0
"""Times in which the mean speed crosses a cell, by which an arrival may be earlier without being backwards."""

ASIDE = 0.05
"""Share of all the fall by which a place may lie above the lowest one of its way. Snow that lies higher came from
another release, whose own way was another: it counts where it joined."""

EVEN = 1e-3
"""Share by which a straight piece may take longer than the turns that it replaces."""

NEAR = 0.75
"""Cells before and behind the run-out that count as its cross-section."""


@dataclass(frozen=True)
class Ways:
    """Ways to cells (n, 2): before (n,): the cell before on the way, -1 of none; length (n,) [m], inf: no way; lowest
    (n,) [m]: height of the lowest cell of the way; lowest_length (n,) [m]: length there."""

    cells: np.ndarray
    before: np.ndarray
    length: np.ndarray
    lowest: np.ndarray
    lowest_length: np.ndarray

    def to(self, k):
        """Numbers of the cells on the way to the k-th, from the first on."""
        found = [int(k)]
        while self.before[found[-1]] >= 0:
            found.append(int(self.before[found[-1]]))
        return np.array(found[::-1])


@dataclass(frozen=True)
class Cells:
    """Maps (columns, rows) of a flow: touched and affected, speed [m/s], arrival [s], height [m]; side of a cell [m].
    """

    touched: np.ndarray
    affected: np.ndarray
    speed: np.ndarray
    arrival: np.ndarray
    height: np.ndarray
    side: float


def ways_down(cells, starts):
    """`Ways` over `Cells` from cells (k, 2), the most important first: in each connected part of the touched cells
    from the first of them that lies in it."""
    places = np.argwhere(cells.touched)
    number = np.full(cells.touched.shape, -1)
    number[cells.touched] = np.arange(len(places))
    graph = _graph(cells, places, number)
    part = connected_components(graph, directed=False)[1]
    begin = number[tuple(np.transpose(starts))]
    begin = begin[np.sort(np.unique(part[begin], return_index=True)[1])]
    time, before, _ = dijkstra(graph, indices=begin, min_only=True, return_predecessors=True)
    return _followed(places, np.where(before < 0, -1, before), np.isfinite(time), cells)


def _graph(cells, places, number):
    """Times of all steps between touched cells, sparse (n, n); without unit."""
    flowing, slowness = cells.speed[cells.affected], _slowness(cells)
    slack = SLACK * cells.side / max(float(flowing.mean()) if flowing.size else 1.0, 1e-12)
    rows, columns, times = [], [], []
    for step in _steps(REACH if len(places) <= MOST else REACH - 1):
        to = places + step
        inside = ((to >= 0) & (to < number.shape)).all(axis=1)
        inside[inside] = number[tuple(to[inside].T)] >= 0
        a, b = tuple(places[inside].T), tuple(to[inside].T)
        samples = 2 * int(np.abs(step).max()) + 1
        slow = np.mean([slowness[tuple(np.rint(places[inside] + share * step).astype(int).T)]
                        for share in np.linspace(0.0, 1.0, samples)], axis=0)
        slow *= np.where(cells.arrival[b] < cells.arrival[a] - slack, BACK, 1.0)
        climb = np.maximum(cells.height[b] - cells.height[a], 0.0)
        rows.append(number[a])
        columns.append(number[b])
        times.append(slow * (cells.side * np.hypot(*step) + CLIMB * climb))
    where = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(times), where), shape=(len(places),) * 2)


def _slowness(cells):
    """Time that a metre takes in each cell, over that at the largest speed."""
    largest = float(cells.speed[cells.affected].max(initial=0.0)) or 1.0
    return 1.0 / np.where(cells.affected, np.clip(cells.speed / largest, LEAST, 1.0), DRY)


def straightened(line, cells):
    """A way (n, 2) over cells, without the turns that it owes to its few directions alone: straight where that takes no
    longer and climbs no more. Seen from its end or from its begin, whichever is shorter: around a corner only one of
    them lies close."""
    if len(line) < 3:
        return line
    slowness = _slowness(cells)

    def costs(a, b):
        """Time and climb of a straight piece."""
        share = np.linspace(0.0, 1.0, 2 * int(np.abs(b - a).max()) + 1)[:, None]
        at = tuple(np.rint(a + share * (b - a)).astype(int).T)
        if not cells.touched[at].all():
            return np.full(2, np.inf)
        climb = float(np.maximum(np.diff(cells.height[at]), 0.0).sum())
        return np.array([slowness[at].mean() * cells.side * float(np.linalg.norm(b - a)) + CLIMB * climb, climb])

    each = [costs(a, b) for a, b in itertools.pairwise(line)]
    behind = np.concatenate([np.zeros((1, 2)), np.cumsum(each, axis=0)])

    def even(i, j):
        """Whether the way between two of its points may be straight."""
        return bool((costs(line[i], line[j]) <= (1.0 + EVEN) * (behind[j] - behind[i]) + 1e-9).all())

    last = len(line) - 1
    forward = line[_seen(len(line), even)]
    back = line[last - _seen(len(line), lambda i, j: even(last - j, last - i))][::-1]
    return min(forward, back, key=lambda one: np.linalg.norm(np.diff(one, axis=0), axis=1).sum())


def _seen(n, straight):
    """Numbers of the points of a way that are kept: from each the furthest to which it may be straight(i, j)."""
    kept = [0]
    while kept[-1] < n - 1:
        i, best, stride = kept[-1], kept[-1] + 1, 2
        while i + stride - stride // 4 < n:
            j = min(i + stride, n - 1)
            best = j if straight(i, j) else best
            stride += max(1, stride // 4)
        kept.append(best)
    return np.array(kept)


def _steps(reach):
    """Steps (k, 2) to cells at most so far away, one in each direction."""
    span = range(-reach, reach + 1)
    return np.array([(i, j) for i in span for j in span if np.gcd(i, j) == 1])


def _followed(places, before, known, cells):
    """`Ways` of the cell before each, by doubling."""
    n, height = len(places), cells.height[cells.touched]
    up = np.where(before < 0, np.arange(n), before)
    length = cells.side * np.linalg.norm(places - places[up], axis=1)
    low = np.arange(n)
    while True:
        low = np.where(height[low[up]] < height[low], low[up], low)
        length, further = length + length[up], up[up]
        if (further == up).all():
            break
        up = further
    return Ways(places, before, np.where(known, length, np.inf), height[low], np.where(known, length[low], np.inf))


def end_of(ways, cells, snow, deposited, share):
    """Number of the cell at which so large a share of the snow (n,) lies behind, along the ways: of the deposited cells
    (n,) in that cross-section, in the middle of the tongue with the most snow. None where no cell is deposited."""
    height = cells.height[cells.touched]
    known = np.isfinite(ways.length)
    aside = height - ways.lowest > ASIDE * float(np.ptp(height))
    length = np.where(aside, ways.lowest_length, ways.length)
    lies = np.flatnonzero(known & ~aside & deposited)
    if not len(lies):
        return None
    order = np.flatnonzero(known)[np.argsort(length[known], kind="stable")]
    behind = np.cumsum(snow[order])
    most = float(np.interp(share * behind[-1], behind, length[order]))
    off = np.abs(length[lies] - most)
    return _middle(ways.cells, lies[off <= max(NEAR * cells.side, float(off.min()))], snow, cells.touched.shape)


def _middle(places, there, snow, shape):
    """Of the cells `there` (numbers), the one in the middle of the tongue that has the most snow."""
    mask = np.zeros(shape, bool)
    mask[tuple(places[there].T)] = True
    tongue = label(mask, np.ones((3, 3)))[0][tuple(places[there].T)]
    there = there[tongue == np.bincount(tongue, weights=snow[there]).argmax()]
    weight = snow[there] + 1e-300
    middle = weight @ places[there] / weight.sum()
    return int(there[np.linalg.norm(places[there] - middle, axis=1).argmin()])
