"""Dummy particles inside solids, seeded from a signed distance: layers below the surface, about one cell apart.

Points of a lattice of half a cell near the surface are brought onto it, and thinned, so that none are nearer than
SPACING to each other: at a surface along the axes what is left is the lattice of the particles. Below each of them lie
the dummies, half a cell deep, one and a half, and so on, as many as the support reaches; those whose nearest piece of
surface is another one are left out. Each stands for the area that it has on its layer.

All lengths are cells.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError

STEP = 0.5
COARSE = 4.0
SPACING = 0.85
OWN = 0.25
"""How much nearer than its depth another piece of the surface may be."""
LARGEST_SHARE = 1.5
MOST_BOXES = 1e7
"""A search of a minute."""
WHAT, REMEDY = "dummy particles of SPH in the ground and in obstacles", "a smaller obstacle or domain needs less"
BOXES = 200
"""Of COARSE cells that are searched at a time: all those of a whole valley would take gigabytes."""
BATCH = 20_000
"""Points whose neighbours are listed at a time: of a whole valley there are tens of millions of pairs."""


@dataclass
class Dummies:
    """positions (n, dim), outward normals (n, dim), depth (n,) below the surface, volume (n,), surface (n,)."""

    positions: np.ndarray
    normals: np.ndarray
    depth: np.ndarray
    volume: np.ndarray
    surface: np.ndarray

    def __len__(self):
        return len(self.depth)

    def chosen(self, keep):
        """Those with keep (n,) true, or in this order."""
        return Dummies(*(vars(self)[name][keep] for name in ("positions", "normals", "depth", "volume", "surface")))

    @classmethod
    def joined(cls, parts, dim):
        """All of them together."""
        parts = [*parts, cls(np.zeros((0, dim)), np.zeros((0, dim)), np.zeros(0), np.zeros(0), np.zeros(0, int))]
        return cls(*(np.concatenate([vars(part)[name] for part in parts])
                     for name in ("positions", "normals", "depth", "volume", "surface")))


def seed_dummies(query, lower, upper, layers, surface, lengths):
    """Dummies of one solid: query(points (k, dim)) -> distance (k,), > 0 outside, normal (k, dim); lower, upper: the
    box in which its surface matters; lengths (dim,): after which it comes again, 0 where it does not."""
    feet = _surface_points(query, np.asarray(lower, float), np.asarray(upper, float))
    dim = feet.shape[1]
    if len(feet) == 0:
        return Dummies.joined([], dim)
    _, normals = query(feet)
    share = _shares(feet, lengths)
    parts = []
    for layer in range(layers):
        depth = layer + 0.5
        points = feet - depth * normals
        distance, _ = query(points)
        own = np.abs(distance + depth) < OWN
        parts.append(Dummies(points[own], normals[own], np.full(own.sum(), depth), share[own],
                             np.full(own.sum(), surface)))
    return Dummies.joined(parts, dim)


def _surface_points(query, lower, upper):
    dim = len(lower)
    boxes = float(np.prod(np.floor((upper - lower) / COARSE) + 2.0))
    if boxes > MOST_BOXES:
        raise InputError(f"{WHAT}: {boxes:.2g} boxes of {COARSE:g} cells to search; {REMEDY}")
    memory.require(100.0 * dim * boxes, WHAT, REMEDY)
    coarse = _lattice(np.floor(lower / COARSE) * COARSE, upper, COARSE) + 0.5 * COARSE
    distance, _ = query(coarse)
    coarse = coarse[np.abs(distance) < 0.5 * COARSE * np.sqrt(dim) + 1.0]
    memory.require(100.0 * dim * len(coarse) * (COARSE / STEP) ** (dim - 1), WHAT, REMEDY)
    fine = _lattice(np.full(dim, -0.5 * COARSE), np.full(dim, 0.5 * COARSE - STEP), STEP)
    parts = [_feet(query, coarse[i : i + BOXES], fine, lower, upper) for i in range(0, len(coarse), BOXES)]
    if not sum(len(part[0]) for part in parts):
        return np.zeros((0, dim))
    feet, points, distance = (np.concatenate(one) for one in zip(*parts, strict=True))
    del parts
    halves = (np.abs(points - np.floor(points) - 0.5) < 1e-6).sum(axis=1, dtype=np.int8)
    feet = feet[np.lexsort((*points.T[::-1], distance, -halves))]
    return feet[_apart(feet, SPACING)]


def _feet(query, coarse, fine, lower, upper):
    """Points of the surface next to those of the fine lattice in these boxes that lie near it; these points, and how
    far away they were. Halves of cells need no float64: of a whole valley there are millions."""
    points = (coarse[:, None] + fine).reshape(-1, coarse.shape[1])
    points = points[((points > lower - 0.5 * STEP) & (points < upper + 0.5 * STEP)).all(axis=1)]
    distance, normal = query(points)
    near = np.abs(distance) <= 0.6 * STEP
    points, distance, normal = points[near], distance[near], normal[near]
    feet = points - distance[:, None] * normal
    left, normal = query(feet)
    return feet - left[:, None] * normal, points.astype(np.float32), np.round(np.abs(distance), 6)


def _lattice(lower, upper, step):
    axes = [np.arange(lo, hi + 1e-9, step) for lo, hi in zip(lower, upper, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _apart(points, least):
    """Which points stay when they are taken in order, and none that is nearer than `least` to one taken before."""
    from scipy.spatial import cKDTree

    least, kept = least * (1.0 - 1e-9), np.zeros(len(points), bool)
    for begin in range(0, len(points), BATCH):
        batch = np.arange(begin, min(begin + BATCH, len(points)))
        if kept.any():
            batch = batch[~np.isfinite(cKDTree(points[kept]).query(points[batch], distance_upper_bound=least)[0])]
        kept[batch] = _first_taken(len(batch), cKDTree(points[batch]).query_pairs(least, output_type="ndarray"))
    return kept


def _first_taken(n, pairs):
    """Which of n stay when they are taken in order, and none of a pair (m, 2) whose other one was taken before."""
    pairs.sort(axis=1)
    first, second = pairs.T
    kept, open_ = np.zeros(n, bool), np.ones(n, bool)
    while open_.any():
        live = open_[first] & open_[second]
        first, second = first[live], second[live]
        waits = np.zeros(n, bool)
        waits[second] = True
        fresh = open_ & ~waits
        kept |= fresh
        open_ &= ~fresh
        open_[second[fresh[first]]] = False
    return kept


def _shares(points, lengths):
    """Area that each point of a surface stands for, 1 on a square lattice. lengths (dim,): after which it comes again
    along each axis, 0 where it does not."""
    from scipy.spatial import cKDTree

    around, (n, dim) = 2.5, points.shape

    def weight(r):
        s = np.minimum(r / around, 1.0)
        return (1.0 - s) ** 4 * (1.0 + 4.0 * s)

    whole = points
    for axis in np.flatnonzero(lengths):
        shift = np.zeros(dim)
        shift[axis] = lengths[axis]
        x = whole[:, axis]
        whole = np.concatenate([whole, whole[x < x.min() + around] + shift, whole[x > x.max() - around] - shift])
    tree, found = cKDTree(whole), np.empty(n)
    for begin in range(0, n, BATCH):
        some = points[begin : begin + BATCH]
        near = cKDTree(some).sparse_distance_matrix(tree, around, output_type="ndarray")
        found[begin : begin + BATCH] = np.bincount(near["i"], weight(near["v"]), len(some))
    lattice = _lattice(np.full(dim - 1, -3.0), np.full(dim - 1, 3.0), 1.0)
    return np.minimum(weight(np.linalg.norm(lattice, axis=1)).sum() / found, LARGEST_SHARE)
