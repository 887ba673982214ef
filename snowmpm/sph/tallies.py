"""What surfaces and loads give the particles, summed up by packs: without atomics, in an order that is always the same.

Only packs that may meet a surface, or any where loads act, have a sum.
"""

from typing import NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.groups import Array
from snowmpm.particles.blocks import EDGE
from snowmpm.sph.surface_forces import tally_width


class Sums(NamedTuple):
    """The arrays of `Tallies`, and totals (surfaces + 1, numbers) to which a kernel adds them."""

    sums: Array
    of: Array
    corners: Array
    n: int
    total: Array


class Tallies:
    """corners (blocks, dim) [cells]: of each block, where moments are taken from; of (packs,): number of a pack's sums,
    -1 without; sums (n, surfaces + 1, numbers): those of the packs, surface by surface, loads last; n."""

    def __init__(self, blocks, packs, lists, n_surfaces, loaded):
        """blocks: `BlockMap`; packs, lists: of the particles (`sph.neighbours`); loaded: whether there are loads."""
        self.corners = int_array(EDGE[blocks.dim] * blocks.coordinates)
        met = np.ones(packs.n, bool) if loaded else lists.meets_surfaces(packs)
        self.of = int_array(np.where(met, np.cumsum(met) - 1, -1))
        self.n = int(met.sum())
        self._shape = n_surfaces + 1, tally_width(blocks.dim)
        self.sums = ti.ndarray(ti.f64, (max(1, self.n), *self._shape))

    def begin(self):
        """`Sums` of a step, nothing yet in its totals."""
        return Sums(self.sums, self.of, self.corners, self.n, np.zeros(self._shape))
