"""The update of the grid: nodes advance, v = p / m + dt g and loads, and contact blocks go back to their tiles."""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker, worker
from snowmpm.mpm.grid import TILE, tile_strides
from snowmpm.mpm.node import MASS, SECOND, block_nodes, node_mask, node_vector
from snowmpm.particles.blocks import EDGE, step_along


class GridArrays(NamedTuple):
    """Tiles and their active nodes; node blocks, of which those in contact begin at offset; tiles around each block."""

    tiles: Array
    active_nodes: Array
    nodes: Array
    offset: int
    first_tile: Array
    tiles_at: Array


class Blocks(NamedTuple):
    """Coordinates of node blocks, and number of each among the contact blocks, -1 outside."""

    coordinates: Array
    contact: Array


class Step(NamedTuple):
    """gravity (dim) [m/s2]; loads, of which n_loads rows count; dt [s]; damping: factor of the velocities."""

    gravity: Array
    loads: Array
    n_loads: int
    dt: Real
    damping: Real


@functools.cache
def grid_kernels(dim, real, flip, serial):
    """`update_grid` advances the nodes: v = p / m + dt g, loads; `write_back` hands contact blocks back to the tiles.

    The velocity replaces the momentum; contact blocks (`ContactBlocks`) keep theirs until surfaces have acted.

    flip: nodes have a second half (`mpm.node`); serial: by one thread.

    A node block adds up what the tiles around it hold of it, in the order of the steps to them, in a scratch block of
    its worker that stays in the nearest cache, advances its nodes, and writes them back to the tiles; only the boxes
    of active nodes are touched. In 2-D the first of three axes is one node wide.
    """
    edge, tile_edge = EDGE[dim], TILE[dim]
    of_node, mask = node_vector(real, flip), node_mask(flip)
    n_nodes = block_nodes(dim)
    stride = tile_strides(dim)

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
    def exchange(gathering: ti.template(), n, grid: ti.template(), sums):
        """Add a node block's copies up in `nodes`, or write them back; -> whether there are any, and the box of nodes
        that holds them."""
        found, least, most = 0, ti.Vector([edge, edge, edge]), ti.Vector([0, 0, 0])
        for e in range(grid.first_tile[n], grid.first_tile[n + 1]):
            tile, step = grid.tiles_at[e, 0], grid.tiles_at[e, 1]
            if grid.active_nodes[tile, 6] & step == step:  # most tiles around do not come here
                first, last, address = common_box(grid.active_nodes, tile, step)
                if ti.static(gathering):
                    if found == 0:
                        for q in range(n_nodes):
                            grid.nodes[sums + q] = of_node(0.0)
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
                                grid.nodes[here + k] = grid.nodes[here + k] + grid.tiles[there + k]
                            else:
                                grid.tiles[there + k] = grid.nodes[here + k]
                    j += 1
                    if j == last[1]:
                        i, j = i + 1, first[1]
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

    @grouped_kernel(real)
    def update_grid(grid: GridArrays, blocks: Blocks, step: Step, impulse_of: Array, total: Array, n_node_blocks: int,
                    chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                g = ti.Vector.zero(real, dim)
                for a in ti.static(range(dim)):
                    g[a] = ti.cast(step.gravity[a], real)
                for n in range(first, last):
                    impulse = ti.Vector.zero(ti.f64, dim)
                    touching = blocks.contact[n]
                    sums = ti.select(touching >= 0, grid.offset + touching * n_nodes, worker(i) * n_nodes)
                    found, least, most = exchange(True, n, grid, sums)
                    if touching >= 0 and found == 0:
                        for q in range(n_nodes):
                            grid.nodes[sums + q] = of_node(0.0)
                    ix, iy = least[0], least[1]
                    for _row in range((most[0] - least[0]) * (most[1] - least[1])):
                        for iz in range(least[2], most[2]):
                            q = (ix * edge + iy) * edge + iz
                            node = grid.nodes[sums + q]
                            if node[MASS] > 0.0:
                                v, per_mass = ti.Vector.zero(real, dim), 1.0 / node[MASS]
                                for a in ti.static(range(dim)):
                                    if ti.static(flip):
                                        v[a] = (node[a] + node[SECOND + a]) * per_mass
                                    else:
                                        v[a] = node[a] * per_mass
                                v = (v + step.dt * g) * step.damping
                                if step.n_loads > 0:
                                    at, x = ti.Vector([ix, iy, iz]), ti.Vector.zero(real, dim)
                                    for a in ti.static(range(dim)):
                                        x[a] = ti.cast(edge * blocks.coordinates[n, a] + at[3 - dim + a], real)
                                    gained = load_velocity(x, step.dt, step.loads, step.n_loads)
                                    impulse += ti.cast(node[MASS] * gained, ti.f64)
                                    v += gained
                                for a in ti.static(range(dim)):
                                    if ti.static(flip):
                                        before = node[a] / node[MASS]
                                        node[SECOND + a] = ti.select(touching >= 0, before, v[a] - before)
                                    node[a] = v[a]
                                grid.nodes[sums + q] = node
                        iy += 1
                        if iy == most[1]:
                            ix, iy = ix + 1, least[1]
                    if found == 1 and touching < 0:
                        exchange(False, n, grid, sums)
                    for a in ti.static(range(dim)):
                        impulse_of[n, a] = impulse[a]
        ti.loop_config(serialize=ti.static(in_order()))
        for n in range(n_node_blocks):
            for a in ti.static(range(dim)):
                total[a] += impulse_of[n, a]

    @grouped_kernel(real)
    def write_back(grid: GridArrays, node_block: Array, chunk_bounds: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                for c in range(first, last):
                    sums, n = grid.offset + c * n_nodes, node_block[c]
                    if ti.static(flip):
                        for q in range(n_nodes):
                            node = grid.nodes[sums + q]
                            for a in ti.static(range(dim)):
                                node[SECOND + a] = node[a] - node[SECOND + a]
                            grid.nodes[sums + q] = node
                    exchange(False, n, grid, sums)

    return update_grid, write_back
