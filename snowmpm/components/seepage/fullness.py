"""How full space is around particles of water, among grains at rest and between walls, and what moves it.

    f_i = sum_j V_j W_ij + sum_g S_g W_ig

V: volume of a particle of water, S: of the solid of a grain. Walls are mirrors: images of both count. Where f = 1 there
is no room left. Since grains take room too, the share of the water is n = 1 - sum_g S_g W_ig, and no parcel has to know
in which of the two it lies. The kernel is Wendland's C2 (doi:10.1007/BF02123482).
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

REACH = 3.0
"""Of the kernel, over the spacing of the grains: h = 1.5. A lattice of grains and their water then sums to 1.005."""

LEAST_SHARE = 0.05
"""Of the water in space."""

PEAK = {2: 7.0 / np.pi, 3: 21.0 / (2.0 * np.pi)}
"""W(0) of a kernel that reaches as far as 1."""


def wendland(r, reach, dim):
    """W(r) [1/m^dim] and -W'(r) / r [1/m^(dim+2)]."""
    q = np.minimum(r / reach, 1.0)
    peak = PEAK[dim] / reach**dim
    return peak * (1.0 - q) ** 4 * (1.0 + 4.0 * q), 20.0 * peak / reach**2 * (1.0 - q) ** 3


class Walls:
    """places: [(axis, coordinate [m])] of walls normal to an axis, which mirror what lies near them."""

    def __init__(self, places):
        self.places = places

    def images(self, x, reach):
        """Places (k, dim) of x (n, dim) and of their images within reach [m] of a wall, whose they are (k,), and the
        signs of the components (k, dim) of what belongs to them."""
        place, owner, sign = x, np.arange(len(x)), np.ones_like(x)
        for axis, wall in self.places:
            near = np.flatnonzero(np.abs(place[:, axis] - wall) < reach)
            image, turned = place[near].copy(), sign[near].copy()
            image[:, axis] = 2.0 * wall - image[:, axis]
            turned[:, axis] *= -1.0
            place, sign = np.vstack([place, image]), np.vstack([sign, turned])
            owner = np.concatenate([owner, owner[near]])
        return place, owner, sign

    def held(self, x, w, lower, upper):
        """Put back what has crossed a wall, at rest across it; lower, upper (dim,) [m]: of the domain."""
        for axis, wall in self.places:
            inward = 1.0 if wall <= 0.5 * (lower[axis] + upper[axis]) else -1.0
            beyond = inward * (x[:, axis] - wall) < 0.0
            x[beyond, axis] = 2.0 * wall - x[beyond, axis]
            w[beyond, axis] = 0.0


class Grains:
    """places (k, dim) [m], volume (k,) [m3] of the snow or soil of each, porosity (k,)."""

    def __init__(self, places, volume, porosity, walls, reach):
        self.reach, self.dim = reach, places.shape[1]
        place, owner, _ = walls.images(places, reach)
        self._tree = cKDTree(place) if len(place) else None
        self._volume, self._solid = volume[owner], ((1.0 - porosity) * volume)[owner]

    def around(self, x, tree):
        """At x (n, dim), of which `tree` is made: volume of the solid in that of space, its gradient (n, dim) [1/m],
        and the volume of the porous medium in that of space."""
        n = len(x)
        if self._tree is None:
            return np.zeros(n), np.zeros_like(x), np.zeros(n)
        near = tree.sparse_distance_matrix(self._tree, self.reach, output_type="coo_matrix")
        i, g = near.row, near.col
        value, slope = wendland(near.data, self.reach, self.dim)
        solid = np.bincount(i, self._solid[g] * value, n)
        parts = -(self._solid[g] * slope)[:, None] * (x[i] - self._tree.data[g])
        gradient = np.stack([np.bincount(i, parts[:, a], n) for a in range(self.dim)], axis=1)
        return solid, gradient, np.bincount(i, self._volume[g] * value, n)


class Fullness:
    """Of water at x (n, dim) of the volumes V (n,): f and n = share (n,), solid and medium (n,): `Grains.around`;
    gradients: a matrix df_i / dx_j [1/m] for each axis; and the pairs i, j of a particle and another one or an image:
    owner[j], the signs of j, the way from j to i, its length and W."""

    def __init__(self, x, volume, grains, walls, reach):
        n, dim = x.shape
        tree = cKDTree(x)
        solid, solid_gradient, self.medium = grains.around(x, tree)
        place, owner, sign = walls.images(x, reach)
        near = tree.sparse_distance_matrix(cKDTree(place), reach, output_type="coo_matrix")
        other = near.row != near.col
        self.i, j, self.length = near.row[other], near.col[other], near.data[other]
        self.owner, self.sign, self.way = owner[j], sign[j], x[self.i] - place[j]
        self.value, slope = wendland(self.length, reach, dim)
        own = volume[self.owner]
        self._peak = wendland(0.0, reach, dim)[0]
        self.f = solid + volume * self._peak + np.bincount(self.i, own * self.value, n)
        self.share = np.maximum(1.0 - solid / np.maximum(self.medium, 1.0), LEAST_SHARE)
        self.solid = solid
        rows = np.concatenate([self.i, self.i, np.arange(n)])
        columns = np.concatenate([self.i, self.owner, np.arange(n)])
        parts = -(own * slope)[:, None] * self.way
        self.gradients = [csr_matrix((np.concatenate([parts[:, a], -self.sign[:, a] * parts[:, a],
                                                      solid_gradient[:, a]]), (rows, columns)), (n, n))
                          for a in range(dim)]

    def mean(self, weight, values):
        """Of values (n,) around each particle, by weight (n,) and W."""
        own = weight * self._peak
        parts = weight[self.owner] * self.value
        total = own + np.bincount(self.i, parts, len(own))
        return (own * values + np.bincount(self.i, parts * values[self.owner], len(own))) / total

    def apart(self, of_pair):
        """Sums (n, dim) over the pairs of each particle of of_pair (pairs, dim)."""
        return np.stack([np.bincount(self.i, of_pair[:, a], len(self.f)) for a in range(of_pair.shape[1])], axis=1)
