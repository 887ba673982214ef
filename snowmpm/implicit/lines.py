"""Lines of nodes that a surface crosses, on a `mesh.Mesh`: who follows whom, and what the surface feels of them.

As in `mpm.contact.lines`: along the axis on which the normal is largest, the first node above half a cell leads, those
below it follow. A node deep in the solid that no node leads is a line of its own. A constraint u_f = r_f u_l, r_f =
d_f / d_l, takes the force f_f of the surface on the follower and -r_f f_f on the leader, so that the surface gives the
line

    F = sum_f (1 - r_f) f_f

Where a line meets the surface, u is sum_j w_j u_j of the leader and its followers, w the spline at that place.
"""

import numpy as np
from scipy import sparse

from snowmpm.mpm.contact.lines import FARTHEST, GAP, REACH, TILT


class Lines:
    """Lines of a surface. follows, leader (k,): nodes; ratio (k,): r; line (k,): which line; normals (m, dim): of the
    lines, out of the solid; heads (m,): their leaders; depth (m,): distance of these [cells]; deep (m,): of one node in
    the solid."""

    def __init__(self, mesh, distance, kernel):
        dim, reach = mesh.dim, REACH[kernel]
        self._mesh, self._kernel = mesh, kernel
        d, normal = distance(mesh.nodes.astype(float))
        tilted = np.abs(normal) + np.where(np.arange(dim) == dim - 1, TILT, 0.0)
        axis = np.argmax(tilted, axis=1)
        across = np.take_along_axis(normal, axis[:, None], axis=1)[:, 0]
        up = np.where(across > 0.0, 1, -1)
        z = d / np.maximum(np.abs(across), 1e-6)
        leads = (z > 0.5) & (z < FARTHEST)
        below = np.flatnonzero(z <= 0.5)
        steps = np.floor(1.5 - z[below]).astype(np.int64)
        place = mesh.nodes[below].astype(np.int64)
        place[np.arange(len(below)), axis[below]] += up[below] * np.minimum(steps, reach + 1)
        leader = mesh.find(place)
        led = (leader >= 0) & (steps <= reach) & leads[leader] & (axis[leader] == axis[below]) & (
            up[leader] == up[below])
        deep = below[~led & (d[below] <= 0.0)]
        self.follows = np.concatenate([below[led], deep])
        self.leader = np.concatenate([leader[led], deep])
        self.ratio = np.concatenate([d[below[led]] / d[leader[led]], np.zeros(len(deep))])
        self.heads, self.line = np.unique(self.leader, return_inverse=True)
        self.normals, self.depth, self._z = normal[self.heads], d[self.heads], z[self.heads]
        self._z_of = z
        self.deep = self.depth <= 0.0

    def __len__(self):
        return len(self.heads)

    @property
    def nodes(self):
        """All nodes of the lines."""
        return np.unique(np.concatenate([self.follows, self.heads]))

    def traces(self, faint):
        """w, sparse (m, N), without faint nodes (N,) where a line has others."""
        own = ~self.deep
        lines = np.concatenate([self.line, np.flatnonzero(own)])
        nodes = np.concatenate([self.follows, self.heads[own]])
        weights = np.where(faint[nodes], 1e-20, np.maximum(_spline(self._z_of[nodes], self._kernel), 1e-9))
        weights /= np.bincount(lines, weights, len(self))[lines]
        return self._rows(lines, nodes, weights)

    def _rows(self, lines, nodes, values):
        return sparse.csr_array((values, (lines, nodes)), shape=(len(self), self._mesh.n_nodes))

    def arrived(self, filled):
        """Whether snow has come as close to the surface as half of it counts as in contact (`mpm.contact.lines.GAP`),
        (m,). filled (N,): volume of snow at the nodes."""
        below = np.bincount(self.line, filled[self.follows], len(self))
        least = sum(_half_space(self._z - j - 1.0 - GAP, self._kernel) for j in range(REACH[self._kernel]))
        return self.deep | (below * _half_space(self._z - GAP, self._kernel) >= filled[self.heads] * least)

    def places(self):
        """Points of the surface that the lines meet [cells], (m, dim)."""
        return self._mesh.nodes[self.heads] - self.depth[:, None] * self.normals


def _spline(z, kernel):
    """Weight of a node at the distance z [cells]."""
    a = np.abs(z)
    if kernel == "quadratic":
        return np.where(a < 0.5, 0.75 - a**2, 0.5 * np.maximum(1.5 - a, 0.0) ** 2)
    return np.where(a < 1.0, 2.0 / 3.0 - a**2 + 0.5 * a**3, np.maximum(2.0 - a, 0.0) ** 3 / 6.0)


def _half_space(z, kernel):
    """The integral of the spline up to z: mass of a node at z of snow that fills z > 0, over its mass far above."""
    if kernel == "quadratic":
        u = np.clip(z, -1.5, 1.5)
        tail = (1.5 - np.abs(u)) ** 3 / 6.0
        return np.where(np.abs(u) < 0.5, 0.5 + u * (0.75 - u**2 / 3.0), np.where(u > 0.0, 1.0 - tail, tail))
    a = np.abs(np.clip(z, -2.0, 2.0))
    half = np.where(a < 1.0, 2.0 / 3.0 * a - a**3 / 3.0 + a**4 / 8.0, 0.5 - (2.0 - a) ** 4 / 24.0)
    return 0.5 + np.where(z > 0.0, half, -half)
