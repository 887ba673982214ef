"""The node blocks that a surface may touch: their sums stay in memory of their own while surfaces act on them."""

from collections import defaultdict
from typing import Any

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import Rows, int_array
from snowmpm.compiler.parallel import chunk_bounds
from snowmpm.mpm.contact.contact_node import N_TOTALS
from snowmpm.mpm.contact.walls import FREE


class ContactBlocks:
    """Contact blocks of a block map, numbered 0 .. n - 1.

    index[node block]: contact block or FREE, and node_block, its inverse; coordinates (n, dim); neighbours
    (n, 2 dim): contact block one step back and ahead along each axis; slots[surface]: what `contact_kernel` takes, of
    contact blocks, None of a surface far from all, of_surface[surface]: of all node blocks (NumPy). chunk_bounds: the
    contact blocks, cut into chunks; everyone: counted up. Tables may have more rows, which mean nothing;
    they and those of `earlier` contact blocks, which end with this, are the same memory.
    """

    def __init__(self, keys, coordinates, surfaces, keys_beside, met=False, earlier=None):
        """keys (m,) sorted and coordinates (m, dim) of all node blocks; keys_beside: `BlockMap.keys_beside`; met (m,):
        node blocks where bodies meet."""
        dim = coordinates.shape[1]
        of_surface = [surface.slots(keys, coordinates) for surface in surfaces]
        near = np.zeros(len(keys), bool) | met
        for slots in of_surface:
            near |= slots != FREE
        chosen = np.flatnonzero(near)
        index = np.full(len(keys), FREE, np.int32)
        index[chosen] = np.arange(len(chosen))
        neighbours = np.full((len(chosen), 2 * dim), FREE, np.int32)
        own = keys[chosen]
        for axis in range(dim):
            for side, step in enumerate((-1, 1)):
                wanted = keys_beside(own, axis, step)
                at = np.minimum(np.searchsorted(keys, wanted), max(0, len(keys) - 1))
                if len(chosen):
                    neighbours[:, 2 * axis + side] = np.where(keys[at] == wanted, index[at], FREE)
        self.n = len(chosen)
        self._numbers = chosen
        self._rows = rows = earlier._rows if earlier else defaultdict(Rows)
        self.node_block = rows["node_block"].filled(chosen)
        self.index_of = index
        self.index = rows["index"].filled(index)
        self.coordinates = rows["coordinates"].filled(coordinates[chosen])
        self.neighbours = rows["neighbours"].filled(neighbours)
        self.active = [bool((slots != FREE).any()) for slots in of_surface]
        self.slots = [rows[k].filled(slots[chosen]) if self.active[k] else None for k, slots in enumerate(of_surface)]
        self.of_surface = of_surface
        self.chunk_bounds = int_array(chunk_bounds(np.ones(len(chosen))))
        self.everyone = rows["everyone"].filled(np.arange(self.n))
        self.layers: Any = ()
        self.part = earlier.part if earlier else None
        if self.part is None or self.part.shape[0] < self.n:
            self.part = ti.ndarray(ti.f64, (self.n + self.n // 4 + 1, N_TOTALS[dim]))

    def part_fields(self, fields):
        """Keep the blocks of grains and of water apart, for surfaces that treat them differently; fields (m,): of all
        node blocks. layers: (numbers, chunks, how many) of each."""
        own = fields[self._numbers]
        chosen = [np.flatnonzero(own == field) for field in (0, 1)]
        self.layers = [(int_array(some), int_array(chunk_bounds(np.ones(len(some)))), len(some)) for some in chosen]
