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

import functools
import itertools
from typing import Any

import numpy as np
from scipy import sparse

from snowmpm.stepping.contact_velocity import SLIP, STICK

MOST_LINKS = 8
"""Followers of followers: surfaces that meet."""

FAINT = 0.002
"""Share of a full cell's volume below which a node is faint. On the flat face of a body, half a particle's spacing from
the nodes, the outermost ones have 0.016 (4 particles a cell in 2-D), half of it beside a wall, a quarter between
two, and at its corner the square of it."""


class Held:
    """What surfaces hold on a `Mesh`. lines: [(`lines.Lines`, codes (m,) of each line, or one for all)], OPEN, STICK or
    SLIP; volume (n,): of the particles [cells], None where faint nodes are to be free; past (N, dim): displacements
    [m] at which nodes that stick do, 0 when missing (`touch`).

    u = T v + offset, sparse (dim N, free); forces on v are test^T f, test = T but for friction; touched (N,): nodes
    that a surface acts on."""

    def __init__(self, mesh, lines, volume=None, past=None):
        self.mesh, dim = mesh, mesh.dim
        self._taken = np.zeros(mesh.n_nodes * dim, bool)
        self._rows: list[Any] = []
        self._columns: list[Any] = []
        self._values: list[Any] = []
        self.touched = np.zeros(mesh.n_nodes, bool)
        self._past = past
        self.offset: Any = None if past is None else np.zeros(mesh.n_nodes * dim)
        share = None if volume is None else mesh.W.T @ volume
        self.faint = np.zeros(mesh.n_nodes, bool) if share is None else share < FAINT
        self._reactions: tuple[list[Any], list[Any]] = ([], [])
        self._slides: list[Any] = []
        n_lines = 0
        for found, codes in lines:
            self._hold(found, np.broadcast_to(codes, len(found)), n_lines)
            n_lines += len(found)
        self._of_surfaces, self._n_lines = len(self._rows), n_lines
        if volume is not None:
            self._extend(share)
        self.free = np.flatnonzero(~self._taken)
        self.T = self.test = self._links()

    @functools.cached_property
    def _faint_links(self):
        return self._links_of(slice(self._of_surfaces, None))

    @functools.cached_property
    def _pulls(self):
        """For each component two matrices (m, dim N), of what adds up to the force of a line.

        The force that holds a follower is that on its own component that is tied, and on those tied to it (`held`). Of
        one that slides it is the normal part of all its components, as friction then leaves it (`felt`); but if faint
        ones are tied elsewhere.
        """
        size, dim, kinds = len(self._taken), self.mesh.dim, []
        for parts in self._reactions:
            lines, rows, shares = (np.concatenate([none, *each]) for none, each in zip(
                (np.zeros(0, int), np.zeros(0, int), np.zeros((0, dim))), zip(*parts, strict=True) if parts else
                ((), (), ()), strict=True))
            kinds.append([sparse.csr_array((shares[:, a], (lines, rows)), shape=(self._n_lines, size))
                          for a in range(dim)])
        return kinds

    def _hold(self, lines, codes, first):
        of_follower = codes[lines.line]
        for code in (STICK, SLIP):
            own = of_follower == code
            follows, leader = lines.follows[own], lines.leader[own]
            self.touched[np.concatenate([follows, leader])] = True
            line = lines.line[own]
            self._link(first + line, follows, leader, lines.ratio[own], lines.normals[line], code)

    def _link(self, line, follows, leader, ratio, normal, code):
        """Bind components of nodes (k,) of lines to those of their leaders."""
        dim = self.mesh.dim
        if code == STICK:
            for a in range(dim):
                rows = dim * follows + a
                new = self._claim(rows)
                self._add(rows[new], dim * leader[new] + a, ratio[new])
                self._reactions[0].append((line[new], rows[new], (1.0 - ratio[new])[:, None] * np.eye(dim)[a]))
                if self._past is not None:
                    self.offset[rows[new]] = (self._past[follows, a] - ratio * self._past[leader, a])[new]
            return
        main = np.argmax(np.abs(normal), axis=1)
        rows = dim * follows + main
        new = self._claim(rows)
        line, rows, follows, leader, ratio, normal, main = (
            x[new] for x in (line, rows, follows, leader, ratio, normal, main))
        share = normal / np.take_along_axis(normal, main[:, None], axis=1)
        self._slides.append((line, follows, leader, ratio, normal))
        faint, kept = self.faint[follows], (1.0 - ratio)[:, None]
        self._reactions[0].append((line[faint], rows[faint], (kept * share)[faint]))
        for a in range(dim):
            shares = kept * normal * normal[:, a : a + 1]
            self._reactions[1].append((line[~faint], dim * follows[~faint] + a, shares[~faint]))
        for a in range(dim):
            self._add(rows, dim * leader + a, ratio * share[:, a])
            other = main != a
            self._add(rows[other], dim * follows[other] + a, -share[other, a])

    def _extend(self, share):
        """Bind faint nodes to others. share (N,): of a full cell's volume."""
        mesh, dim = self.mesh, self.mesh.dim
        faint = np.flatnonzero(self.faint)
        if not len(faint):
            return
        solid = ~self.faint
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

    def _links_of(self, which):
        """Rows of the components that are tied, by those that they are tied to."""
        rows, columns, values = (np.concatenate([np.zeros(0, kind), *parts[which]]) for kind, parts in (
            (int, self._rows), (int, self._columns), (float, self._values)))
        return sparse.csr_array((values, (rows, columns)), shape=2 * (len(self._taken),))

    def _links(self):
        """T, with followers of followers resolved."""
        size = len(self._taken)
        ones = sparse.csr_array((np.ones(len(self.free)), (self.free, self.free)), shape=(size, size))
        self._all_links = sparse.csr_array((size, size))
        if not self._taken.any():
            return ones
        links = self._all_links = self._links_of(slice(None))
        T = step = ones + links
        for _ in range(MOST_LINKS):
            if T[:, self._taken].nnz == 0 or not T[:, self._taken].data.any():
                break
            T = T @ step
        if self.offset is not None:
            self.offset = self._summed(self.offset, links)
        return sparse.csr_array(T[:, self.free])

    def _summed(self, X, links):
        """X + links X + links^2 X ..., of followers of followers."""
        total = given = X
        for _ in range(MOST_LINKS):
            given = links @ given
            if not (given.nnz and given.data.any() if sparse.issparse(given) else given.any()):
                break
            total = total + given
        return total

    def _felt_forces(self, f):
        """Of nodal forces f (N, dim) those on tied components with all that is tied to them, and those with what faint
        nodes pass on, (dim N,)."""
        held = self._summed(f.ravel(), sparse.csr_array(self._all_links.T))
        return held, f.ravel() + self._faint_links.T @ held

    def line_forces(self, f):
        """Force of the surface on each line (m, dim) that nodal forces f (N, dim) are in balance with, but for
        friction, and the part of it by which lines that slide rub."""
        held, felt = self._felt_forces(f)
        rubbing = np.stack([own @ felt for own in self._pulls[1]], axis=1)
        return rubbing + np.stack([own @ held for own in self._pulls[0]], axis=1), rubbing

    def _sliding(self):
        """line, follows, leader, ratio, normal of the followers that slide."""
        kinds = (int, int, int, float, (float, self.mesh.dim))
        empty = [np.zeros((0, *kind[1:])) if isinstance(kind, tuple) else np.zeros(0, kind) for kind in kinds]
        return [np.concatenate(parts) for parts in zip(empty, *self._slides, strict=True)]

    def slid(self, f, u):
        """How far lines slid (m, dim) of displacements u (N, dim), with nodal forces f (N, dim): that on which their
        friction does its work, the mean over followers by their normal forces; 0 of lines without."""
        line, follows, leader, ratio, normal = self._sliding()
        felt = self._felt_forces(f)[1].reshape(f.shape)
        pressing = np.where(self.faint[follows], 0.0, np.maximum(np.einsum("ka,ka->k", felt[follows], normal), 0.0))
        whole = np.maximum(np.bincount(line, pressing, self._n_lines), 1e-300)
        way = u[follows] - ratio[:, None] * u[leader]
        return np.stack([np.bincount(line, pressing * way[:, a], self._n_lines) / whole for a in range(u.shape[1])], 1)

    def rub(self, friction):
        """Let surfaces rub: friction (m, dim), mu d of the lines, d the direction of the force.

        A follower that slides gets with its normal force f_n the friction f_n mu d, its leader -r of it. f_n follows
        from the residual R, so that T^T (R - F) = test^T R with other test functions, and nothing else need know of it.
        Faint followers do not rub.
        """
        line, follows, leader, ratio, normal = self._sliding()
        rubs = np.flatnonzero(friction[line].any(axis=1) & ~self.faint[follows])
        own, size = friction[line[rubs]], len(self._taken)

        def of_nodes(nodes, vectors):
            columns = self.mesh.dim * nodes[:, None] + np.arange(self.mesh.dim)
            starts = np.arange(0, columns.size + 1, self.mesh.dim)
            return sparse.csr_array((vectors.ravel(), columns.ravel(), starts), shape=(len(nodes), size))

        felt = sparse.csr_array(of_nodes(follows[rubs], normal[rubs]).T)
        forces = of_nodes(follows[rubs], own) - of_nodes(leader[rubs], ratio[rubs, None] * own)
        pulls = self._summed(sparse.csr_array(self._faint_links @ felt), self._all_links) + felt
        self.test = sparse.csr_array(self.T - pulls @ (forces @ self.T))

    def full(self, v):
        """u (N, dim) of free components."""
        u = self.T @ v
        return (u if self.offset is None else u + self.offset).reshape(-1, self.mesh.dim)

    def reduced(self, f):
        """test^T f of nodal forces (N, dim)."""
        return self.test.T @ f.ravel()
