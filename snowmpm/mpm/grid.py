"""The grid of MPM, stored as one overlapping tile of nodes per occupied block.

Tile b holds every node that a particle at home in block b can touch: nodes -1 .. EDGE + 2 of the block per axis (a
stencil of 3 nodes, a drift of one cell either way). Scatter and gather of a block touch only memory that is its own: no
colours, no atomics, one parallel loop, and sums in an order that no thread count changes. A node lies in at most two
tiles per axis; the grid update adds up its copies, advances it, and writes its velocity back to each.

A node is a vector of four: momentum, then velocity, in components 0 .. dim - 1; mass in component 3.
"""

import functools

import numpy as np
import taichi as ti

from snowmpm.blocks import EDGE, coordinates_of, keys_of, neighbour_steps
from snowmpm.contact import OPEN, contact_velocity
from snowmpm.parallel import chunk, chunks, is_worker
from snowmpm.runtime import DTYPES

TILE = {dim: edge + 4 for dim, edge in EDGE.items()}
"""Nodes per tile edge."""

ON_SURFACE = 1e-5
"""Cells above the ground up to which a node counts as inside: a node exactly on it must not be left to round-off."""


def int_array(values):
    """Taichi copy of an integer NumPy array; an empty one keeps one row so that kernels can take it."""
    values = np.ascontiguousarray(values, np.int32)
    if values.size == 0:
        values = np.zeros((1, *values.shape[1:]), np.int32)
    array = ti.ndarray(ti.i32, values.shape)
    array.from_numpy(values)
    return array


class TileGrid:
    """Tiles of the occupied blocks, and the node blocks that they cover.

    tile_of[n, s]: tile of the block one step s from node block n (steps as in `blocks.neighbour_steps`), -1 where that
    block is empty. walls[node]: outward normal and signed distance to the terrain [cells] at each node of each node block.
    """

    def __init__(self, dim, precision, wall_distance=None, flip=False):
        """flip: keep tiles for the internal impulse, then the change of velocity, too.
        wall_distance(nodes (k, dim) in cells) -> distance [cells] (k,), normal (k, dim); None without terrain."""
        self.dim = dim
        self.precision = precision
        self.wall_distance = wall_distance
        self.flip = flip
        self.node_keys = np.zeros(0, np.int64)
        self._walls = np.zeros((0, EDGE[dim] ** dim, 4))
        self.tiles = self.impulses = self.walls = None

    def fit(self, blocks):
        """Follow a new block map. What is known of the terrain at node blocks seen in the last map is kept."""
        dim, edge = self.dim, EDGE[self.dim]
        keys = np.unique(blocks.neighbours())
        coordinates = coordinates_of(keys, dim)
        around = keys_of((coordinates[:, None] + neighbour_steps(dim)).reshape(-1, dim))
        self._fit_walls(keys, coordinates)
        self.node_keys = keys
        self.node_coordinates = int_array(coordinates)
        self.tile_of = int_array(blocks.find(around).reshape(len(keys), -1))
        self.start = int_array(blocks.start)
        self.coordinates = int_array(blocks.coordinates)
        self.n_tiles, self.n_node_blocks = len(blocks), len(keys)
        self.tiles = self._room(self.tiles, self.n_tiles * TILE[dim] ** dim)
        self.impulses = self._room(self.impulses, self.n_tiles * TILE[dim] ** dim if self.flip else 1)
        self.walls = self._room(self.walls, len(keys) * edge**dim if self.wall_distance else 1)
        if self.wall_distance:
            padded = np.zeros((self.walls.shape[0], 4), DTYPES[self.precision][1])
            padded[: self._walls.shape[0] * edge**dim] = self._walls.reshape(-1, 4)
            self.walls.from_numpy(padded)

    def _room(self, array, nodes):
        """An array with room for that many nodes: the old one when it is large enough."""
        if array is not None and array.shape[0] >= nodes:
            return array
        return ti.ndarray(ti.types.vector(4, DTYPES[self.precision][0]), (int(1.25 * nodes) + 64,))

    @property
    def bytes(self):
        """Memory of tiles, walls and tables."""
        real = np.dtype(DTYPES[self.precision][1]).itemsize
        return 4 * real * (self.tiles.shape[0] + self.impulses.shape[0] + self.walls.shape[0]) + 4 * self.tile_of.shape[0] * self.tile_of.shape[1]

    def _fit_walls(self, keys, coordinates):
        if not self.wall_distance:
            return
        dim, edge = self.dim, EDGE[self.dim]
        walls = np.empty((len(keys), edge**dim, 4))
        at = np.searchsorted(self.node_keys, keys)
        known = np.zeros(len(keys), bool)
        inside = at < len(self.node_keys)
        known[inside] = self.node_keys[at[inside]] == keys[inside]
        walls[known] = self._walls[at[known]]
        if not known.all():
            nodes = np.stack(np.meshgrid(*[np.arange(edge)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
            points = (edge * coordinates[~known][:, None] + nodes).reshape(-1, dim)
            distance, normal = self.wall_distance(points.astype(np.float64))
            fresh = np.zeros((len(points), 4))
            fresh[:, :dim], fresh[:, 3] = normal, distance
            walls[~known] = fresh.reshape(-1, edge**dim, 4)
        self._walls = walls


@functools.cache
def grid_kernel(dim, real, with_terrain, flip):
    """Kernel that advances the nodes: v = p / m + dt g, loads, contact; the result replaces the momentum.

    flip: the internal impulse comes in tiles of its own, and the change of velocity replaces it.
    """
    edge, tile_edge = EDGE[dim], TILE[dim]
    vec4 = ti.types.vector(4, real)
    corners = 2**dim

    @ti.func
    def second_step(r):
        """Step to the other tile that holds node r of a block along an axis; 0 when there is none."""
        return ti.select(r <= 2, -1, ti.select(r == edge - 1, 1, 0))

    @ti.func
    def slot(tile_of: ti.template(), n, r, corner: ti.template()):
        """Address of a node's copy in one of its 2^dim tiles, -1 where that tile does not exist."""
        code, address, exists = 0, 0, 1
        for a in ti.static(range(dim)):
            step = 0
            if ti.static((corner >> a) & 1):
                step = second_step(r[a])
                if step == 0:
                    exists = 0
            code = code * 3 + step + 1
            address = address * tile_edge + (r[a] - edge * step + 1)
        tile = -1
        if exists == 1:
            tile = tile_of[n, code]
        return ti.select(tile >= 0, tile * tile_edge**dim + address, -1)

    @ti.kernel
    def update_grid(tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                    tile_of: ti.types.ndarray(),
                    node_coordinates: ti.types.ndarray(), walls: ti.types.ndarray(dtype=vec4, ndim=1),
                    sides: ti.types.ndarray(), loads: ti.types.ndarray(), gravity: ti.types.vector(dim, real),
                    dt: real, keep: real, terrain_code: int, terrain_friction: real,
                    impulse_of: ti.types.ndarray(), total: ti.types.ndarray(), n_loads: int, n_node_blocks: int,
                    workers: int):
        for i in range(chunks(workers)):
            if is_worker(i):
                first, last = chunk(i, workers, n_node_blocks)
                for n in range(first, last):
                    impulse, friction_work = ti.Vector.zero(ti.f64, dim), ti.cast(0.0, ti.f64)
                    for q in range(edge**dim):
                        r = ti.Vector.zero(ti.i32, dim)
                        rest = q
                        for a in ti.static(range(dim - 1, -1, -1)):
                            r[a] = rest % edge
                            rest = rest // edge
                        node, internal = vec4(0.0), vec4(0.0)
                        for c in ti.static(range(corners)):
                            s = slot(tile_of, n, r, c)
                            if s >= 0:
                                node += tiles[s]
                                if ti.static(flip):
                                    internal += impulses[s]
                        if node[3] > 0.0:
                            v = ti.Vector.zero(real, dim)
                            for a in ti.static(range(dim)):
                                v[a] = (node[a] + internal[a]) / node[3]
                            v = (v + dt * gravity) * keep
                            free = v
                            x = ti.Vector.zero(real, dim)
                            for a in ti.static(range(dim)):
                                x[a] = ti.cast(edge * node_coordinates[n, a] + r[a], real)
                            for j in range(n_loads):
                                d2 = ti.cast(0.0, real)
                                for a in ti.static(range(dim)):
                                    d2 += (x[a] - ti.cast(loads[j, a], real)) ** 2
                                if d2 < ti.cast(loads[j, dim], real) ** 2:
                                    for a in ti.static(range(dim)):
                                        v[a] += dt * ti.cast(loads[j, dim + 1 + a], real)
                            before = v
                            if ti.static(with_terrain):
                                wall = walls[n * edge**dim + q]
                                if wall[3] < ON_SURFACE:
                                    normal = ti.Vector([wall[a] for a in ti.static(range(dim))])
                                    v = contact_velocity(v, normal, terrain_code, terrain_friction)
                            for a in ti.static(range(dim)):
                                for side in ti.static(range(2)):
                                    sign = ti.static(1 - 2 * side)
                                    code = ti.cast(sides[a, side, 1], ti.i32)
                                    if code != OPEN and sign * (x[a] - ti.cast(sides[a, side, 0], real)) <= 0.0:
                                        normal = ti.Vector.unit(dim, a, real) * sign
                                        v = contact_velocity(v, normal, code, 0.0)
                            change = v - free
                            for a in ti.static(range(dim)):
                                impulse[a] += ti.cast(node[3] * change[a], ti.f64)
                            # Force times the velocity at the end of the step, as the scheme itself does work.
                            friction_work += ti.cast(node[3] * (before - v).dot(v), ti.f64)
                            result = vec4(0.0)
                            for a in ti.static(range(dim)):
                                result[a] = v[a]
                            result[3] = node[3]
                            for c in ti.static(range(corners)):
                                s = slot(tile_of, n, r, c)
                                if s >= 0:
                                    tiles[s] = result
                                    if ti.static(flip):
                                        impulses[s] = result - node / node[3]
                    for a in ti.static(range(dim)):
                        impulse_of[n, a] = impulse[a]
                    impulse_of[n, dim] = friction_work
        ti.loop_config(serialize=True)
        for n in range(n_node_blocks):
            for a in ti.static(range(dim + 1)):
                total[a] += impulse_of[n, a]

    return update_grid
