"""The snow of a frame as points of its surface with normals: few enough to send, dense enough to look like snow."""

from dataclasses import dataclass

import numpy as np

NEIGHBOURS = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
NEIGHBOURS = NEIGHBOURS[(NEIGHBOURS != 0).any(axis=1)]
OPEN_SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))  # not below: there is the ground
BITS = 20  # of a cell number along each axis


@dataclass(frozen=True)
class SurfacePoints:
    """Points (n, 3) [m] and values (n,) or (n, fields) of cells of snow.

    normals (seen, 3): unit, out of the snow. The first `seen` points are the surface, the others lie within.
    """

    points: np.ndarray
    normals: np.ndarray
    values: np.ndarray


def surface_points(points, values, cell, flat=False, within=False):
    """One point for each occupied cell [m] that has an empty one beside or above it: the mean of its particles.

    points (n, 3), values (n,) or (n, fields); flat: a section in x and z, all of whose cells are seen, from -y;
    within: the other cells too, after them.
    """
    good = np.isfinite(points).all(axis=1)
    points, values = points[good], np.asarray(values, np.float32)[good]
    if not len(points):
        nothing = np.zeros((0, 3), np.float32)
        return SurfacePoints(nothing, nothing, values)
    grid = np.floor((points - points.min(axis=0)) / cell).astype(np.int64) + 2
    keys, place, counts = np.unique(_key(grid), return_inverse=True, return_counts=True)
    mean = _means(points, place, counts)
    share = _means(values.reshape(len(values), -1), place, counts).reshape(len(keys), *values.shape[1:])
    if flat:
        return SurfacePoints(mean, np.tile(np.float32([0.0, -1.0, 0.0]), (len(mean), 1)), share)
    open_side = np.zeros(len(keys), bool)
    for step in OPEN_SIDES:
        open_side |= ~_occupied(keys, keys + _key(np.array(step)))
    seen = keys[open_side]
    normals = np.zeros((len(seen), 3), np.float32)
    for step in NEIGHBOURS:
        normals -= _occupied(keys, seen + _key(step))[:, None] * (step / np.linalg.norm(step)).astype(np.float32)
    normals = _evened(seen, normals)
    order = np.flatnonzero(open_side)
    if within:
        order = np.concatenate([order, np.flatnonzero(~open_side)])
    return SurfacePoints(mean[order], normals, share[order])


def _means(values, place, counts):
    sums = [np.bincount(place, values[:, k], len(counts)) for k in range(values.shape[1])]
    return (np.stack(sums, axis=-1) / counts[:, None]).astype(np.float32)


def _evened(keys, normals):
    """Normals averaged with those of the cells around, so that the steps of the cells do not show; none looks down."""
    total = normals.copy()
    for step in NEIGHBOURS:
        there = keys + _key(step)
        at = np.searchsorted(keys, there).clip(0, len(keys) - 1)
        total += np.where((keys[at] == there)[:, None], normals[at], 0.0)
    # Snow one cell thick is open on both sides: what is seen of it is its upper one
    total[:, 2] = np.abs(total[:, 2]) + 0.3 * np.linalg.norm(total, axis=1) + 1e-3
    return (total / np.linalg.norm(total, axis=1, keepdims=True)).astype(np.float32)


def _key(cells):
    cells = np.asarray(cells, np.int64)
    return (cells[..., 0] << 2 * BITS) + (cells[..., 1] << BITS) + cells[..., 2]


def _occupied(keys, there):
    return keys[np.searchsorted(keys, there).clip(0, len(keys) - 1)] == there
