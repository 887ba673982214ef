"""Points that fill a box uniformly: lattice, jittered lattice, Poisson discs."""

import numpy as np

from snowmpm import memory

JITTER = 0.25  # largest shift in lattice spacings: neighbours stay at least half a spacing apart
# First diameter of random discs by dimension, in mean spacings; they saturate at 0.75, 0.83 and 0.90, but ever more
# slowly.
DIAMETERS = {1: 0.6, 2: 0.7, 3: 0.7}
POINT_BYTES = 80  # while they are made and those outside are taken out
SAMPLINGS = ("regular", "jittered", "poisson")


def unit_points(counts, sampling, rng):
    """Points (prod(counts), d) in the box from 0 to counts, one per unit volume on average, in units of the spacing.

    regular: centres of the unit cells, last axis fastest; jittered: each moved by at most a quarter in each direction;
    poisson: random with a least distance (random sequential discs). An axis with one cell keeps its centre under
    `poisson`. InputError: more points than fit in memory.
    """
    memory.require(POINT_BYTES * np.prod(np.asarray(counts, float)), "shape: its lattice of points")
    counts = np.asarray(counts, int)
    if sampling == "poisson":
        return _poisson(counts, rng)
    axes = [np.arange(n) + 0.5 for n in counts]
    points = np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)
    if sampling == "jittered":
        points += rng.uniform(-JITTER, JITTER, points.shape)
    return points


def sub_layers(bottom, top, spacing, dim):
    """Division of a layer: number of sub-layers, their thickness [m], and the spacing [m] of points along each.

    Sub-layers are about `spacing` thick. If they are thicker, points are closer together along the layer, so that no
    point represents more than spacing^dim. If they are thinner, a point represents less, and no gaps open.
    """
    n = max(round((top - bottom) / spacing), 1)
    thickness = (top - bottom) / n
    return n, thickness, spacing * min(1.0, spacing / thickness) ** (1.0 / (dim - 1))


def _poisson(counts, rng):
    total = int(np.prod(counts))
    wide = counts > 1
    points = np.tile(0.5 * counts, (total, 1))
    if wide.any():
        points[:, wide] = _discs(counts[wide].astype(float), total, rng)
    return points


def _discs(size, total, rng):
    """`total` points in the box (0, size) of volume `total`, no two nearer than a diameter that shrinks as needed."""
    from scipy.spatial import cKDTree  # slow to import, and not needed by other samplings

    diameter = DIAMETERS[len(size)]
    kept = np.empty((0, len(size)))
    while len(kept) < total:
        missing = total - len(kept)
        trial = rng.random((max(missing, total // 2, 64), len(size))) * size
        if len(kept):
            trial = trial[np.isinf(cKDTree(kept).query(trial, distance_upper_bound=diameter)[0])]
        if len(trial):
            pairs = cKDTree(trial).query_pairs(diameter, output_type="ndarray")
            trial = np.delete(trial, np.unique(pairs[:, 1]), axis=0)
        if len(trial) < 0.02 * missing:
            diameter *= 0.97
        kept = np.concatenate([kept, trial[:missing]])
    return kept
