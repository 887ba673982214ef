"""The part of an obstacle's face that snow touches.

Face: the facets whose outward normal is against the load, seen along it. It is cut into pieces about half a particle
spacing large. Snow touches where particles are closer to the face than `REACH`; a piece is wet where such a particle,
seen along the load, is within `COVER` of it:

    A_wet = sum of |n . d| a over the wet pieces

Both lengths are of the order of a cell. The edge of the wet part is therefore known to about half a particle spacing.
"""

import numpy as np
from scipy.spatial import cKDTree

REACH = 2.0
"""Distance from the face, in particle spacings, within which snow touches it: a cell, where it has two a side."""

COVER = 0.75
"""Radius that a particle covers of the face, in particle spacings: a square lattice leaves no gap from 0.71 on."""

PIECES = 40_000
"""Approximate largest number of pieces of a face: a larger face has coarser pieces."""

ALONG = 1000
"""Largest number of pieces along the longest side of an obstacle, even of a very thin one."""


class Face:
    """The part of a closed body that faces a load.

    centres (k, 3) [m], where the body is drawn; areas (k,) [m2] of its pieces seen along the load, [m] in 2-D; area:
    their sum; piece [m]: their size.
    """

    def __init__(self, vertices, facets, direction, spacing):
        """vertices (n, 3) [m], facets (m, 3) triangles, or (m, 2) segments in the plane (x, z); direction (3,): unit,
        of the load; spacing [m]: of particles."""
        corners, against = facing(np.asarray(vertices, float), facets, direction)
        self.area = float(against.sum())
        extent = float(np.ptp(vertices, axis=0).max())
        self.piece = max(0.5 * spacing, extent / ALONG, np.sqrt(self.area / PIECES) if facets.shape[1] == 3 else 0.0)
        corners, self.areas = bisected(corners, against, self.piece)
        self.centres = corners.mean(axis=1)

    def wet(self, centres, direction, particles, spacing):
        """Area [m2] that particles (n, 3) [m] touch; centres (k, 3) [m]: of the pieces, where they are now."""
        if not len(centres) or not np.isfinite(centres).all():
            return 0.0
        reach = REACH * spacing + 0.5 * self.piece
        lower, upper = centres.min(axis=0) - reach, centres.max(axis=0) + reach
        near = particles[((particles >= lower) & (particles <= upper)).all(axis=1)]
        if not len(near):
            return 0.0
        near = near[cKDTree(centres).query(near, distance_upper_bound=reach)[0] <= reach]
        if not len(near):
            return 0.0
        seen, pieces = (points - np.outer(points @ direction, direction) for points in (near, centres))
        cover = max(COVER * spacing, self.piece)
        covered = cKDTree(seen).query(pieces, distance_upper_bound=cover)[0] <= cover
        return float(self.areas[covered].sum())


def facing(vertices, facets, direction):
    """Corners (m, 2 or 3, 3) of the facets that face a load along `direction` (3,), and their areas seen along it (m,).

    Facets may be oriented either way, but all alike.
    """
    corners = vertices[facets]
    away = corners - vertices.mean(axis=0)
    if facets.shape[1] == 3:
        normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    else:
        along = corners[:, 1] - corners[:, 0]
        normals = np.column_stack([along[:, 2], np.zeros(len(along)), -along[:, 0]])
    outwards = np.sign(np.einsum("ij,ij->", away.mean(axis=1), normals)) or 1.0
    against = -outwards * normals @ direction
    # Facets parallel to the load have no area along it; round-off decides their sign
    faces = against > 1e-9 * np.linalg.norm(normals, axis=1)
    return corners[faces], against[faces]


def bisected(corners, areas, size):
    """Facets (m, 2 or 3, 3) halved at their longest edges until none is longer than `size` [m], with their areas."""
    k = corners.shape[1]
    done = [(corners[:0], areas[:0])]
    while len(corners):
        edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        longest = edges.argmax(axis=1)
        large = edges[np.arange(len(edges)), longest] > size
        done.append((corners[~large], areas[~large]))
        first = longest[large]
        rows = np.flatnonzero(large)
        middle = 0.5 * (corners[rows, first] + corners[rows, (first + 1) % k])
        halves = corners[rows].copy(), corners[rows].copy()
        here = np.arange(len(rows))
        halves[0][here, (first + 1) % k] = middle
        halves[1][here, first] = middle
        corners, areas = np.concatenate(halves), np.tile(0.5 * areas[rows], 2)
    return np.concatenate([part for part, _ in done]), np.concatenate([part for _, part in done])
