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
from snowmpm.mpm.contact.node_weight import half_space, node_weight


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
        weights = np.where(faint[nodes], 1e-20, np.maximum(node_weight(self._z_of[nodes], self._kernel), 1e-9))
        weights /= np.bincount(lines, weights, len(self))[lines]
        return self._rows(lines, nodes, weights)

    def _rows(self, lines, nodes, values):
        return sparse.csr_array((values, (lines, nodes)), shape=(len(self), self._mesh.n_nodes))

    def arrived(self, filled):
        """Whether snow has come as close to the surface as half of it counts as in contact (`mpm.contact.lines.GAP`),
        (m,). filled (N,): volume of snow at the nodes."""
        below = np.bincount(self.line, filled[self.follows], len(self))
        least = sum(half_space(self._z - j - 1.0 - GAP, self._kernel) for j in range(REACH[self._kernel]))
        return self.deep | (below * half_space(self._z - GAP, self._kernel) >= filled[self.heads] * least)

    def places(self):
        """Points of the surface that the lines meet [cells], (m, dim)."""
        return self._mesh.nodes[self.heads] - self.depth[:, None] * self.normals
