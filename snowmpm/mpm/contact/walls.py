"""Where a surface at rest is at the nodes of the grid, kept for the node blocks near it."""

from typing import Any

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.node_copy import copy_kernel
from snowmpm.particles.blocks import EDGE

NEAR = 1.75
"""Cells above the surface up to which a node has to do with it: leaders of lines lie there (`wall_contact`)."""

FREE = -1
"""Slot of a node block that has nothing to do with the surface."""


class Walls:
    """Outward normal and signed distance to a surface [cells] at each node of the node blocks met so far.

    Only blocks near it take a slot in `array`: most blocks are free air, and need nothing. The surface does not move,
    so what is known stays known, and memory goes with the ground that the snow has reached.
    """

    stored = True

    def __init__(self, dim, precision, wall_distance):
        """wall_distance(nodes (k, dim) in cells) -> distance [cells] (k,), normal (k, dim)."""
        self.dim, self.wall_distance = dim, wall_distance
        self._real, self._dtype = DTYPES[precision]
        self._n_nodes = EDGE[dim] ** dim
        self._keys = np.zeros(0, np.int64)
        self._slots = np.zeros(0, np.int32)
        self._used = 0
        self.array = self._allocate(64)

    def distance(self, points):
        """Signed distance [cells] at points (k, dim) [cells]."""
        return self.wall_distance(points)[0]

    def _allocate(self, slots):
        """Array of (normal, distance) of the nodes of `slots` blocks, 4 numbers a node."""
        return ti.ndarray(ti.types.vector(4, self._real), (slots * self._n_nodes,))

    def slots(self, keys, coordinates):
        """Slot of each node block, or FREE; keys sorted (n,), coordinates (n, dim)."""
        at = np.searchsorted(self._keys, keys)
        known = np.zeros(len(keys), bool)
        inside = at < len(self._keys)
        known[inside] = self._keys[at[inside]] == keys[inside]
        slots = np.empty(len(keys), np.int32)
        slots[known] = self._slots[at[known]]
        if not known.all():
            slots[~known] = self._learn(coordinates[~known])
            self._keys = np.insert(self._keys, at[~known], keys[~known])
            self._slots = np.insert(self._slots, at[~known], slots[~known])
        return slots

    def _learn(self, coordinates):
        """Ask the surface for normal and distance at the nodes of new blocks, and keep those of blocks near it.

        coordinates (n, dim): of node blocks not met before. Returns their slots (n,); FREE where no node of a block is
        within NEAR of the surface.
        """
        dim, edge = self.dim, EDGE[self.dim]
        nodes = np.stack(np.meshgrid(*[np.arange(edge)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        points = (edge * coordinates[:, None] + nodes).reshape(-1, dim)
        distance, normal = self.wall_distance(points.astype(np.float64))
        walls: Any = np.zeros((len(points), 4), self._dtype)
        walls[:, :dim], walls[:, 3] = normal, distance
        walls = walls.reshape(len(coordinates), self._n_nodes, 4)
        solid = (walls[:, :, 3] < NEAR).any(axis=1)
        slots = np.full(len(coordinates), FREE, np.int32)
        slots[solid] = self._used + np.arange(solid.sum())
        self._append(walls[solid])
        return slots

    def _append(self, walls):
        """Put walls (k, nodes, 4) in the next k slots; an array that is too small is replaced."""
        first, end = self._used * self._n_nodes, (self._used + len(walls)) * self._n_nodes
        if end > self.array.shape[0]:
            old, self.array = self.array, self._allocate(2 * (self._used + len(walls)))
            copy_kernel(4, self._real)(old, 0, self.array, 0, first)
        if len(walls):
            fresh = ti.ndarray(ti.types.vector(4, self._real), (end - first,))
            fresh.from_numpy(walls.reshape(-1, 4))
            copy_kernel(4, self._real)(fresh, 0, self.array, first, end - first)
        self._used += len(walls)
