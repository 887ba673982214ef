"""Where a surface crosses the lines of the grid: what `wall_contact` acts on, found once for a map of blocks.

On a line of nodes along the axis k on which |n_k| is largest, z = d / |n_k| is the distance [cells] to the surface
along the line. The first node with z > 1/2 leads (`ABOVE`), the `REACH` nodes below it follow. Nodes inside that no
node leads (below a ridge, or far inside) are deep. Where the axis k changes, an obstacle has an edge: a corner, or a
bend of 45 degrees to the grid. A line within `AROUND` cells of one that turns away from the snow knows where it is.
Terrain has none, nor has a part of a structure, whose ends go on in the next part.
"""

import functools
from typing import Any

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import Rows
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.mpm.contact.arrays import LineArrays, WallArrays
from snowmpm.mpm.node import block_nodes
from snowmpm.particles.blocks import EDGE
from snowmpm.schemes import BASES

REACH = {basis.name: basis.width for basis in BASES.values()}
"""Followers of a line at most: how far below a leader the nodes of snow on the surface lie."""

ABOVE = 0.5001
"""z above which a node leads. On a slope of round numbers many nodes lie at 1/2, where rounding would choose: ground
3e-14 m higher changed the velocities beside it by 6 % in five steps, and a GPU chose otherwise than a CPU."""

FARTHEST = 2.5
"""z up to which a node can be a leader; 1.5 on a plane, more where the surface curves."""

GAP = 0.25
"""Gap between snow and surface [cells along the line] from which on there is contact. The same on every line: where it
goes with the place of the surface between the nodes, a body that rolls meets bumps, and hops. Half of it is within the
noise of the sampling, and touches one line and not the next."""

AROUND = 2
"""Cells within which a line looks for an edge: snow beyond one farther off does not reach its nodes."""

TILT = 0.02
"""By how much another axis must be more normal to the surface before it takes the place of the last one."""


class Lines:
    """Lines and deep nodes of one surface in the contact blocks of a grid.

    start (n + 1,), deep_start (n + 1,), or more: first line and first deep node of each contact block. nodes
    (m, reach + 2): places of the leader and its followers among the nodes of the contact blocks, and of the node beside
    the leader towards an edge, -1 for none; numbers (m, dim + reach + 4): normal, d_f / d_l of the followers, their
    mass over the leader's in snow that fills the half-space, z of the leader, the same ratio of masses where a gap of
    `GAP` is left below, mass of the leader over that of the node beside it in snow that reaches `GAP` around the edge.
    deep (k,), deep_normals (k, dim).
    """

    def __init__(self, dim, real, kernel, stored, serial, edges):
        """edges: whether lines near an edge know where it is."""
        self.dim, self._real, self._reach, self._edges = dim, real, REACH[kernel], int(edges)
        self.nodes: Any = None
        self.deep: Any = None
        self.numbers: Any = None
        self.deep_normals: Any = None
        self.start: Any = None
        self.deep_start: Any = None
        self._counts: Any = None
        self._count, self._fill = line_kernels(dim, real, kernel, stored, serial)
        self._starts = Rows(), Rows()

    def find(self, blocks, slots, walls, plane):
        """Follow the contact blocks, or a surface that has moved. plane: axis, sign and level of a `Plane`."""
        n = max(1, blocks.n)
        if self._counts is None or self._counts.shape[0] < n:
            self._counts = ti.ndarray(ti.i32, (_room(n), 2))
        where = WallArrays(blocks.coordinates, blocks.neighbours, slots, walls, *plane)
        self._count(where, self._counts, blocks.chunk_bounds)
        ends = np.zeros((blocks.n + 1, 2), np.int32)
        self._counts.to_numpy()[: blocks.n].cumsum(axis=0, out=ends[1:])
        self.n_lines, self.n_deep = int(ends[-1, 0]), int(ends[-1, 1])
        self.start, self.deep_start = (rows.filled(ends[:, k]) for k, rows in enumerate(self._starts))
        # A solid that moves is sought in each step: what is large enough stays
        if self.nodes is None or self.nodes.shape[0] < self.n_lines:
            room = _room(self.n_lines)
            self.nodes, self.numbers = ti.ndarray(ti.i32, (room, 2 + self._reach)), self._reals(room, self._reach + 4)
        if self.deep is None or self.deep.shape[0] < self.n_deep:
            room = _room(self.n_deep)
            self.deep, self.deep_normals = ti.ndarray(ti.i32, (room,)), self._reals(room, 0)
        self._fill(where, self._edges, self.arrays, blocks.chunk_bounds)

    @property
    def arrays(self):
        """What kernels read of them."""
        return LineArrays(self.start, self.nodes, self.numbers, self.deep_start, self.deep, self.deep_normals)

    def release(self, rows):
        """Leave the followers of these lines to others (`joined_contact`)."""
        if len(rows):
            nodes = self.nodes.to_numpy()
            nodes[rows, 1:] = -1
            self.nodes.from_numpy(nodes)

    @property
    def bytes(self):
        """Memory of the tables; 0 before lines were sought."""
        if self.nodes is None:
            return 0
        real = 4 if self._real == ti.f32 else 8
        integers = np.prod(self.nodes.shape) + self.deep.shape[0] + self.start.shape[0] + self.deep_start.shape[0]
        return int(4 * integers + real * (np.prod(self.numbers.shape) + np.prod(self.deep_normals.shape)))

    def _reals(self, rows, more):
        return ti.ndarray(self._real, (rows, self.dim + more))


def _room(n):
    """Rows for n of them, and some more."""
    return n + n // 4 + 1


def half_space_mass(kernel):
    """Function -> mass of node at z, of snow that fills z > 0, over its mass far above: the integral of the weight
    (`node_weight.half_space` in tables)."""
    box = BASES[kernel].box or 1.0

    @ti.func
    def quadratic(z):
        u = ti.min(ti.max(z, -1.5), 1.5)
        inner = 0.5 + u * (0.75 - u * u / 3.0)
        tail = (1.5 - ti.abs(u)) ** 3 / 6.0
        return ti.select(ti.abs(u) < 0.5, inner, ti.select(u > 0.0, 1.0 - tail, tail))

    @ti.func
    def cubic(z):
        u = ti.min(ti.max(z, -2.0), 2.0)
        a = ti.abs(u)
        inner = 2.0 / 3.0 * a - a**3 / 3.0 + a**4 / 8.0
        outer = 0.5 - (2.0 - a) ** 4 / 24.0
        half = ti.select(a < 1.0, inner, outer)
        return 0.5 + ti.select(u > 0.0, half, -half)

    @ti.func
    def twice(z):
        return ti.max(z, 0.0) + ti.max(1.0 - ti.abs(z), 0.0) ** 3 / 6.0

    @ti.func
    def averaged_hat(z):
        return (twice(z + ti.static(0.5 * box)) - twice(z - ti.static(0.5 * box))) * ti.static(1.0 / box)

    return {"quadratic": quadratic, "cubic": cubic}.get(kernel, averaged_hat)


@functools.cache
def line_kernels(dim, real, kernel, stored, serial):
    """`count` lines and deep nodes of each contact block, and `fill` their tables.

    stored: distance and normal of each node come from `walls`, where `slots[c]` >= 0; else the surface is the plane
    `x[axis] = level`, its normal along `sign`.
    """
    edge, n_nodes = EDGE[dim], block_nodes(dim)
    vec4 = ti.types.vector(4, real)
    reach = REACH[kernel]
    mass_share = half_space_mass(kernel)

    @ti.func
    def wall_at(c, q, at: ti.template()):
        """Normal and distance [cells] at a node, and whether they are known."""
        wall, known = vec4(0.0), 0
        if ti.static(stored):
            slot = at.slots[c]
            if slot >= 0:
                known = 1
                wall = at.walls[slot * n_nodes + q]
        else:
            known = 1
            for a in ti.static(range(dim)):
                if a == at.axis:
                    i = q // ti.static(edge ** (dim - 1 - a)) % edge
                    wall[a] = ti.cast(at.sign, real)
                    wall[3] = ti.cast((ti.cast(edge * at.coordinates[c, a] + i, ti.f64) - at.level) * at.sign, real)
        return wall, known

    @ti.func
    def along(wall):
        """Axis of the line, direction out of the solid on it, z."""
        k, best, component = dim - 1, ti.abs(wall[dim - 1]) + TILT, wall[dim - 1]
        for a in ti.static(range(dim - 1)):
            if ti.abs(wall[a]) > best:
                k, best, component = a, ti.abs(wall[a]), wall[a]
        return k, ti.select(component > 0.0, 1, -1), wall[3] / ti.max(ti.abs(component), 1e-6)

    @ti.func
    def step_along_line(c, q, k, steps, neighbours: ti.template()):
        """Contact block and node `steps` nodes further along axis k; block -1 where there is none."""
        width = 1
        for a in ti.static(range(dim - 1)):
            width = ti.select(k == a, edge ** (dim - 1 - a), width)
        here = q // width % edge
        there, block = here + steps, c
        if there < 0:
            there += edge
            block = neighbours[c, 2 * k]
        elif there >= edge:
            there -= edge
            block = neighbours[c, 2 * k + 1]
        return block, q + (there - here) * width

    @ti.func
    def steps_to_leader(z):
        """Nodes from a follower up to the first node that leads."""
        return ti.floor(ti.static(1.0 + ABOVE) - z, ti.i32)

    @ti.func
    def leads(z):
        return z > ABOVE and z < FARTHEST

    @ti.func
    def is_led(c, q, k, up, z, at: ti.template()):
        """Whether a node that does not lead follows one that does."""
        led, j = 0, steps_to_leader(z)
        if j <= reach:
            cl, ql = step_along_line(c, q, k, up * j, at.neighbours)
            if cl >= 0:
                wall, known = wall_at(cl, ql, at)
                k_l, up_l, z_l = along(wall)
                if known == 1 and k_l == k and up_l == up and leads(z_l):
                    led = 1
        return led

    @ti.func
    def follower(c, q, k, up, j, d, at: ti.template()):
        """Place of the node j + 1 below a leader with distance d, if it follows, else -1; ratio of their distances."""
        place, ratio = -1, ti.cast(0.0, real)
        cf, qf = step_along_line(c, q, k, -up * (j + 1), at.neighbours)
        if cf >= 0:
            wall, known = wall_at(cf, qf, at)
            k_f, up_f, z_f = along(wall)
            if known == 1 and k_f == k and up_f == up and z_f <= ABOVE and steps_to_leader(z_f) == j + 1:
                place, ratio = cf * n_nodes + qf, wall[3] / d
        return place, ratio

    @ti.func
    def beyond_edge(line, at: ti.template()):
        """Place of the node beside a leader on the side on which the surface turns away from its line, -1 if it does
        not; how far from the line it does [cells]. line: contact block and node of the leader, axis, direction."""
        c, q, k, up = line[0], line[1], line[2], line[3]
        place, nearest = -1, ti.cast(ti.static(float(AROUND)), real)
        cf, qf = step_along_line(c, q, k, -up, at.neighbours)
        if cf >= 0:
            for b in ti.static(range(dim)):
                if b != k:
                    for i in range(ti.static(2 * AROUND)):
                        side, steps = 1 - 2 * (i % 2), 1 + i // 2
                        ce, qe = step_along_line(cf, qf, b, side * steps, at.neighbours)
                        if ce >= 0:
                            wall, known = wall_at(ce, qe, at)
                            k_e, up_e, z_e = along(wall)
                            if known == 1 and k_e == b and up_e == side and steps - z_e < nearest:
                                cl, ql = step_along_line(c, q, b, side, at.neighbours)
                                if cl >= 0:
                                    place, nearest = cl * n_nodes + ql, steps - z_e
        return place, nearest

    @grouped_kernel(real)
    def count(at: WallArrays, counts: Array, chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for w in range(chunks(chunk_bounds)):
            if is_worker(w):
                first, last = chunk(w, chunk_bounds)
                for c in range(first, last):
                    n_lines, n_deep = 0, 0
                    if at.slots[c] >= 0:
                        for q in range(n_nodes):
                            wall, _ = wall_at(c, q, at)
                            k, up, z = along(wall)
                            if leads(z):
                                n_lines += 1
                            elif wall[3] <= 0.0:
                                n_deep += 1 - is_led(c, q, k, up, z, at)
                    counts[c, 0], counts[c, 1] = n_lines, n_deep

    @grouped_kernel(real)
    def fill(at: WallArrays, edges: int, lines: LineArrays, chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for w in range(chunks(chunk_bounds)):
            if is_worker(w):
                first, last = chunk(w, chunk_bounds)
                for c in range(first, last):
                    line, at_deep = lines.start[c], lines.deep_start[c]
                    if at.slots[c] >= 0:
                        for q in range(n_nodes):
                            wall, _ = wall_at(c, q, at)
                            k, up, z = along(wall)
                            if leads(z):
                                lines.places[line, 0] = c * n_nodes + q
                                full, touching = ti.cast(0.0, real), ti.cast(0.0, real)
                                for a in ti.static(range(dim)):
                                    lines.numbers[line, a] = wall[a]
                                for j in range(reach):
                                    place, ratio = follower(c, q, k, up, j, wall[3], at)
                                    lines.places[line, 1 + j], lines.numbers[line, dim + j] = place, ratio
                                    full += mass_share(z - (j + 1))
                                    touching += mass_share(z - (j + 1) - GAP)
                                lines.numbers[line, ti.static(dim + reach)] = full / mass_share(z)
                                lines.numbers[line, ti.static(dim + reach + 1)] = z
                                lines.numbers[line, ti.static(dim + reach + 2)] = touching / mass_share(z - GAP)
                                lines.places[line, ti.static(1 + reach)] = -1
                                if edges == 1:
                                    beside, away = beyond_edge(ti.Vector([c, q, k, up]), at)
                                    lines.places[line, ti.static(1 + reach)] = beside
                                    lines.numbers[line, ti.static(dim + reach + 3)] = (
                                        mass_share(GAP - away) / ti.max(mass_share(1.0 + GAP - away), 1e-9))
                                line += 1
                            elif wall[3] <= 0.0:  # noqa: SIM102 (see below)
                                # Not `and`: Taichi computes what a function gives before it asks whether it is wanted,
                                # and outside the solid there is no leader to look up
                                if is_led(c, q, k, up, z, at) == 0:
                                    lines.deep[at_deep] = c * n_nodes + q
                                    for a in ti.static(range(dim)):
                                        lines.deep_normals[at_deep, a] = wall[a]
                                    at_deep += 1

    return count, fill
