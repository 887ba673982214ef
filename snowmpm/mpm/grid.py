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

from snowmpm.blocks import EDGE, coordinates_of, step_along
from snowmpm.contact import OPEN, contact_velocity
from snowmpm.mpm.walls import FREE, ON_SURFACE, Walls
from snowmpm.parallel import SPREAD, chunk, chunks, is_worker, most_workers, shares
from snowmpm.runtime import DTYPES

BLOCK_COST = 8
"""Cost of a block beside that of its particles, in particles: clearing its tile, and its share of cache misses."""

NODE_BLOCK_COST = 2
"""Cost of a node block beside that of adding up its tiles, in tiles."""

TILE = {dim: edge + 4 for dim, edge in EDGE.items()}
"""Nodes per tile edge."""


def tile_strides(dim):
    """Distance in memory of neighbour nodes of a tile along each of three axes; 0 along the first in 2-D."""
    return [0] * (3 - dim) + [TILE[dim] ** (dim - 1 - a) for a in range(dim)]


def int_array(values):
    """Taichi copy of an integer NumPy array; an empty one keeps one row so that kernels can take it."""
    values = np.ascontiguousarray(values, np.int32)
    if values.size == 0:
        values = np.zeros((1, *values.shape[1:]), np.int32)
    array = ti.ndarray(ti.i32, values.shape)
    array.from_numpy(values)
    return array


def real_array(values):
    """Taichi copy of a small table of numbers, float64; cheaper to launch a kernel with than a NumPy array."""
    values = np.array(values, np.float64)
    array = ti.ndarray(ti.f64, values.shape)
    array.from_numpy(values)
    return array


class TileGrid:
    """Tiles of the occupied blocks, and the node blocks that they cover.

    tiles_at[i], first_tile[n] <= i < first_tile[n + 1]: a tile that holds copies of node block n, and the step to its
    block (`BlockMap.node_blocks`). boxes[tile]: first and one-past-last node along each of three axes that its
    particles reach.
    wall_slot[n]: where `walls` keeps the terrain at the nodes of node block n. shares, node_shares: the tiles and the
    node blocks, cut into chunks of about equal work.
    """

    def __init__(self, dim, precision, wall_distance=None, flip=False):
        """flip: keep tiles for the internal impulse, then the change of velocity, too.
        wall_distance(nodes (k, dim) in cells) -> distance [cells] (k,), normal (k, dim); None without terrain."""
        self.dim = dim
        self.precision = precision
        self.flip = flip
        self.walls = Walls(dim, precision, wall_distance)
        self.tiles = self.impulses = None
        self.scratch = self._room(None, 2 * EDGE[dim] ** dim * most_workers())

    def fit(self, blocks):
        """Follow a new block map."""
        dim = self.dim
        keys, start, tiles_at = blocks.node_blocks()
        coordinates = coordinates_of(keys, dim)
        self.wall_slot = int_array(self.walls.slots(keys, coordinates))
        self.node_coordinates = int_array(coordinates)
        self.first_tile, self.tiles_at = int_array(start), int_array(tiles_at)
        self.start = int_array(blocks.start)
        self.coordinates = int_array(blocks.coordinates)
        self.n_tiles, self.n_node_blocks = len(blocks), len(keys)
        self.shares = int_array(shares(np.diff(blocks.start) + BLOCK_COST))
        self.node_shares = int_array(shares(np.diff(start) + NODE_BLOCK_COST))
        self.boxes = self._whole_tiles(self.n_tiles)
        self.tiles = self._room(self.tiles, self.n_tiles * TILE[dim] ** dim)
        self.impulses = self._room(self.impulses, self.n_tiles * TILE[dim] ** dim if self.flip else 1)

    def _room(self, array, nodes):
        """An array with room for that many nodes: the old one when it is large enough."""
        if array is not None and array.shape[0] >= nodes:
            return array
        return ti.ndarray(ti.types.vector(4, DTYPES[self.precision][0]), (int(1.25 * nodes) + 64,))

    def _whole_tiles(self, n):
        """Boxes that leave no node of a tile out, until the particles tell which ones they reach."""
        flat = 3 - self.dim
        return int_array(np.broadcast_to([0] * 3 + [1] * flat + [TILE[self.dim]] * self.dim, (n, 6)))

    @property
    def bytes(self):
        """Memory of tiles, walls and tables."""
        real = np.dtype(DTYPES[self.precision][1]).itemsize
        nodes = self.tiles.shape[0] + self.impulses.shape[0] + self.walls.array.shape[0] + self.scratch.shape[0]
        tables = self.first_tile, self.tiles_at, self.node_coordinates, self.boxes
        integers = sum(np.prod(table.shape) for table in tables)
        return 4 * real * nodes + 4 * int(integers)


@functools.cache
def grid_kernel(dim, real, with_terrain, flip):
    """Kernel that advances the nodes: v = p / m + dt g, loads, contact; the result replaces the momentum.

    flip: the internal impulse comes in tiles of its own, and the change of velocity replaces it.

    A node block adds up what the tiles around it hold of it, in the order of the steps to them, in a scratch block of
    its worker that stays in the nearest cache, advances its nodes, and writes them back to the tiles; only the boxes
    that particles reach are touched. In 2-D the first of three axes is one node wide.
    """
    edge, tile_edge = EDGE[dim], TILE[dim]
    vec4 = ti.types.vector(4, real)
    n_nodes = edge**dim
    stride = tile_strides(dim)
    # Nodes of a row that the tile of the block before, the block's own and the tile of the block after hold
    held = (range(3), range(edge), range(edge - 1, edge))

    @ti.func
    def common_box(boxes: ti.template(), tile, step):
        """First and one-past-last of a block's nodes in the box of the tile one step from it; where its node 0 is."""
        first, last, address = ti.Vector([0, 0, 0]), ti.Vector([1, 1, 1]), tile * tile_edge**dim
        for a in ti.static(range(3 - dim, 3)):
            to_tile = 1 - edge * step_along(step, a + dim - 3)
            first[a] = ti.max(0, boxes[tile, a] - to_tile)
            last[a] = ti.min(edge, boxes[tile, 3 + a] - to_tile)
            address += to_tile * ti.static(stride[a])
        return first, last, address

    @ti.func
    def exchange(gathering: ti.template(), n, first_tile: ti.template(), tiles_at: ti.template(),
                 boxes: ti.template(), scratch: ti.template(), sums, tiles: ti.template()):
        """Add a node block's copies up in the scratch block, or write them back; -> whether there are any, and the box
        of nodes that holds them."""
        found, least, most = 0, ti.Vector([edge, edge, edge]), ti.Vector([0, 0, 0])
        for e in range(first_tile[n], first_tile[n + 1]):
            step = tiles_at[e, 1]
            first, last, address = common_box(boxes, tiles_at[e, 0], step)
            if (last > first).all():
                if gathering and found == 0:
                    for q in range(n_nodes):
                        scratch[sums + q] = vec4(0.0)
                found = 1
                least, most = ti.min(least, first), ti.max(most, last)
                for c in ti.static(range(3)):
                    if step_along(step, dim - 1) == c - 1:
                        for i in range(first[0], last[0]):
                            for j in range(first[1], last[1]):
                                here = sums + (i * edge + j) * edge
                                there = address + i * ti.static(stride[0]) + j * ti.static(stride[1])
                                for k in ti.static(held[c]):
                                    if ti.static(gathering):
                                        scratch[here + k] = scratch[here + k] + tiles[there + k]
                                    else:
                                        tiles[there + k] = scratch[here + k]
        return found, least, most

    @ti.func
    def load_velocity(x, dt, loads: ti.template(), n_loads):
        """Velocity that the local loads add at a node."""
        v = ti.Vector.zero(real, dim)
        for j in range(n_loads):
            d2 = ti.cast(0.0, real)
            for a in ti.static(range(dim)):
                d2 += (x[a] - ti.cast(loads[j, a], real)) ** 2
            if d2 < ti.cast(loads[j, dim], real) ** 2:
                for a in ti.static(range(dim)):
                    v[a] += dt * ti.cast(loads[j, dim + 1 + a], real)
        return v

    @ti.func
    def wall_contact(v, wall, code, friction):
        """Velocity of a node after the terrain."""
        if wall[3] < ON_SURFACE:
            normal = ti.Vector([wall[a] for a in ti.static(range(dim))])
            v = contact_velocity(v, normal, code, friction)
        return v

    @ti.func
    def side_contact(v, x, sides: ti.template()):
        """Velocity of a node after the sides of the domain."""
        for a in ti.static(range(dim)):
            for side in ti.static(range(2)):
                sign = ti.static(1 - 2 * side)
                code = ti.cast(sides[a, side, 1], ti.i32)
                if code != OPEN and sign * (x[a] - ti.cast(sides[a, side, 0], real)) <= 0.0:
                    v = contact_velocity(v, ti.Vector.unit(dim, a, real) * sign, code, 0.0)
        return v

    @ti.func
    def reaches_side(corner, sides: ti.template()):
        """Whether a node of the block with this first node lies on or beyond a side that is not open."""
        reaches = 0
        for a in ti.static(range(dim)):
            for side in ti.static(range(2)):
                sign = ti.static(1 - 2 * side)
                at = corner[a] + ti.static((edge - 1) * side)
                if sides[a, side, 1] != OPEN and sign * (at - ti.cast(sides[a, side, 0], real)) <= 0.0:
                    reaches = 1
        return reaches

    @ti.kernel
    def update_grid(tiles: ti.types.ndarray(dtype=vec4, ndim=1), impulses: ti.types.ndarray(dtype=vec4, ndim=1),
                    boxes: ti.types.ndarray(), scratch: ti.types.ndarray(dtype=vec4, ndim=1),
                    first_tile: ti.types.ndarray(), tiles_at: ti.types.ndarray(), node_coordinates: ti.types.ndarray(),
                    wall_slot: ti.types.ndarray(), walls: ti.types.ndarray(dtype=vec4, ndim=1),
                    sides: ti.types.ndarray(), loads: ti.types.ndarray(), gravity: ti.types.ndarray(), dt: real,
                    keep: real, terrain_code: int, terrain_friction: real, impulse_of: ti.types.ndarray(),
                    total: ti.types.ndarray(), n_loads: int, n_node_blocks: int, shares: ti.types.ndarray()):
        for i in range(chunks(shares)):
            if is_worker(i):
                first, last = chunk(i, shares)
                sums = i // SPREAD * ti.static(2 * n_nodes)
                pull = ti.Vector.zero(real, dim)
                for a in ti.static(range(dim)):
                    pull[a] = ti.cast(gravity[a], real)
                for n in range(first, last):
                    impulse, friction_work = ti.Vector.zero(ti.f64, dim), ti.cast(0.0, ti.f64)
                    found, least, most = exchange(True, n, first_tile, tiles_at, boxes, scratch, sums, tiles)
                    if ti.static(flip):
                        exchange(True, n, first_tile, tiles_at, boxes, scratch, sums + n_nodes, impulses)
                    corner = ti.Vector.zero(real, dim)
                    for a in ti.static(range(dim)):
                        corner[a] = ti.cast(edge * node_coordinates[n, a], real)
                    near_side, slot = reaches_side(corner, sides), wall_slot[n]
                    near_side = ti.select(n_loads > 0, 1, near_side)
                    for ix, iy in ti.ndrange((least[0], most[0]), (least[1], most[1])):
                        for iz in range(least[2], most[2]):
                            q = (ix * edge + iy) * edge + iz
                            node, internal, wall = scratch[sums + q], vec4(0.0), vec4(1.0)
                            if node[3] > 0.0:
                                if ti.static(flip):
                                    internal = scratch[sums + n_nodes + q]
                                if ti.static(with_terrain):  # noqa: SIM102 (one is compile time)
                                    if slot != FREE:
                                        wall = walls[slot * n_nodes + q]
                                v = ti.Vector.zero(real, dim)
                                for a in ti.static(range(dim)):
                                    v[a] = (node[a] + internal[a]) / node[3]
                                v = (v + dt * pull) * keep
                                # Most nodes are free: only the others pay for their position and the sums in double.
                                if wall[3] < ON_SURFACE or near_side == 1:
                                    at = ti.Vector([ix, iy, iz])
                                    x = corner
                                    for a in ti.static(range(dim)):
                                        x[a] += ti.cast(at[3 - dim + a], real)
                                    loaded = v + load_velocity(x, dt, loads, n_loads)
                                    held_back = wall_contact(loaded, wall, terrain_code, terrain_friction)
                                    held_back = side_contact(held_back, x, sides)
                                    impulse += ti.cast(node[3] * (held_back - v), ti.f64)
                                    # Force times the velocity at the end of the step, as the scheme itself does work.
                                    friction_work += ti.cast(node[3] * (loaded - held_back).dot(held_back), ti.f64)
                                    v = held_back
                                result = vec4(0.0)
                                for a in ti.static(range(dim)):
                                    result[a] = v[a]
                                result[3] = node[3]
                                scratch[sums + q] = result
                                if ti.static(flip):
                                    scratch[sums + n_nodes + q] = result - node / node[3]
                    if found == 1:
                        exchange(False, n, first_tile, tiles_at, boxes, scratch, sums, tiles)
                        if ti.static(flip):
                            exchange(False, n, first_tile, tiles_at, boxes, scratch, sums + n_nodes, impulses)
                    for a in ti.static(range(dim)):
                        impulse_of[n, a] = impulse[a]
                    impulse_of[n, dim] = friction_work
        ti.loop_config(serialize=True)
        for n in range(n_node_blocks):
            for a in ti.static(range(dim + 1)):
                total[a] += impulse_of[n, a]

    return update_grid
