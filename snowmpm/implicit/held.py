"""Displacements of nodes that surfaces hold, in terms of those that are free: u = T v.

As in `mpm.contact.wall_contact`: on lines of nodes across a surface the constrained part of a follower is d_f / d_l
times that of its leader, of all components (stick) or of the normal one (slip), and test functions are held alike, so
that forces on v are T^T f. Nodes deep in the solid, which no node leads, keep still. A component that two surfaces want
belongs to the first of them.

Faint nodes, which hardly any snow reaches (the corner of a body, a lone grain's far side), follow the line through two
nodes that are not: u_I = 2 u_J - u_K, or one such node. What they do alone has next to no mass and no stiffness, and
would be noise that turns particles inside out. It is what extended B-splines do (Hoellig, Reif & Wipper 2001,
doi:10.1137/S0036142900373208); constants and linear fields stay, so that nothing is lost of momentum.
"""

import itertools

import numpy as np
from scipy import sparse

from snowmpm.mpm.contact.lines import FARTHEST, REACH, TILT
from snowmpm.stepping.contact_velocity import SLIP, STICK

MOST_LINKS = 8
"""Followers of followers: surfaces that meet."""

FAINT = 0.002
"""Share of a full cell's volume below which a node is faint. On the flat face of a body, half a particle's spacing from
the nodes, the outermost ones have 0.016 (4 particles a cell in 2-D), half of it beside a wall, a quarter between
two, and at its corner the square of it."""


class Held:
    """What surfaces hold on a `Mesh`. surfaces: [(distance, code)], distance(nodes (k, dim) [cells]) -> distance
    [cells] (k,), normal out of the solid (k, dim); code: STICK or SLIP; volume (n,): of the particles [cells], None
    where faint nodes are to be free. T: sparse (dim N, free); touched (N,): nodes that a surface acts on."""

    def __init__(self, mesh, surfaces, kernel, volume=None):
        self.mesh, dim = mesh, mesh.dim
        self._taken = np.zeros(mesh.n_nodes * dim, bool)
        self._rows, self._columns, self._values = [], [], []
        self.touched = np.zeros(mesh.n_nodes, bool)
        for distance, code in surfaces:
            self._hold(distance, code, REACH[kernel])
        if volume is not None:
            self._extend(mesh.W.T @ volume)
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

    def _extend(self, share):
        """Bind faint nodes to others. share (N,): of a full cell's volume."""
        mesh, dim = self.mesh, self.mesh.dim
        faint = np.flatnonzero(share < FAINT)
        if not len(faint):
            return
        solid = share >= FAINT
        best = np.zeros(len(faint))
        first, second = np.full((2, len(faint)), -1)
        for step in itertools.product((-1, 0, 1), repeat=dim):
            if not any(step):
                continue
            one, two = (mesh.find(mesh.nodes[faint] + k * np.array(step)) for k in (1, 2))
            one = np.where((one >= 0) & solid[one], one, -1)
            two = np.where((one >= 0) & (two >= 0) & solid[two], two, -1)
            score = np.where(one >= 0, share[one], 0.0) + (two >= 0)
            better = score > best
            best[better], first[better], second[better] = score[better], one[better], two[better]
        led, line = first >= 0, second >= 0
        for nodes in (faint[led], first[led], second[line]):
            self.touched[nodes] = True
        for a in range(dim):
            rows = dim * faint + a
            new = np.zeros(len(rows), bool)
            new[led] = self._claim(rows[led])
            self._add(rows[new], dim * first[new] + a, np.where(line, 2.0, 1.0)[new])
            new &= line
            self._add(rows[new], dim * second[new] + a, np.full(new.sum(), -1.0))

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
