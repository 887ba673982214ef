"""The grid of MPM, stored as one overlapping tile of nodes per occupied block.

Tile b holds every node that a particle of block b can touch: nodes -1 .. EDGE + 2 of the block per axis (a
stencil of 3 nodes, a drift of one cell either way). Scatter and gather of a block touch only memory that is its own: no
colours, no atomics, one parallel loop, and sums in an order that no thread count changes. A node lies in at most two
tiles per axis; the grid update adds up its copies, advances it, and writes its velocity back to each.

What a node holds: `mpm.node`.
"""

import functools

import numpy as np
import taichi as ti

from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, in_order, is_worker, most_workers, worker
from snowmpm.compiler.runtime import DTYPES
from snowmpm.errors import SimulationError
from snowmpm.mpm.contact.contact_blocks import ContactBlocks
from snowmpm.mpm.contact.walls import FREE
from snowmpm.mpm.node import MASS, SECOND, block_nodes, node_mask, node_size, node_vector
from snowmpm.mpm.picker import picker
from snowmpm.particles.blocks import EDGE, coordinates_of, fields_of, places_of, step_along

NODE_BLOCK_COST = 2
"""Cost of a node block beside that of adding up its tiles, in tiles."""

TILE = {dim: edge + 4 for dim, edge in EDGE.items()}
"""Nodes per tile edge."""


def tile_strides(dim):
    """Distance in memory of neighbour nodes of a tile along each of three axes; 0 along the first in 2-D."""
    return [0] * (3 - dim) + [TILE[dim] ** (dim - 1 - a) for a in range(dim)]


class TileGrid:
    """Tiles of the occupied blocks, and the node blocks that they cover.

    tiles_at[i], first_tile[n] <= i < first_tile[n + 1]: a tile that holds copies of node block n, and the step to its
    block (`BlockMap.node_blocks`). active_nodes[tile]: first and one-past-last node along each of three axes that its
    particles reach, and in which node blocks these are (`report_functions`).
    nodes: scratch for the sums of a node block, one a worker, and from `contact_offset` on the nodes of the contact
    blocks (`ContactBlocks`), which stay there until every surface has acted. node_chunk_bounds: the node blocks, cut
    into chunks of about equal work. work (n_work,): the node blocks that a step visits, where not all are (`visit`);
    hiding: kernels of `hidden_nodes` where there is an interface, else None.
    asleep (tiles,): 1 for those of sleeping blocks; tiles_near_obstacles (tiles,). everyone, nobody: counted up, and
    zeros, where all is visited; listed: whether not all is.
    """

    def __init__(self, dim, precision, surfaces=(), flip=False, bodies=None, joins=False):
        """flip: nodes have two halves (`mpm.node`); bodies: `FieldPairs`, or None
        where all share one velocity field; joins: whether walls may hold their lines together (`JoinedLines`)."""
        self.dim = dim
        self.precision = precision
        self.flip = flip
        self.surfaces = list(surfaces)
        self.bodies = bodies
        self.joins = joins
        self.tiles = self.nodes = self.hiding = None
        self.contact_offset = block_nodes(dim) * most_workers()
        self.work = self.everyone = int_array([])
        self.asleep = self.nobody = int_array([])

    def rebuild(self, blocks):
        """Follow a new block map."""
        dim = self.dim
        keys, start, tiles_at = blocks.node_blocks()
        coordinates = coordinates_of(keys, dim)
        self._node_blocks = keys, coordinates, blocks.keys_of
        self._tile_table, self.n_tiles, self.n_node_blocks = (start, tiles_at), len(blocks), len(keys)
        self.rebuild_contact()
        self.node_coordinates = int_array(coordinates)
        self.first_tile, self.tiles_at = int_array(start), int_array(tiles_at)
        self.n_work = self.n_node_blocks
        if self.everyone.shape[0] < max(self.n_tiles, self.n_node_blocks):
            self.everyone = int_array(np.arange(int(1.25 * max(self.n_tiles, self.n_node_blocks)) + 8))
            self.nobody = int_array(np.zeros(self.everyone.shape[0]))
        self.work, self.asleep, self.listed = self.everyone, self.nobody, False
        self.node_chunk_bounds = int_array(chunk_bounds(np.diff(start) + NODE_BLOCK_COST))
        self.active_nodes = self._whole_tiles(self.n_tiles)
        self.tiles = self._reserved(self.tiles, self.n_tiles * TILE[dim] ** dim)

    def rebuild_contact(self):
        """Follow surfaces that have moved."""
        dim, (keys, coordinates, keys_of) = self.dim, self._node_blocks
        met, places = False, places_of(keys, dim)
        if self.bodies:
            _, place, count = np.unique(places, return_inverse=True, return_counts=True)
            met = (count[place] > 1) | np.isin(fields_of(keys, dim), self.bodies.everywhere)
        self.contact = ContactBlocks(keys, coordinates, self.surfaces, keys_of, met)
        if self.bodies and self.bodies.everywhere:
            self.contact.part_fields(fields_of(keys, dim))
        if self.bodies:
            self.bodies.rebuild(places, fields_of(keys, dim), self.contact.index_of)
        self.nodes = self._reserved(self.nodes, self.contact_offset + block_nodes(dim) * self.contact.n)
        for surface, slots, active in zip(self.surfaces, self.contact.slots, self.contact.active, strict=True):
            if active:
                surface.prepare(self, slots)
        self.tiles_near_obstacles = self._near_obstacles()

    def _near_obstacles(self):
        """Tiles (n_tiles,) that hold nodes near an obstacle."""
        if not any(surface.tracked for surface in self.surfaces):
            return np.zeros(self.n_tiles, bool)
        near = np.zeros(self.n_node_blocks, bool)
        for surface, slots in zip(self.surfaces, self.contact.of_surface, strict=True):
            if surface.tracked:
                near |= slots != FREE
        return self.tiles_around(np.flatnonzero(near))

    def held_blocks(self, asleep, names):
        """Of the node blocks that tiles of awake and of sleeping blocks reach: numbers, keys, and the sums of `names`
        (n_tiles,) over the sleeping ones, which tell one pattern of them from another."""
        start, tiles_at = self._tile_table
        sums = np.add.reduceat(np.where(asleep, names, 0)[tiles_at[:, 0]], start[:-1])
        awake = np.logical_or.reduceat(~asleep[tiles_at[:, 0]], start[:-1])
        chosen = np.flatnonzero(awake & (sums != 0))
        return chosen, self._node_blocks[0][chosen], sums[chosen]

    def tiles_around(self, numbers):
        """Tiles (n_tiles,) that reach node blocks of these numbers."""
        start, tiles_at = self._tile_table
        near, found = np.zeros(self.n_node_blocks, bool), np.zeros(self.n_tiles, bool)
        near[numbers] = True
        found[tiles_at[np.repeat(near, np.diff(start)), 0]] = True
        return found

    def visit(self, asleep):
        """Leave out the node blocks that only tiles of sleeping blocks reach; asleep (n_tiles,). -> contact blocks that
        have to be emptied."""
        start, tiles_at = self._tile_table
        reached = np.logical_or.reduceat(~asleep[tiles_at[:, 0]], start[:-1]) if len(tiles_at) else np.zeros(0, bool)
        work, self.listed = np.flatnonzero(reached), bool(asleep.any())
        self.work, self.n_work, self.asleep = int_array(work), len(work), int_array(asleep)
        self.node_chunk_bounds = int_array(chunk_bounds(np.diff(start)[work] + NODE_BLOCK_COST))
        return self.contact.visit(reached)

    def apply_contact(self, dx, but=()):
        """Apply the contact of bodies that meet, then of every surface, to the nodes of the contact blocks; but:
        surfaces that are only found, in the order in which they are to act."""
        if self.bodies:
            self.bodies.apply_contact(self, dx)
        hidden = self.hiding is not None
        if hidden:
            self._turn_hidden(0)
        for surface, active in zip(self.surfaces, self.contact.active, strict=True):
            if hidden and surface.tracked:  # obstacles come last
                hidden = self._turn_hidden(1)
            if active:
                surface.locate(self)
                if surface not in but:
                    surface.apply_contact(self, dx)

        if hidden:
            self._turn_hidden(1)

    def _turn_hidden(self, which):
        """Hide marked nodes from the surfaces that follow, or show them again; -> False: none is hidden."""
        self.hiding[which](self.nodes, self.contact_offset, block_nodes(self.dim) * self.contact.n)
        return False

    def acts(self, surface):
        """Whether a surface is near any snow."""
        return self.contact.active[self.surfaces.index(surface)]

    def _reserved(self, array, nodes):
        """An array with room for that many nodes: the old one when it is large enough."""
        if array is not None and array.shape[0] >= nodes:
            return array
        most = node_mask(self.flip)
        if nodes > most:
            raise SimulationError(f"the grid needs {nodes:,} nodes; {most:,} at most fit the 32-bit indices of "
                                  "Taichi's arrays; choose a larger solver.dx")
        capacity = min(int(1.25 * nodes) + 64, most)
        return ti.ndarray(node_vector(DTYPES[self.precision][0], self.flip), (capacity,))

    def _whole_tiles(self, n):
        """Active nodes that leave none of a tile out, until the particles tell which ones they reach."""
        flat = 3 - self.dim
        return int_array(np.broadcast_to([0] * 3 + [1] * flat + [TILE[self.dim]] * self.dim + [-1], (n, 7)))

    @property
    def bytes(self):
        """Memory of tiles, surfaces and tables."""
        real = np.dtype(DTYPES[self.precision][1]).itemsize
        numbers = node_size(self.flip) * (self.tiles.shape[0] + self.nodes.shape[0])
        numbers += sum(4 * surface.geometry.array.shape[0] for surface in self.surfaces if surface.geometry.stored)
        tables = self.first_tile, self.tiles_at, self.node_coordinates, self.active_nodes
        integers = sum(np.prod(table.shape) for table in tables)
        return real * numbers + 4 * int(integers) + sum(surface.bytes for surface in self.surfaces)


@functools.cache
def grid_kernels(dim, real, flip, serial, sleeping=False):
    """`update_grid` advances the nodes: v = p / m + dt g, loads; `write_back` hands contact blocks back to the tiles.

    The velocity replaces the momentum; contact blocks (`ContactBlocks`) keep theirs until surfaces have acted.

    flip: nodes have a second half (`mpm.node`); serial: by one thread;
    sleeping: tiles that are `asleep` count for nothing, and the nodes that their particles reach are held at rest
    (`mpm.sleep`), by the impulse `held` for all; held_of: a part of it, and all, on each node block; `work` names the
    blocks to visit.

    A node block adds up what the tiles around it hold of it, in the order of the steps to them, in a scratch block of
    its worker that stays in the nearest cache, advances its nodes, and writes them back to the tiles; only the boxes
    of active nodes are touched. In 2-D the first of three axes is one node wide.
    """
    edge, tile_edge = EDGE[dim], TILE[dim]
    of_node, mask = node_vector(real, flip), node_mask(flip)
    n_nodes = block_nodes(dim)
    stride = tile_strides(dim)
    pick = picker(sleeping)

    @ti.func
    def common_box(active_nodes: ti.template(), tile, step):
        """First and one-past-last of a block's nodes in the box of the tile one step from it; where its node 0 is."""
        first, last, address = ti.Vector([0, 0, 0]), ti.Vector([1, 1, 1]), tile * tile_edge**dim
        for a in ti.static(range(3 - dim, 3)):
            to_tile = 1 - edge * step_along(step, a + dim - 3)
            first[a] = ti.max(0, active_nodes[tile, a] - to_tile)
            last[a] = ti.min(edge, active_nodes[tile, 3 + a] - to_tile)
            address += to_tile * ti.static(stride[a])
        return first, last, address

    @ti.func
    def exchange(gathering: ti.template(), n, first_tile: ti.template(), tiles_at: ti.template(),
                 active_nodes: ti.template(), nodes: ti.template(), sums, tiles: ti.template(),
                 asleep: ti.template()):
        """Add a node block's copies up in `nodes`, or write them back; -> whether there are any, and the box of nodes
        that holds them."""
        found, least, most = 0, ti.Vector([edge, edge, edge]), ti.Vector([0, 0, 0])
        for e in range(first_tile[n], first_tile[n + 1]):
            tile, step = tiles_at[e, 0], tiles_at[e, 1]
            counts = active_nodes[tile, 6] & step == step  # most tiles around do not come here
            if ti.static(sleeping):
                counts = counts & (asleep[tile] == 0)
            if counts:
                first, last, address = common_box(active_nodes, tile, step)
                if ti.static(gathering):
                    if found == 0:
                        for q in range(n_nodes):
                            nodes[sums + q] = of_node(0.0)
                    least, most = ti.min(least, first), ti.max(most, last)
                found = 1
                wide = last[1] - first[1]  # one loop over rows: two in each other take four times as long to compile
                i, j = first[0], first[1]
                for _row in range((last[0] - first[0]) * wide):
                    here = (sums + (i * edge + j) * edge) & mask
                    there = address + i * ti.static(stride[0]) + j * ti.static(stride[1])
                    for k in ti.static(range(edge)):
                        if k >= first[2] and k < last[2]:
                            if ti.static(gathering):
                                nodes[here + k] = nodes[here + k] + tiles[there + k]
                            else:
                                tiles[there + k] = nodes[here + k]
                    j += 1
                    if j == last[1]:
                        i, j = i + 1, first[1]
        return found, least, most

    @ti.func
    def hold(n, first_tile: ti.template(), tiles_at: ti.template(), active_nodes: ti.template(),
             nodes: ti.template(), sums, asleep: ti.template(), changes: ti.template()):
        """Stop the nodes of a block that sleeping particles reach; -> the impulse of that. changes: FLIP's changes of
        velocity are there already, and follow."""
        held = ti.Vector.zero(ti.f64, dim)
        for e in range(first_tile[n], first_tile[n + 1]):
            if asleep[tiles_at[e, 0]] == 1:
                first, last, _address = common_box(active_nodes, tiles_at[e, 0], tiles_at[e, 1])
                for i, j in ti.ndrange((first[0], last[0]), (first[1], last[1])):
                    for k in range(first[2], last[2]):
                        q = sums + (i * edge + j) * edge + k
                        node = nodes[q]
                        if node[MASS] > 0.0:
                            for a in ti.static(range(dim)):
                                held[a] -= ti.cast(node[MASS] * node[a], ti.f64)
                                if ti.static(changes):
                                    node[SECOND + a] -= node[a]
                                node[a] = 0.0
                            nodes[q] = node
        return held

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

    @taichi_kernel
    def update_grid(tiles: ti.types.ndarray(dtype=of_node, ndim=1), active_nodes: ti.types.ndarray(),
                    nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int,
                    first_tile: ti.types.ndarray(), tiles_at: ti.types.ndarray(), node_coordinates: ti.types.ndarray(),
                    contact: ti.types.ndarray(), loads: ti.types.ndarray(), gravity: ti.types.ndarray(), dt: real,
                    damping_factor: real, impulse_of: ti.types.ndarray(), total: ti.types.ndarray(), n_loads: int,
                    n_node_blocks: int, chunk_bounds: ti.types.ndarray(), work: ti.types.ndarray(),
                    asleep: ti.types.ndarray(), held_of: ti.types.ndarray(), held: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                g = ti.Vector.zero(real, dim)
                for a in ti.static(range(dim)):
                    g[a] = ti.cast(gravity[a], real)
                for w in range(first, last):
                    n = pick(work, w)
                    impulse = ti.Vector.zero(ti.f64, dim)
                    touching = contact[n]
                    sums = ti.select(touching >= 0, contact_offset + touching * n_nodes, worker(i) * n_nodes)
                    found, least, most = exchange(True, n, first_tile, tiles_at, active_nodes, nodes, sums, tiles,
                                                  asleep)
                    if touching >= 0 and found == 0:
                        for q in range(n_nodes):
                            nodes[sums + q] = of_node(0.0)
                    ix, iy = least[0], least[1]
                    for _row in range((most[0] - least[0]) * (most[1] - least[1])):
                        for iz in range(least[2], most[2]):
                            q = (ix * edge + iy) * edge + iz
                            node = nodes[sums + q]
                            if node[MASS] > 0.0:
                                v, per_mass = ti.Vector.zero(real, dim), 1.0 / node[MASS]
                                for a in ti.static(range(dim)):
                                    if ti.static(flip):
                                        v[a] = (node[a] + node[SECOND + a]) * per_mass
                                    else:
                                        v[a] = node[a] * per_mass
                                v = (v + dt * g) * damping_factor
                                if n_loads > 0:
                                    at, x = ti.Vector([ix, iy, iz]), ti.Vector.zero(real, dim)
                                    for a in ti.static(range(dim)):
                                        x[a] = ti.cast(edge * node_coordinates[n, a] + at[3 - dim + a], real)
                                    gained = load_velocity(x, dt, loads, n_loads)
                                    impulse += ti.cast(node[MASS] * gained, ti.f64)
                                    v += gained
                                for a in ti.static(range(dim)):
                                    if ti.static(flip):
                                        before = node[a] / node[MASS]
                                        node[SECOND + a] = ti.select(touching >= 0, before, v[a] - before)
                                    node[a] = v[a]
                                nodes[sums + q] = node
                        iy += 1
                        if iy == most[1]:
                            ix, iy = ix + 1, least[1]
                    if ti.static(sleeping):
                        stopped = ti.Vector.zero(ti.f64, dim)
                        if found == 1 and touching < 0:
                            stopped = hold(n, first_tile, tiles_at, active_nodes, nodes, sums, asleep, flip)
                        elif found == 1:
                            stopped = hold(n, first_tile, tiles_at, active_nodes, nodes, sums, asleep, False)
                        for a in ti.static(range(dim)):
                            held_of[n, a], held_of[n, dim + a] = stopped[a], stopped[a]
                    if found == 1 and touching < 0:
                        exchange(False, n, first_tile, tiles_at, active_nodes, nodes, sums, tiles, asleep)
                    for a in ti.static(range(dim)):
                        impulse_of[n, a] = impulse[a]
        ti.loop_config(serialize=ti.static(in_order()))
        for w in range(n_node_blocks):
            n = pick(work, w)
            for a in ti.static(range(dim)):
                total[a] += impulse_of[n, a]
                if ti.static(sleeping):
                    held[a] += held_of[n, a]

    @taichi_kernel
    def write_back(tiles: ti.types.ndarray(dtype=of_node, ndim=1), active_nodes: ti.types.ndarray(),
                   nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int,
                   first_tile: ti.types.ndarray(), tiles_at: ti.types.ndarray(), node_block: ti.types.ndarray(),
                   chunk_bounds: ti.types.ndarray(), work: ti.types.ndarray(), n_work: int, asleep: ti.types.ndarray(),
                   held_of: ti.types.ndarray(), held: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                for w in range(first, last):
                    c = pick(work, w)
                    sums, n = contact_offset + c * n_nodes, node_block[c]
                    if ti.static(sleeping):
                        stopped = hold(n, first_tile, tiles_at, active_nodes, nodes, sums, asleep, False)
                        for a in ti.static(range(dim)):
                            held_of[n, a] = stopped[a]
                            held_of[n, dim + a] += stopped[a]
                    if ti.static(flip):
                        for q in range(n_nodes):
                            node = nodes[sums + q]
                            for a in ti.static(range(dim)):
                                node[SECOND + a] = node[a] - node[SECOND + a]
                            nodes[sums + q] = node
                    exchange(False, n, first_tile, tiles_at, active_nodes, nodes, sums, tiles, asleep)
        if ti.static(sleeping):
            ti.loop_config(serialize=ti.static(in_order()))
            for w in range(n_work):
                for a in ti.static(range(dim)):
                    held[a] += held_of[node_block[pick(work, w)], a]

    return update_grid, write_back
