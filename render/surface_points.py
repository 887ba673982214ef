"""The snow of a frame as points of its surface with normals: few enough to send, dense enough to look like snow."""

from dataclasses import dataclass

import numpy as np

NEIGHBOURS = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
NEIGHBOURS = NEIGHBOURS[(NEIGHBOURS != 0).any(axis=1)]
OPEN_SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))  # not below: there is the ground
BITS = 20  # of a cell number along each axis


@dataclass(frozen=True)
class SurfacePoints:
    """points (n, 3) [m], unit normals (n, 3) out of the snow, values (n,)."""

    points: np.ndarray
    normals: np.ndarray
    values: np.ndarray


def surface_points(points, values, cell, flat=False):
    """One point for each occupied cell [m] that has an empty one beside or above it: the mean of its particles.

    points (n, 3), values (n,); flat: a section in x and z, all of whose cells are seen, from -y.
    """
    good = np.isfinite(points).all(axis=1)
    points, values = points[good], np.asarray(values, np.float32)[good]
    if not len(points):
        return SurfacePoints(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), np.zeros(0, np.float32))
    grid = np.floor((points - points.min(axis=0)) / cell).astype(np.int64) + 2
    keys, place, counts = np.unique(_key(grid), return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(place, points[:, k]) for k in range(3)], axis=-1) / counts[:, None]
    share = np.bincount(place, values) / counts
    if flat:
        return SurfacePoints(mean.astype(np.float32), np.tile(np.float32([0.0, -1.0, 0.0]), (len(mean), 1)),
                             share.astype(np.float32))
    open_side = np.zeros(len(keys), bool)
    for step in OPEN_SIDES:
        open_side |= ~_occupied(keys, keys + _key(np.array(step)))
    seen = keys[open_side]
    normals = np.zeros((len(seen), 3), np.float32)
    for step in NEIGHBOURS:
        normals -= _occupied(keys, seen + _key(step))[:, None] * (step / np.linalg.norm(step)).astype(np.float32)
    normals = _evened(seen, normals)
    return SurfacePoints(mean[open_side].astype(np.float32), normals, share[open_side].astype(np.float32))


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
