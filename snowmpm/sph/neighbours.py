"""Who is near whom: particles in packs, and for every pack the rows that may lie within its reach.

The particles of a block lie in the order of a Morton curve through its cells, and are taken `width` at a time: packs of
near neighbours. A pack has one list for all of its particles, which holds every row that was within reach + skin of one
of them when the list was made; it stays right until two particles may have come closer by more than the skin.

Rows come in groups of one block and one surface: the particles themselves (surface -1), and the dummy particles of
terrain, sides and obstacles. A group may also be seen in the mirror of a side. What a pack reads of a list is cut into
runs, one for each group in which it found something, the particles first and then surface by surface:

    position of row j from the block of the pack [cells]:  x_a = sign_a x_j,a + offset_a

so that float32 sees no number larger than a few blocks. No atomics: every pack writes its own part of every table.
"""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunk_bounds, chunks, is_worker, runs_serially
from snowmpm.compiler.runtime import DTYPES
from snowmpm.errors import SimulationError
from snowmpm.particles.store import LARGEST_INDEX
from snowmpm.sph.candidates import BEGIN, END, SURFACE, candidates

FIRST, COUNT, BLOCK = range(3)
"""Columns of the table of packs."""


class Lists(NamedTuple):
    """What a sum over neighbours reads of the packs: `Packs.table`, and the arrays of `NeighbourLists`."""

    table: Array
    entries: Array
    runs: Array
    n_runs: Array
    ints: Array
    reals: Array
    capacity: int
    most_runs: int


class Packs:
    """Rows of sorted particles in packs: `table` (n, 3): first row, count, block; chunk_bounds: for kernels."""

    def __init__(self, first, counts, width):
        """first, counts (blocks,): first row of each block, and how many it has."""
        first, counts = np.asarray(first, np.int64), np.asarray(counts, np.int64)
        n_packs = -(-counts // width)
        block = np.repeat(np.arange(len(counts)), n_packs)
        number = np.arange(len(block)) - np.repeat(np.cumsum(n_packs) - n_packs, n_packs)
        self.n = len(block)
        self.blocks = block
        size = np.minimum(width, counts[block] - width * number)
        self.table = int_array(np.stack([first[block] + width * number, size, block], axis=1))
        self.chunk_bounds = int_array(chunk_bounds(np.ones(self.n)))


class NeighbourLists:
    """Lists of packs: `entries` (rows), `runs` (candidate, end of its entries), `n_runs` (packs,); tables of
    candidates `ints` and `reals`; `capacity`: entries that a pack may have."""

    def __init__(self, dim, precision, width):
        self.dim, self.width = dim, width
        self._real, self._numpy_real = DTYPES[precision]
        self._find = find_kernel(dim, self._real, width)
        self.capacity = {2: 128, 3: 640}[dim] if width > 1 else {2: 64, 3: 256}[dim]
        self.entries = self.runs = self.n_runs = None
        self.counts = np.zeros(0, np.int32)

    def build(self, packs, rows, targets, groups, mirrors, reach):
        """Find the rows of `groups` within `reach` [cells] of the packs; rows: array whose first `dim` columns are
        positions."""
        start, ints, reals = candidates(targets, groups, mirrors, reach)
        self.candidate_start, self.ints = int_array(start), int_array(ints)
        self.reals = ti.ndarray(self._real, (max(1, len(reals)), 2 * self.dim))
        if len(reals):
            self.reals.from_numpy(reals.astype(self._numpy_real))
        self._host = ints[:, SURFACE], start
        self.most_runs = int(max(1, np.diff(start).max(initial=1)))
        counts = np.zeros(max(1, packs.n), np.int32)
        while True:
            self._reserve(packs.n)
            self._find(self.of(packs), rows, self.candidate_start, reach**2, counts, packs.n, packs.chunk_bounds)
            largest = int(counts.max())
            if largest <= self.capacity:
                break
            self.capacity = int(1.1 * largest) + 8
        self.counts = counts[: packs.n]

    def of(self, packs):
        """`Lists` of the packs that they were built for."""
        return Lists(packs.table, self.entries, self.runs, self.n_runs, self.ints, self.reals, self.capacity,
                     self.most_runs)

    def meets_surfaces(self, packs):
        """Which packs lie in a block near a surface, (n,)."""
        surfaces, owner = self._host
        near = np.zeros(len(owner) - 1, bool)
        near[np.repeat(np.arange(len(near)), np.diff(owner))[surfaces >= 0]] = True
        return near[packs.blocks]

    def _reserve(self, n):
        n = max(1, n)
        wanted = n * self.capacity
        if wanted > LARGEST_INDEX:
            raise SimulationError(f"the lists of neighbours need {wanted:,} entries; {LARGEST_INDEX:,} at most fit the "
                                  "32-bit indices of Taichi's arrays; choose a larger solver.dx")
        if self.entries is None or self.entries.shape[0] < wanted:
            self.entries = ti.ndarray(ti.i32, (min(int(1.1 * wanted) + 64, LARGEST_INDEX),))
        if self.runs is None or self.runs.shape[0] < n * self.most_runs:
            self.runs = ti.ndarray(ti.i32, (int(1.1 * n * self.most_runs) + 64, 2))
        if self.n_runs is None or self.n_runs.shape[0] < n:
            self.n_runs = ti.ndarray(ti.i32, (int(1.1 * n) + 8,))

    @property
    def bytes(self):
        return sum(int(np.prod(array.shape)) * 4 for array in (self.entries, self.runs, self.n_runs) if array)


@functools.cache
def find_kernel(dim, real, width):
    """Kernel that fills the lists."""
    serial = runs_serially()

    @ti.func
    def find_pack(k, lists: ti.template(), rows: ti.template(), candidate_start: ti.template(), reach2,
                  counts: ti.template()):
        first, count, block = lists.table[k, FIRST], lists.table[k, COUNT], lists.table[k, BLOCK]
        x = [ti.Vector.zero(real, width) for _ in ti.static(range(dim))]
        low, high = ti.Vector.zero(real, dim), ti.Vector.zero(real, dim)
        for lane in range(count):
            for a in ti.static(range(dim)):
                x[a][lane] = rows[first + lane][a]
                low[a] = ti.select(lane == 0, x[a][lane], ti.min(low[a], x[a][lane]))
                high[a] = ti.select(lane == 0, x[a][lane], ti.max(high[a], x[a][lane]))
        # Lanes without a particle stand where the first one does
        for lane in range(count, width):
            for a in ti.static(range(dim)):
                x[a][lane] = x[a][0]
        n, found = 0, 0
        for c in range(candidate_start[block], candidate_start[block + 1]):
            before = n
            for j in range(lists.ints[c, BEGIN], lists.ints[c, END]):
                other, away = ti.Vector.zero(real, dim), ti.cast(0.0, real)
                for a in ti.static(range(dim)):
                    other[a] = lists.reals[c, a] * rows[j][a] + lists.reals[c, dim + a]
                    gap = ti.max(0.0, low[a] - other[a], other[a] - high[a])
                    away += gap * gap
                if away < reach2:
                    nearest = reach2
                    for lane in range(width):
                        square = ti.cast(0.0, real)
                        for a in ti.static(range(dim)):
                            square += (x[a][lane] - other[a]) ** 2
                        nearest = ti.select(square < nearest, square, nearest)
                    if nearest < reach2:
                        if n < lists.capacity:
                            lists.entries[k * lists.capacity + n] = j
                        n += 1
            if n > before:
                lists.runs[k * lists.most_runs + found, 0] = c
                lists.runs[k * lists.most_runs + found, 1] = ti.min(n, lists.capacity)
                found += 1
        lists.n_runs[k] = found
        counts[k] = n

    @grouped_kernel(real)
    def find(lists: Lists, rows: Array, candidate_start: Array, reach2: Real, counts: Array, n_packs: int,
             chunk_bounds: Array):
        if ti.static(width == 1):
            for k in range(n_packs):
                find_pack(k, lists, rows, candidate_start, reach2, counts)
        else:
            ti.loop_config(serialize=serial)
            for i in range(chunks(chunk_bounds)):
                if is_worker(i):
                    begin, end = chunk(i, chunk_bounds)
                    for k in range(begin, end):
                        find_pack(k, lists, rows, candidate_start, reach2, counts)

    return find
