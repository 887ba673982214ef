"""The node blocks that a surface may touch: their sums stay in memory of their own while surfaces act on them."""

import numpy as np

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.parallel import chunk_bounds
from snowmpm.mpm.contact.contact_node import N_TOTALS
from snowmpm.mpm.contact.walls import FREE
from snowmpm.particles.blocks import fields_of


class ContactBlocks:
    """Contact blocks of a block map, numbered 0 .. n - 1.

    index[node block]: contact block or FREE, and node_block, its inverse; coordinates (n, dim); neighbours
    (n, 2 dim): contact block one step back and ahead along each axis; slots[surface]: what `contact_kernel` takes, of
    contact blocks, of_surface[surface]: of all node blocks (NumPy). work (n_work,), work_bounds: the contact blocks
    that a step visits, cut into chunks.
    """

    def __init__(self, keys, coordinates, surfaces, map_keys, met=False):
        """keys (m,) sorted and coordinates (m, dim) of all node blocks; map_keys(coordinates, fields) -> keys, which
        wraps around where the domain is periodic; met (m,): node blocks where bodies meet."""
        dim = coordinates.shape[1]
        of_surface = [surface.slots(keys, coordinates) for surface in surfaces]
        near = np.zeros(len(keys), bool) | met
        for slots in of_surface:
            near |= slots != FREE
        chosen = np.flatnonzero(near)
        index = np.full(len(keys), FREE, np.int32)
        index[chosen] = np.arange(len(chosen))
        neighbours = np.full((len(chosen), 2 * dim), FREE, np.int32)
        for axis in range(dim):
            for side, step in enumerate((-1, 1)):
                stepped = coordinates[chosen].copy()
                stepped[:, axis] += step
                wanted = map_keys(stepped, fields_of(keys[chosen], dim))
                at = np.minimum(np.searchsorted(keys, wanted), max(0, len(keys) - 1))
                if len(chosen):
                    neighbours[:, 2 * axis + side] = np.where(keys[at] == wanted, index[at], FREE)
        self.n = len(chosen)
        self._numbers, self._beside = chosen, neighbours
        self.node_block = int_array(chosen)
        self.index_of = index
        self.index = int_array(index)
        self.coordinates = int_array(coordinates[chosen])
        self.neighbours = int_array(neighbours)
        self.active = [bool((slots != FREE).any()) for slots in of_surface]
        self.slots = [int_array(slots[chosen]) for slots in of_surface]
        self.of_surface = of_surface
        self.chunk_bounds = self.work_bounds = int_array(chunk_bounds(np.ones(len(chosen))))
        self.work, self.n_work = int_array(np.arange(self.n)), self.n
        self._full = np.ones(self.n, bool)
        self.layers = ()
        self.part = real_array(np.zeros((max(1, len(chosen)), N_TOTALS[dim])))

    def part_fields(self, fields):
        """Keep the blocks of grains and of water apart, for surfaces that treat them differently; fields (m,): of all
        node blocks. layers: (numbers, chunks, how many) of each."""
        own = fields[self._numbers]
        chosen = [np.flatnonzero(own == field) for field in (0, 1)]
        self.layers = [(int_array(some), int_array(chunk_bounds(np.ones(len(some)))), len(some)) for some in chosen]

    def visit(self, reached):
        """Leave out those that no snow comes to; reached (m,): node blocks with snow that moves. -> contact blocks that
        have to be emptied."""
        full = reached[self._numbers]
        # A line may begin in a block that only its followers' block knows of; FREE is the last one
        visited = np.flatnonzero(full | np.append(full, False)[self._beside].any(axis=1))
        emptied = np.flatnonzero(self._full & ~full)
        self.work, self.n_work, self._full = int_array(visited), len(visited), full
        self.work_bounds = int_array(chunk_bounds(np.ones(len(visited))))
        return emptied.astype(np.int32)
