"""Short lists: of the rows on the lists of neighbours, those that may act in the next few steps.

A list reaches a skin beyond the support (`neighbourhood`), so that it stays right for many steps. In space that makes
it a quarter longer than what acts. A short list reaches only as far as particles come closer in `LASTING` steps, is cut
from the list by one test of distances, and is cut anew when that is used up. Both give the same sums to the bit: what
the short list leaves out lies beyond the support and adds zeros. So checkpoints need not know of it.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker, runs_serially
from snowmpm.compiler.runtime import DTYPES
from snowmpm.sph.neighbours import COUNT, FIRST, Lists
from snowmpm.sph.pairs import pair_functions

LASTING = 6
"""Steps that a short list is to last: the test of distances costs less than a tenth of a step."""
WORTH = 0.5
"""Share of the skin up to which a short list is worth being cut."""


class Kept(NamedTuple):
    """What a short list has of its own."""

    entries: Array
    runs: Array
    n_runs: Array


class ShortLists:
    """Short lists of the packs of a solver's particles, beside their `NeighbourLists`."""

    def __init__(self, layout, precision, width, radius, skin):
        """layout: `RowLayout`; width: lanes of a pack; radius [cells]: of the support; skin [cells]: how far beyond it
        lists reach."""
        self._cut = cut_kernel(layout, DTYPES[precision][0], width)
        self._radius, self._skin = radius, skin
        self._kept: Any = Kept(None, None, None)
        self._now: Any = None
        self._left, self._way = -math.inf, math.inf

    def forget(self):
        """The lists were made anew."""
        self._left = -math.inf

    def age(self, way):
        """A step in which two particles may have come closer by `way` [cells]."""
        self._left, self._way = self._left - way, way

    def of(self, packs, rows, lists):
        """`Lists` that a sum over neighbours reads: short ones, or the whole ones where particles move too fast.

        packs, lists: of particles (`neighbours`); rows: `Rows` as they are now.
        """
        if self._left < 0.0:
            whole = lists.of(packs)
            reach = LASTING * self._way
            if not reach < WORTH * self._skin:
                return whole
            self._make_room(whole)
            self._cut(whole, rows.source, self._kept, (self._radius + reach) ** 2, packs.n, packs.chunk_bounds)
            self._left, self._now = reach, whole._replace(**self._kept._asdict())
        return self._now

    def _make_room(self, whole):
        """For as much as the whole lists hold."""
        arrays = whole.entries, whole.runs, whole.n_runs
        if any(kept is None or kept.shape != array.shape for kept, array in zip(self._kept, arrays, strict=True)):
            self._kept = Kept(*[ti.ndarray(ti.i32, array.shape) for array in arrays])

    @property
    def bytes(self):
        """Memory of the short lists."""
        return sum(int(np.prod(array.shape)) * 4 for array in self._kept if array is not None)


@functools.cache
def cut_kernel(layout, real, width):
    """Kernel that keeps of each run the rows within a distance of one of the particles of the pack, in their order."""
    dim, serial, mask = layout.dim, runs_serially(), layout.row_mask
    pair = pair_functions(layout)

    @ti.func
    def cut_pack(k, lists: ti.template(), rows: ti.template(), kept: ti.template(), reach2):
        first, count = lists.table[k, FIRST], lists.table[k, COUNT]
        x = [ti.Vector.zero(real, width) for _ in ti.static(range(dim))]
        for lane in range(width):
            row = rows[first + ti.min(lane, count - 1) & mask]
            for a in ti.static(range(dim)):
                x[a][lane] = row[a]
        begin, n, found = k * lists.capacity, k * lists.capacity, 0
        for q in range(lists.n_runs[k]):
            c, end = lists.runs[k * lists.most_runs + q, 0], k * lists.capacity + lists.runs[k * lists.most_runs + q, 1]
            before = n
            for e in range(begin, end):
                j = lists.entries[e]
                other, nearest = pair.place(lists.reals, c, rows[j & mask]), reach2
                for lane in range(width):
                    square = ti.cast(0.0, real)
                    for a in ti.static(range(dim)):
                        square += (x[a][lane] - other[a]) ** 2
                    nearest = ti.select(square < nearest, square, nearest)
                kept.entries[n] = j
                n += ti.select(nearest < reach2, 1, 0)
            begin = end
            if n > before:
                kept.runs[k * lists.most_runs + found, 0] = c
                kept.runs[k * lists.most_runs + found, 1] = n - k * lists.capacity
                found += 1
        kept.n_runs[k] = found

    @grouped_kernel(real)
    def cut(lists: Lists, rows: Array, kept: Kept, reach2: Real, n_packs: int, chunk_bounds: Array):
        if ti.static(width == 1):
            for k in range(n_packs):
                cut_pack(k, lists, rows, kept, reach2)
        else:
            ti.loop_config(serialize=serial)
            for i in range(chunks(chunk_bounds)):
                if is_worker(i):
                    begin, end = chunk(i, chunk_bounds)
                    for k in range(begin, end):
                        cut_pack(k, lists, rows, kept, reach2)

    return cut
