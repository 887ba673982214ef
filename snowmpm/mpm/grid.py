"""The grid of MPM, stored as one overlapping tile of nodes per occupied block.

Tile b holds every node that a particle of block b can touch: nodes -1 .. EDGE + 2 of the block per axis (a
stencil of 3 nodes, a drift of one cell either way). Scatter and gather of a block touch only memory that is its own: no
colours, no atomics, one parallel loop, and sums in an order that no thread count changes. A node lies in at most two
tiles per axis; the grid update adds up its copies, advances it, and writes its velocity back to each.

What a node holds: `mpm.node`.
"""

from collections import defaultdict
from typing import Any

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import Rows, int_array
from snowmpm.compiler.parallel import chunk_bounds, most_workers
from snowmpm.compiler.runtime import DTYPES
from snowmpm.errors import SimulationError
from snowmpm.mpm.contact.contact_blocks import ContactBlocks
from snowmpm.mpm.node import block_nodes, node_mask, node_size, node_vector
from snowmpm.particles.blocks import EDGE, coordinates_of, fields_of, places_of
from snowmpm.stepping.component import NONE

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
    into chunks of about equal work.
    """

    def __init__(self, dim, precision, surfaces=(), flip=False, fields=None, joins=False, adapters=NONE):
        """flip: nodes have two halves (`mpm.node`); fields: `FieldPairs`, or None where all share one velocity field;
        joins: whether walls may hold their lines together (`JoinedLines`); adapters: of the components at work."""
        self.dim = dim
        self.precision = precision
        self.flip = flip
        self.surfaces = list(surfaces)
        self.fields = fields
        self.joins = joins
        self.adapters = adapters
        self.tiles: Any = None
        self.nodes: Any = None
        self.contact: Any = None
        self._rows = defaultdict(Rows)
        self.contact_offset = block_nodes(dim) * most_workers()

    def rebuild(self, blocks):
        """Follow a new block map."""
        dim = self.dim
        keys, start, tiles_at = blocks.node_blocks()
        coordinates = coordinates_of(keys, dim)
        self._node_blocks = keys, coordinates, blocks.keys_beside
        self.n_tiles, self.n_node_blocks = len(blocks), len(keys)
        self.rebuild_contact()
        rows = self._rows
        self.node_coordinates = rows["node_coordinates"].filled(coordinates)
        self.first_tile, self.tiles_at = rows["first_tile"].filled(start), rows["tiles_at"].filled(tiles_at)
        self.node_chunk_bounds = int_array(chunk_bounds(np.diff(start) + NODE_BLOCK_COST))
        self.active_nodes = self._whole_tiles(self.n_tiles)
        self.tiles = self._reserved(self.tiles, self.n_tiles * TILE[dim] ** dim)

    def rebuild_contact(self):
        """Follow surfaces that have moved."""
        dim, (keys, coordinates, keys_beside) = self.dim, self._node_blocks
        met: Any = False
        places = places_of(keys, dim)
        if self.fields:
            _, place, count = np.unique(places, return_inverse=True, return_counts=True)
            met = (count[place] > 1) | np.isin(fields_of(keys, dim), self.fields.everywhere)
        self.contact = ContactBlocks(keys, coordinates, self.surfaces, keys_beside, met, self.contact)
        if self.fields and self.fields.everywhere:
            self.contact.part_fields(fields_of(keys, dim))
        if self.fields:
            self.fields.rebuild(places, fields_of(keys, dim), self.contact.index_of)
        self.nodes = self._reserved(self.nodes, self.contact_offset + block_nodes(dim) * self.contact.n)
        for surface, slots, active in zip(self.surfaces, self.contact.slots, self.contact.active, strict=True):
            if active:
                surface.prepare(self, slots)

    def apply_contact(self, dx, but=()):
        """Apply the contact of bodies that meet, then of every surface, to the nodes of the contact blocks; but:
        surfaces that are only found, in the order in which they are to act."""
        if self.fields:
            self.fields.apply_contact(self, dx)
        for act in self.adapters.before_ground:
            act(self)
        self._meet([surface for surface in self.surfaces if not surface.tracked], dx, but)
        for act in self.adapters.after_ground:
            act(self)
        self._meet([surface for surface in self.surfaces if surface.tracked], dx, but)

    def _meet(self, surfaces, dx, but):
        for surface in surfaces:
            if self.acts(surface):
                surface.locate(self)
                if surface not in but:
                    if surface.tracked:
                        for act in self.adapters.before_obstacle:
                            act(self, surface)
                    surface.apply_contact(self, dx)
                    if surface.tracked:
                        for act in self.adapters.after_obstacle:
                            act(self, surface)

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
        return self._rows["active_nodes"].filled(
            np.broadcast_to([0] * 3 + [1] * flat + [TILE[self.dim]] * self.dim + [-1], (n, 7)))

    @property
    def bytes(self):
        """Memory of tiles, surfaces and tables."""
        real = np.dtype(DTYPES[self.precision][1]).itemsize
        numbers = node_size(self.flip) * (self.tiles.shape[0] + self.nodes.shape[0])
        numbers += sum(4 * surface.geometry.array.shape[0] for surface in self.surfaces if surface.geometry.stored)
        tables = self.first_tile, self.tiles_at, self.node_coordinates, self.active_nodes
        integers = sum(np.prod(table.shape) for table in tables)
        return real * numbers + 4 * int(integers) + sum(surface.bytes for surface in self.surfaces)
