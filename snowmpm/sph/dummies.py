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
WIDE = 2.5
"""Distance within which points share the area of a surface."""
MOST_BOXES = 1e7
"""A search of a minute."""
WHAT, REMEDY = "dummy particles of SPH in the ground and in obstacles", "a smaller obstacle or domain needs less"
BOXES = 200
"""Of COARSE cells that are searched at a time: all those of a whole valley would take gigabytes."""


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
        return Dummies(*(getattr(self, name)[keep] for name in ("positions", "normals", "depth", "volume", "surface")))

    @classmethod
    def joined(cls, parts, dim):
        """All of them together."""
        parts = [*parts, cls(np.zeros((0, dim)), np.zeros((0, dim)), np.zeros(0), np.zeros(0), np.zeros(0, int))]
        return cls(*(np.concatenate([getattr(part, name) for part in parts])
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
    parts = [_near_surface(query, coarse[i : i + BOXES], fine, lower, upper) for i in range(0, len(coarse), BOXES)]
    if not sum(len(part[0]) for part in parts):
        return np.zeros((0, dim))
    points, distance, normal = (np.concatenate(one) for one in zip(*parts, strict=True))
    halves = (np.abs(points - np.floor(points) - 0.5) < 1e-6).sum(axis=1)
    order = np.lexsort((*points.T[::-1], np.round(np.abs(distance), 6), -halves))
    feet = points - distance[:, None] * normal
    distance, normal = query(feet)
    feet = (feet - distance[:, None] * normal)[order]
    return feet[_apart(feet, SPACING)]


def _near_surface(query, coarse, fine, lower, upper):
    """Points of the fine lattice in these boxes that lie near the surface, their distance and normal."""
    points = (coarse[:, None] + fine).reshape(-1, coarse.shape[1])
    points = points[((points > lower - 0.5 * STEP) & (points < upper + 0.5 * STEP)).all(axis=1)]
    distance, normal = query(points)
    near = np.abs(distance) <= 0.6 * STEP
    return points[near], distance[near], normal[near]


def _lattice(lower, upper, step):
    axes = [np.arange(lo, hi + 1e-9, step) for lo, hi in zip(lower, upper, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _apart(points, least):
    """Which points stay when they are taken in order, and none that is nearer than `least` to one taken before."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(least * (1.0 - 1e-9), output_type="ndarray")
    pairs.sort(axis=1)  # in place: of a whole valley there are ten millions
    first, second = pairs.T
    if len(pairs) == 0:
        return np.ones(len(points), bool)
    kept, open_ = np.zeros(len(points), bool), np.ones(len(points), bool)
    while open_.any():
        live = open_[first] & open_[second]
        first, second = first[live], second[live]
        waits = np.zeros(len(points), bool)
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

    def weight(r):
        s = np.minimum(r / WIDE, 1.0)
        return (1.0 - s) ** 4 * (1.0 + 4.0 * s)

    n, dim = points.shape
    for axis in np.flatnonzero(lengths):
        shift = np.zeros(dim)
        shift[axis] = lengths[axis]
        x = points[:, axis]
        points = np.concatenate([points, points[x < x.min() + WIDE] + shift, points[x > x.max() - WIDE] - shift])
    pairs = cKDTree(points).query_pairs(WIDE, output_type="ndarray")
    found = np.ones(len(points))
    if len(pairs):
        w = weight(np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1))
        found += np.bincount(pairs[:, 0], w, len(points)) + np.bincount(pairs[:, 1], w, len(points))
    found = found[:n]
    lattice = _lattice(np.full(dim - 1, -3.0), np.full(dim - 1, 3.0), 1.0)
    return np.minimum(weight(np.linalg.norm(lattice, axis=1)).sum() / found, LARGEST_SHARE)
