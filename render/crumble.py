"""Loose snow as crumbs: a particle that few others surround is drawn as several smaller pieces, not as a ball."""

import numpy as np

CRUMBS = 9
"""Pieces of a particle."""

SIZE = 0.42
"""Radius of a piece, of that of a particle, in the mean: pieces are half to one and a half times as large."""

APART = 0.55
"""How far pieces lie from the middle of their particle, at most, in spacings along each axis."""

VISIBLE = 0.8
"""Radius of a particle on the picture [px] from which pieces can be told."""

LOOSE = 90
"""Particles in three cells each way around one below which it is loose; 96 at the edge of a block, of 216."""


def few_around(points, spacing, least=LOOSE):
    """Which particles (n,) have fewer than `least` in the cube of three cells, each two spacings wide, around them."""
    cell = np.floor((points - points.min(axis=0, initial=np.inf)) / (2.0 * spacing)).astype(np.int64).clip(0, 1 << 20)
    strides = np.array([1 << 42, 1 << 21, 1], np.int64)
    keys, place, counts = np.unique(cell @ strides, return_inverse=True, return_counts=True)
    # Most cells hold as many by themselves: only the others look around
    few = np.flatnonzero(counts < least)
    total = np.full(len(keys), least, np.int64)
    total[few] = 0
    for step in np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3):
        there = keys[few] + step @ strides
        at = np.searchsorted(keys, there).clip(0, len(keys) - 1)
        total[few] += np.where(keys[at] == there, counts[at], 0)
        few = few[total[few] < least]
    return (total < least)[place]


def crumbled(points, spacing, loose, *others):
    """Points (n, 3) with those that are loose (n,) taken apart; spacing: between particles [m], one or (n,).

    -> points (m, 3), spacing (m,) that pieces are drawn by, and each of the others (n, ...), or None, row by row. The
    places of pieces follow from the identity of their particle, the first of the others, or from where it lies if it
    has none: what rests does not flicker.
    """
    spacing = np.broadcast_to(np.asarray(spacing, float), len(points))
    which = np.flatnonzero(loose)
    known = bool(others) and others[0] is not None
    offsets = _noise(others[0][which] if known else _place(points[which] / spacing[which, None]), 4)
    pieces = points[which][:, None] + APART * spacing[which, None, None] * (2.0 * offsets[..., :3] - 1.0)
    sizes = SIZE * (0.5 + offsets[..., 3]) * spacing[which, None]
    whole = np.flatnonzero(~loose)
    rows = np.concatenate([whole, np.repeat(which, CRUMBS)])
    return (np.concatenate([points[whole], pieces.reshape(-1, 3)]), np.concatenate([spacing[whole], sizes.ravel()]),
            *(None if other is None else other[rows] for other in others))


STILL = 0.2
"""Spacings that a particle without identity may move without other pieces."""


def _place(points):
    """A whole number (k,) for the small cube that each of the points (k, 3) [spacings] lies in."""
    cubes = np.round(points / STILL).astype(np.int64)
    return cubes @ np.array([73856093, 19349663, 83492791])


def _noise(seeds, n):
    """Numbers in [0, 1) (k, CRUMBS, n) that belong to whole numbers (k,): the same for the same, in every frame."""
    state = seeds.astype(np.uint64)[:, None] * np.uint64(CRUMBS * n) + np.arange(CRUMBS * n, dtype=np.uint64)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):  # splitmix64
        state = (state ^ (state >> np.uint64(shift))) * np.uint64(factor)
    state ^= state >> np.uint64(31)
    return ((state >> np.uint64(11)).astype(float) * 2.0**-53).reshape(-1, CRUMBS, n)
