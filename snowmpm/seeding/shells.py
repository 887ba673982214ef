"""The inside of a mesh of one or several closed shells: bodies side by side, cavities, and shells that overlap."""

import warnings

import numpy as np

from snowmpm.terrain import topology
from snowmpm.terrain.distance import DistanceField
from snowmpm.terrain.surface import TerrainSurface

SAMPLES = 80
"""Places along each side of the box at which the volume of shells that may overlap is measured: to about 0.2 %."""

SAME = 0.01
"""Relative difference of that volume from the sum of the shells' beyond which they count as overlapping."""

FEW = 24
"""Places along each side at which it is looked at first where no two shells can overlap: to about 2 %."""

CROSSED = 0.1
"""Relative difference beyond which a shell crosses itself."""

SURE = 5.0
"""Standard deviations of the measured volume besides, which is uncertain for thin bodies in large boxes."""


class Shells:
    """Closed shells, each a `TerrainSurface` that faces outwards, and +1 or -1: it holds snow, or a cavity.

    A shell that faces the other way than most in the file, and lies in another, is a cavity. A place is inside where
    the sum is above 0: where shells overlap it counts once.
    """

    def __init__(self, vertices, facets, surface):
        """vertices, facets: as in the file; surface: made of all of them, closed."""
        self.parts, self.signs = [], []
        vertices, facets = topology.tidied(np.asarray(vertices, float), np.asarray(facets))
        number = parts_of(facets, len(vertices))
        count = int(number.max()) + 1
        if count == 1:
            self.parts, self.signs = [surface], [1]
        else:
            for k in range(count):
                own = facets[number == k]
                used, own = np.unique(own, return_inverse=True)
                corners = vertices[used][own.reshape(-1, 3)]
                flux = np.linalg.det(corners - vertices[used].mean(axis=0)).sum()
                self.parts.append(TerrainSurface.of(vertices[used], own.reshape(-1, 3)))
                self.signs.append(int(np.sign(flux)) or 1)
            total = sum(sign * part.volume() for sign, part in zip(self.signs, self.parts, strict=True))
            if total < 0.0:  # the whole file faces inwards
                self.signs = [-sign for sign in self.signs]
        reach = [0.01 * float((part.upper - part.lower).max()) for part in self.parts]
        self._fields = [DistanceField(part, reach=far) for part, far in zip(self.parts, reach, strict=True)]
        # A shell that lies in none that holds snow is no cavity, whichever way it faces
        holding = [max(sign, 0) for sign in self.signs]
        self.signs = [sign if sign > 0 or (self._depth(part.vertices, holding) > 0).any() else 1
                      for part, sign in zip(self.parts, self.signs, strict=True)]

    def contains(self, points):
        """Whether each point (n, 3) is inside (n,)."""
        return self._depth(points, self.signs) > 0

    def _depth(self, points, signs):
        """Sum (n,) of the signs of the shells that each point (n, 3) lies in."""
        depth = np.zeros(len(points), int)
        for part, sign, field in zip(self.parts, signs, self._fields, strict=True):
            near = ((points >= part.lower) & (points <= part.upper)).all(axis=1)
            if near.any():
                depth[near] += sign * (field.query(points[near])[0] < 0)
        return depth

    def facets(self):
        """Corners (n, 3, 3) of all facets, which face away from the snow."""
        return np.concatenate([part.vertices[part.facets if sign > 0 else part.facets[:, ::-1]]
                               for part, sign in zip(self.parts, self.signs, strict=True)])

    def volume(self, where):
        """Volume [m3], and whether it is that of the shells' facets. A warning, which begins with `where`, tells of
        shells that overlap, and of one that crosses itself."""
        exact = float(sum(sign * part.volume() for sign, part in zip(self.signs, self.parts, strict=True)))
        if len(self.parts) > 1 and self._may_overlap():
            measured, _ = self._measured(SAMPLES)
            if abs(measured - exact) <= SAME * max(measured, exact):
                return exact, True
            said = "its shells overlap: what lies in several counts once"
        else:
            for side in (FEW, SAMPLES):
                measured, doubt = self._measured(side)
                if abs(measured - exact) <= CROSSED * max(measured, exact) + SURE * doubt:
                    return exact, True
            said = "its surface crosses itself: what lies inside counts once"
        warnings.warn(f"{where}: {said}, {measured:.4g} m3 of {exact:.4g} m3", stacklevel=2)
        return measured, False

    def _measured(self, side):
        """Volume [m3] of what is inside, by `side` places along each side of the box, and its standard deviation."""
        lower = np.min([part.lower for part in self.parts], axis=0)
        size = np.max([part.upper for part in self.parts], axis=0) - lower
        rng = np.random.default_rng(0)
        places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        share = float(self.contains(lower + (places + rng.random(places.shape)) / side * size).mean())
        return share * float(np.prod(size)), float(np.sqrt(share * (1.0 - share) / len(places)) * np.prod(size))

    def _may_overlap(self):
        """Whether the boxes of two shells that hold snow overlap, or a shell lies in another."""
        lower, upper = np.array([p.lower for p in self.parts]), np.array([p.upper for p in self.parts])
        order = np.argsort(lower[:, 0])
        active = []
        for i in order:
            active = [j for j in active if upper[j, 0] > lower[i, 0]]
            if any(((lower[j] < upper[i]) & (lower[i] < upper[j])).all() for j in active):
                return True
            active.append(i)
        return False


def parts_of(facets, n_vertices):
    """Number of the connected part that each facet (n, 3) belongs to."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    a, b = np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]]]).T
    _, number = connected_components(coo_matrix((np.ones(len(a), bool), (a, b)), (n_vertices, n_vertices)),
                                     directed=False)
    return np.unique(number[facets[:, 0]], return_inverse=True)[1].reshape(-1)
