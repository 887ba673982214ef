"""Lines of a flat wall oblique to the grid that another wall meets: what `joined_contact` needs to know of them.

A line i has the velocity g_i d at its nodes, d their distance to the wall. The spline of that is not zero on the wall,
x = d = 0, but, with N the spline on the lateral axes b, n_b the wall's normal along them [cells],

    w = sum_i g_i sum_b n_b (x_i - x)_b N_i = sum_b n_b sum_pairs (g_{i+1} - g_i) M_{i+1/2},    M_{i+1/2} >= 0

a sum over pairs of neighbours along each b, M_{i+1/2}(x) = sum_{m > i} (x_m - x) N_m. On a wall without end the parts
of two pairs cancel in the work of a pressure on each line; where another wall cuts it off they do not. So each pair
takes

    e = kappa (g_{i+1} - g_i),   kappa = n_b int M dA / (S_i + S_{i+1}),   S_i = int N_i dA,

off the nodes of both lines, the integrals over the part of the wall that is seen: a uniform pressure then does no work
on any line. Nodes above the leader reach down to a tilted wall too; they move freely, so the line's nodes take

    e = (T / S) (h - g d),   T = int N_above dA

off, h the velocity of the node above the leader, d its distance. A velocity linear in d stays as it is.
"""

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.contact.lines import REACH, TILT
from snowmpm.mpm.contact.node_weight import node_weight
from snowmpm.mpm.node import block_nodes
from snowmpm.particles.blocks import EDGE
from snowmpm.schemes import BASES

CUT = 4.0
"""Distance [cells] from another wall up to which the spline of a line may reach behind it."""

BESIDE = 2.1
"""Distance [cells] of a leader from another wall from which on no node of its line belongs to that wall's lines."""

POINTS = {2: 32, 3: 8}
"""Points of quadrature a cell and lateral axis."""

PARALLEL = 1e-3
"""Difference of normals up to which a wall is flat."""

OBLIQUE = 1e-6
"""Of a normal, the part along a lateral axis above which its wall is oblique to the grid."""


def state_width(dim):
    """Numbers that `joined_contact` keeps of a line at most."""
    return 10 * dim + 4


class JoinedLines:
    """Lines of one wall, n of them.

    ints (n, 3 + reach + 2 (dim - 1)): places of leader and followers, of the node above the leader, neighbours one step
    ahead along each lateral axis and one step back, -1 for none, and whether no other wall is near; numbers
    (n, 2 + reach + 2 dim): normal, distances of leader and followers, of the node above [cells], kappa with the
    neighbours ahead, T / S.
    """

    def __init__(self, dim, ints, numbers, precision):
        self.n, self.ints = len(ints), int_array(ints)
        real, dtype = DTYPES[precision]
        self.numbers = ti.ndarray(real, numbers.shape)
        self.numbers.from_numpy(numbers.astype(dtype))
        self.state = ti.ndarray(real, (self.n, state_width(dim)))

    @classmethod
    def of(cls, lines, blocks, others, kernel, precision):
        """Those of `Lines`, and their rows in its tables; None if the wall is along the grid, curved, or no other wall
        meets it. others: functions that give the distance [cells] from another wall at points (k, dim) [cells]."""
        normals = lines.numbers.to_numpy()[: lines.n_lines, : lines.dim]
        if not len(normals) or not is_oblique_plane(normals):
            return None, ()
        wall = _Wall(lines, blocks, kernel)
        if not wall.n:
            return None, ()
        gap = np.min([distance(wall.leaders.astype(float)) for distance in others] or [[np.inf]], axis=0)
        if gap.min() > CUT:
            return None, ()
        ahead, back = wall.neighbours(1), wall.neighbours(-1)
        S, T, M = wall.seen(others, gap < CUT)
        kappa = np.zeros(M.shape)
        for b, other in enumerate(ahead.T):
            pair = (other >= 0) & (S + S[other] > 1e-3)
            kappa[pair, b] = wall.lateral[pair, b] * M[pair, b] / (S[pair] + S[other[pair]])
        share = np.where(S > 1e-3, T / np.maximum(S, 1e-3), 0.0)
        ints = np.column_stack([wall.places, wall.above(blocks), ahead, back, gap > BESIDE])
        numbers = np.column_stack([wall.normal, wall.distances, wall.distances[:, 0] + wall.along, kappa, share])
        return cls(lines.dim, ints, numbers, precision), wall.rows


def is_oblique_plane(normals):
    """Whether unit normals (n, dim) are those of one plane that is oblique to the grid."""
    return np.ptp(normals, axis=0).max() < PARALLEL and np.sort(np.abs(normals[0]))[-2] > OBLIQUE


class _Wall:
    """Lines of `Lines` that have followers, on the nodes of the grid."""

    def __init__(self, lines, blocks, kernel):
        self.dim, self.edge, self.reach, self.kernel = lines.dim, EDGE[lines.dim], REACH[kernel], kernel
        self.stride = block_nodes(self.dim)
        places, numbers = lines.nodes.to_numpy()[: lines.n_lines], lines.numbers.to_numpy()[: lines.n_lines]
        places = places[:, : 1 + self.reach]
        self.rows = np.flatnonzero((places[:, 1:] >= 0).any(axis=1))
        self.n = len(self.rows)
        self.places, numbers = places[self.rows], numbers[self.rows].astype(np.float64)
        block, node = np.divmod(self.places[:, 0], self.stride)
        within = np.stack(np.unravel_index(node, (self.edge,) * self.dim), axis=-1)
        self.leaders = self.edge * blocks.coordinates.to_numpy()[block] + within
        self.normal = numbers[:, : self.dim]
        size = np.abs(self.normal)
        size[:, -1] += TILT  # as `lines` chooses the axis of a line
        self.axis, each = size.argmax(axis=1), np.arange(self.n)
        self.others = np.array([[a for a in range(self.dim) if a != k] for k in range(self.dim)])[self.axis]
        component = self.normal[each, self.axis]
        self.up, self.along = np.sign(component).astype(int), np.abs(component)
        self.lateral = np.take_along_axis(self.normal, self.others, axis=1)
        self.height = numbers[:, self.dim + self.reach + 1]
        ratios = np.column_stack([np.ones(self.n), numbers[:, self.dim : self.dim + self.reach]])
        self.distances = (self.height * self.along)[:, None] * ratios

    def neighbours(self, step):
        """Line one step further along each lateral axis (n, dim - 1), or -1."""
        at = np.take_along_axis(self.leaders, self.others, axis=1)
        where = {tuple(place): i for i, place in enumerate(at)}
        shifts = step * np.eye(self.dim - 1, dtype=int)
        return np.array([[where.get(tuple(place + shift), -1) for shift in shifts] for place in at])

    def above(self, blocks):
        """Place of the node above each leader, or -1."""
        nodes = self.leaders.copy()
        nodes[np.arange(self.n), self.axis] += self.up
        index = {tuple(block): i for i, block in enumerate(blocks.coordinates.to_numpy()[: blocks.n])}
        block = np.array([index.get(tuple(node), -1) for node in nodes // self.edge])
        within = np.ravel_multi_index(tuple((nodes % self.edge).T), (self.edge,) * self.dim)
        return np.where(block >= 0, block * self.stride + within, -1)

    def seen(self, others, near):
        """Integrals over the seen part of the wall, per area of a cell of the lateral axes: S (n,), T (n,),
        M (n, dim - 1)."""
        fine, reach = POINTS[self.dim], 0.5 * BASES[self.kernel].width
        side = (np.arange(int(2 * reach * fine)) + 0.5) / fine - reach
        xi = np.stack(np.meshgrid(*[side] * (self.dim - 1), indexing="ij"), axis=-1).reshape(-1, self.dim - 1)
        # Height of the leader above the wall at these places, along the line [cells]
        drop = self.height[:, None] + (self.lateral / self.along[:, None]) @ xi.T
        weight = np.ones((self.n, len(xi))) / fine ** (self.dim - 1)
        if near.any():
            beside, row = np.flatnonzero(near), np.arange(near.sum())[:, None]
            points = np.repeat(self.leaders[beside, None].astype(float), len(xi), axis=1)
            for b in range(self.dim - 1):
                points[row, np.arange(len(xi)), self.others[beside, b, None]] += xi[:, b]
            points[row, np.arange(len(xi)), self.axis[beside, None]] -= self.up[beside, None] * drop[beside]
            for distance in others:
                found = distance(points.reshape(-1, self.dim)).reshape(len(beside), -1)
                weight[beside] *= np.clip(0.5 + fine * found, 0.0, 1.0)
        splines, bumps = (function(xi, self.kernel) for function in (node_weight, _bump))
        product = weight * splines.prod(axis=1)
        S = np.sum([(product * node_weight(drop - j, self.kernel)).sum(axis=1) for j in range(self.reach + 1)], axis=0)
        T = (product * node_weight(drop + 1.0, self.kernel)).sum(axis=1)
        rest = [np.delete(splines, b, axis=1).prod(axis=1) for b in range(self.dim - 1)]
        M = np.stack([(weight * (bumps[:, b] * rest[b])).sum(axis=1) for b in range(self.dim - 1)], axis=1)
        return S, T, M


def _bump(x, kernel):
    """M of a node at x = 0 and the next one."""
    reach = 0.5 * BASES[kernel].width
    return np.where(x < reach, sum((m - x) * node_weight(m - x, kernel) for m in range(1, 5)), 0.0)
