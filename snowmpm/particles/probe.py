"""Reading chosen particles, again and again, without copying all others."""

import functools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats
from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import runs_serially
from snowmpm.particles.arrays import BlockRows
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors

if TYPE_CHECKING:
    from snowmpm.particles.sorted_particles import SortedParticles

NOWHERE = -1
LOOK_TIME = 5e-9
"""Of a look at a particle of the store on one thread [s], about."""


@functools.cache
def probe_kernel(layout, real, serial):
    """Kernel that copies the particles with `row_of[number] >= 0` to that row of `rows`, owner block to `blocks`."""
    dim = layout.dim
    access = accessors(layout)

    @grouped_kernel(real)
    def probe(store: BlockRows, identity: Array, row_of: Array, rows: Array, blocks: Array, n_blocks: int):
        ti.loop_config(serialize=ti.static(serial))
        for b in range(n_blocks):
            places = access.places(store.reals, store.slot_offset)
            for p in range(store.start[b], store.start[b + 1]):
                row = row_of[identity[p]]
                if row >= 0:
                    values = access.load(store.reals, places, p, 0, layout.width)
                    for c in ti.static(range(layout.width)):
                        rows[row, c] = values[c]
                    for a in ti.static(range(dim)):
                        blocks[row, a] = store.coordinates[b, a]

    return probe


class Probe:
    """The particles of a store with chosen numbers, in a fixed order, as they are now.

    there (n,): not removed yet. What columns say of those that are gone means nothing.
    """

    there: NDArray[np.bool_]

    def __init__(self, store: "SortedParticles", chosen: NDArray[np.integer[Any]], total: int) -> None:
        """store: `SortedParticles`; chosen (n,): particle numbers; total: how many numbers there are."""
        self._store = store
        self._serial = runs_serially(LOOK_TIME * total)
        row_of = np.full(total, NOWHERE, np.int32)
        row_of[chosen] = np.arange(len(chosen))
        self._row_of = ti.ndarray(ti.i32, total)
        self._row_of.from_numpy(row_of)
        self._rows = np.zeros((len(chosen), store.layout.width), store.numpy_dtype)
        self._blocks = np.full((len(chosen), store.dim), np.iinfo(np.int32).min, np.int32)
        self.read()

    def read(self) -> None:
        """Look again."""
        store = self._store
        self._blocks[:] = np.iinfo(np.int32).min
        with runtime.precision(store.precision):
            probe_kernel(store.layout, runtime.DTYPES[store.precision][0], self._serial)(
                store.block_rows, store.identity, self._row_of, self._rows, self._blocks, len(store.blocks))
        self.there = self._blocks[:, 0] != np.iinfo(np.int32).min

    def column(self, name: str, part: slice = slice(None)) -> Floats:
        """One column group of the particle table, float64, (n, size), of all or a part (slice) of the chosen ones."""
        return self._rows[part, self._store.layout.columns(name)].astype(np.float64)

    def positions(self, part: slice = slice(None)) -> Floats:
        """Scene coordinates [m], (n, dim), of all or a part (slice) of the chosen ones; NaN for those that are gone."""
        store = self._store
        cells = EDGE[store.dim] * self._blocks[part].astype(np.int64) + self.column("position", part)
        return np.where(self.there[part, None], store.origin + store.dx * cells, np.nan)
