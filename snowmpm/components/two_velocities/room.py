"""How much of the volume of a node lies between walls: room for grains and water."""

import numpy as np

from snowmpm.mpm.kernel_api import FREE, block_nodes
from snowmpm.particles.blocks import EDGE


def share_above(distance):
    """Share of a node's quadratic spline above a plane wall, by the node's signed distance from it [cells]."""
    d = np.clip(distance, -1.5, 1.5)
    inner = 0.5 + 0.75 * d - d**3 / 3.0
    return np.where(d < -0.5, (d + 1.5) ** 3 / 6.0, np.where(d > 0.5, 1.0 - (1.5 - d) ** 3 / 6.0, inner))


def free_shares(grid):
    """Share of each node of the contact blocks (n nodes,) of a `TileGrid` that lies before all surfaces at rest; those
    that move count as if they were not there."""
    contact, n_nodes = grid.contact, block_nodes(grid.dim)
    blocks = contact.node_block.to_numpy()[: contact.n]
    share = np.ones((len(blocks), n_nodes))
    for surface, slots, active in zip(grid.surfaces, contact.of_surface, contact.active, strict=True):
        if active and not surface.moving:
            near = slots[blocks] != FREE
            share[near] *= share_above(_distances(surface.geometry, grid, blocks[near], slots[blocks][near], n_nodes))
    return share.ravel()


def _distances(geometry, grid, blocks, slots, n_nodes):
    """Signed distances (k, nodes) [cells] of the nodes of some node blocks, `slots` being theirs."""
    if geometry.stored:
        return geometry.array.to_numpy()[:, 3].reshape(-1, n_nodes)[slots]
    edge = EDGE[grid.dim]
    along = np.arange(n_nodes) // edge ** (grid.dim - 1 - geometry.axis) % edge
    first = edge * grid.node_coordinates.to_numpy()[blocks, geometry.axis]
    return geometry.sign * (first[:, None] + along - geometry.level)
