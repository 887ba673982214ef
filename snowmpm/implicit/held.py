"""Displacements of nodes that surfaces hold, in terms of those that are free: u = T v.

As in `mpm.contact.wall_contact`: on lines of nodes across a surface the constrained part of a follower is d_f / d_l
times that of its leader, of all components (stick) or of the normal one (slip), and test functions are held alike, so
that forces on v are T^T f. Nodes deep in the solid, which no node leads, keep still. A component that two surfaces want
belongs to the first of them.
"""

import numpy as np
from scipy import sparse

from snowmpm.mpm.contact.lines import FARTHEST, REACH, TILT
from snowmpm.stepping.contact_velocity import SLIP, STICK

MOST_LINKS = 8
"""Followers of followers: surfaces that meet."""


class Held:
    """What surfaces hold on a `Mesh`. surfaces: [(distance, code)], distance(nodes (k, dim) [cells]) -> distance
    [cells] (k,), normal out of the solid (k, dim); code: STICK or SLIP. T: sparse (dim N, free); touched (N,): nodes
    that a surface acts on."""

    def __init__(self, mesh, surfaces, kernel):
        self.mesh, dim = mesh, mesh.dim
        self._taken = np.zeros(mesh.n_nodes * dim, bool)
        self._rows, self._columns, self._values = [], [], []
        self.touched = np.zeros(mesh.n_nodes, bool)
        for distance, code in surfaces:
            self._hold(distance, code, REACH[kernel])
        self.free = np.flatnonzero(~self._taken)
        self.T = self._links()

    def _hold(self, distance, code, reach):
        mesh, dim = self.mesh, self.mesh.dim
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
        follows, leader = below[led], leader[led]
        deep = below[~led & (d[below] <= 0.0)]
        self.touched[np.concatenate([follows, leader, deep])] = True
        self._link(follows, leader, d[follows] / d[leader], normal[leader], code)
        self._link(deep, deep, np.zeros(len(deep)), normal[deep], code)

    def _link(self, follows, leader, ratio, normal, code):
        """Bind components of nodes (k,) to those of their leaders."""
        dim = self.mesh.dim
        if code == STICK:
            for a in range(dim):
                rows = dim * follows + a
                new = self._claim(rows)
                self._add(rows[new], dim * leader[new] + a, ratio[new])
            return
        if code != SLIP:
            raise ValueError("surfaces stick or slip here")
        main = np.argmax(np.abs(normal), axis=1)
        rows = dim * follows + main
        new = self._claim(rows)
        rows, follows, leader, ratio, normal, main = (x[new] for x in (rows, follows, leader, ratio, normal, main))
        share = normal / np.take_along_axis(normal, main[:, None], axis=1)
        for a in range(dim):
            self._add(rows, dim * leader + a, ratio * share[:, a])
            other = main != a
            self._add(rows[other], dim * follows[other] + a, -share[other, a])

    def _claim(self, rows):
        new = ~self._taken[rows]
        self._taken[rows[new]] = True
        return new

    def _add(self, rows, columns, values):
        keep = values != 0.0
        self._rows.append(rows[keep])
        self._columns.append(columns[keep])
        self._values.append(values[keep])

    def _links(self):
        """T, with followers of followers resolved."""
        size = len(self._taken)
        ones = sparse.csr_array((np.ones(len(self.free)), (self.free, self.free)), shape=(size, size))
        if not self._taken.any():
            return ones
        links = sparse.csr_array((np.concatenate(self._values), (np.concatenate(self._rows),
                                                                 np.concatenate(self._columns))), shape=(size, size))
        T = step = ones + links
        for _ in range(MOST_LINKS):
            if T[:, self._taken].nnz == 0 or not T[:, self._taken].data.any():
                break
            T = T @ step
        return sparse.csr_array(T[:, self.free])

    def full(self, v):
        """u (N, dim) of free components."""
        return (self.T @ v).reshape(-1, self.mesh.dim)

    def reduced(self, f):
        """T^T f of nodal forces (N, dim)."""
        return self.T.T @ f.ravel()
