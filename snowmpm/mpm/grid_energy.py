"""Kinetic energy of the grid: what the nodes see of the motion of the particles."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.runtime import DTYPES, precision
from snowmpm.mpm.grid import TILE, tile_strides
from snowmpm.mpm.node import MASS, SECOND, node_vector
from snowmpm.particles.blocks import EDGE, step_along


def grid_kinetic_energy(grid):
    """sum p_i^2 / 2 m_i over the nodes of a `TileGrid` whose tiles hold momentum and mass [J]."""
    found = np.zeros(grid.n_node_blocks)
    with precision(grid.precision):
        add_up = _kernel(grid.dim, DTYPES[grid.precision][0], grid.flip)
        add_up(grid.tiles, grid.active_nodes, grid.first_tile, grid.tiles_at, found)
    return float(found.sum())


@functools.cache
def _kernel(dim, real, flip):
    """Kernel that finds the energy of each node block; a node adds up what the tiles around it hold of it."""
    edge, size, stride = EDGE[dim], TILE[dim], tile_strides(dim)
    of_node = node_vector(real, flip)

    @taichi_kernel
    def add_up(tiles: ti.types.ndarray(dtype=of_node, ndim=1), active_nodes: ti.types.ndarray(),
               first_tile: ti.types.ndarray(), tiles_at: ti.types.ndarray(), energy_of: ti.types.ndarray()):
        for n in range(energy_of.shape[0]):
            total = ti.cast(0.0, ti.f64)
            for q in range(ti.static(edge**dim)):
                node = ti.Vector.zero(ti.f64, SECOND)
                for e in range(first_tile[n], first_tile[n + 1]):
                    tile, inside = tiles_at[e, 0], 1
                    address = tile * ti.static(size**dim)
                    for a in ti.static(range(dim)):
                        i = q // ti.static(edge ** (dim - 1 - a)) % edge + 1 - edge * step_along(tiles_at[e, 1], a)
                        if i < active_nodes[tile, 3 - dim + a] or i >= active_nodes[tile, 6 - dim + a]:
                            inside = 0
                        address += i * ti.static(stride[3 - dim + a])
                    if inside == 1:
                        found = tiles[address]
                        for c in ti.static(range(SECOND)):
                            node[c] += ti.cast(found[c], ti.f64)
                if node[MASS] > 0.0:
                    square = ti.cast(0.0, ti.f64)
                    for a in ti.static(range(dim)):
                        square += node[a] * node[a]
                    total += 0.5 * square / node[MASS]
            energy_of[n] = total

    return add_up
