"""The particles and grid nodes of an MPM solver, read and overwritten."""

import numpy as np

from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import SECOND
from snowmpm.particles.blocks import EDGE


def put(solver, **columns):
    """Overwrite columns of the particles."""
    table = solver.particles.table()
    for name, values in columns.items():
        table[:, solver.particles.layout.columns(name)] = values
    solver.particles.overwrite(table)


def node_places(solver):
    """Scene coordinates of every node of every tile, (n_tiles, nodes, dim)."""
    nodes = np.stack(np.meshgrid(*[np.arange(TILE[solver.dim]) - 1] * solver.dim, indexing="ij"), axis=-1)
    corner = EDGE[solver.dim] * solver.particles.blocks.coordinates
    return solver.frame.origin + solver.dx * (corner[:, None, :] + nodes.reshape(-1, solver.dim))


def tiles_of(solver, second=False):
    """Copy of the tiles in use, (n_tiles, nodes, 4), or of the second half of their nodes (`mpm.node`)."""
    n, half = solver.grid.n_tiles * TILE[solver.dim] ** solver.dim, slice(SECOND, None) if second else slice(SECOND)
    return solver.grid.tiles.to_numpy()[:n, half].reshape(solver.grid.n_tiles, -1, SECOND)


def in_boxes(solver):
    """Which nodes of the tiles the particles reach; beyond them a tile holds anything."""
    box = solver.grid.active_nodes.to_numpy()[: solver.grid.n_tiles, :6].reshape(-1, 1, 2, 3)[..., 3 - solver.dim :]
    nodes = np.array(list(np.ndindex(*[TILE[solver.dim]] * solver.dim)))
    return ((nodes >= box[:, :, 0]) & (nodes < box[:, :, 1])).all(axis=-1)
