"""Points of an interface (`.column`), followed from step to step: their state, and the work that they took.

Per volume of the layer the work of a step is that of the traction p = tau b / J over the displacement u of the snow
above, by the mean of the tractions before and after it:

    W += (p + p') . (u' - u) / 2

in double precision, whatever that of the particles. All of it is one pass over the particles, which also tells what
points have changed, so that who looks for that need not look at others.
"""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import runs_serially
from snowmpm.components.interface_layer.column import COLUMN, CUT, size
from snowmpm.materials.symmetric import entries
from snowmpm.particles.probe import LOOK_TIME, NOWHERE
from snowmpm.particles.store import accessors


class Tables(NamedTuple):
    """Of the store."""

    reals: Array
    slot_offset: int
    identity: Array
    start: Array


class Points(NamedTuple):
    """Rows of `PointProbe`; row_of: of each particle number, or `NOWHERE`."""

    row_of: Array
    there: Array
    stress: Array
    state: Array
    cut: Array
    load: Array
    work: Array
    waiting: Array
    changed: Array


@functools.cache
def work_kernel(layout, real, serial):
    """Kernel that takes the step of all points into the rows."""
    dim, sym_size, state_size = layout.dim, layout.sym_size, layout.state_size
    access, at, entry, mark, n_own = accessors(layout), layout.offsets, entries(dim), CUT * dim, size(dim)

    @grouped_kernel(real)
    def add_up(store: Tables, points: Points, n_blocks: int):
        ti.loop_config(serialize=ti.static(serial))
        for b in range(n_blocks):
            places = access.places(store.reals, store.slot_offset)
            for p in range(store.start[b], store.start[b + 1]):
                row = points.row_of[store.identity[p]]
                if row >= 0:
                    own = access.load(store.reals, places, p, at[COLUMN], n_own)
                    tau = access.load(store.reals, places, p, at["stress"], sym_size)
                    ratio = ti.cast(access.load(store.reals, places, p, at["volume_ratio"], 1)[0], ti.f64)
                    work = ti.cast(0.0, ti.f64)
                    for a in ti.static(range(dim)):
                        pull, moved = ti.cast(0.0, ti.f64), ti.cast(own[dim + a], ti.f64)
                        for c in ti.static(range(dim)):
                            pull += ti.cast(tau[entry[a][c]], ti.f64) * ti.cast(own[c], ti.f64)
                        pull /= ratio
                        work += 0.5 * (points.load[row, a] + pull) * (moved - points.load[row, dim + a])
                        points.load[row, a], points.load[row, dim + a] = pull, moved
                    points.work[row] += work
                    for c in ti.static(range(sym_size)):
                        points.stress[row, c] = tau[c]
                    state = access.load(store.reals, places, p, at["state"], state_size)
                    new = points.there[row] == 0 or points.cut[row] != own[mark]
                    for c in ti.static(range(state_size)):
                        new = new or points.state[row, c] != state[c]
                        points.state[row, c] = state[c]
                    points.cut[row], points.there[row] = own[mark], 1
                    points.changed[row] = ti.cast(new and points.waiting[row] != 0, ti.i32)

    return add_up


class PointProbe:
    """The points of a store with chosen numbers, in a fixed order.

    there (n,): not removed yet; stress (n, sym_size) [Pa], state (n, state_size), cut (n,): as they are now, of those
    that are gone as they were last. load (n, 2 dim): traction over thickness [Pa/m] and displacement [m]; work (n,)
    [J/m3]: of the steps that were followed. waiting (n,): 1 of those whose changes matter; changed (n,): 1 of those of
    them whose state changed, or that were cut, since they were followed last.
    """

    def __init__(self, store, chosen, total):
        """store: `SortedParticles`; chosen (n,): particle numbers; total: how many numbers there are."""
        layout, n, real = store.layout, len(chosen), store.numpy_dtype
        self._store, self._serial = store, runs_serially(LOOK_TIME * total)
        row_of = np.full(total, NOWHERE, np.int32)
        row_of[chosen] = np.arange(n)
        self._row_of = ti.ndarray(ti.i32, total)
        self._row_of.from_numpy(row_of)
        self._there, self.changed = (np.zeros(n, np.int32) for _ in range(2))
        self.waiting = np.ones(n, np.int32)
        self.stress, self.state = (np.zeros((n, size), real) for size in (layout.sym_size, layout.state_size))
        self.cut, self.load, self.work = np.zeros(n, real), np.zeros((n, 2 * layout.dim)), np.zeros(n)
        self._count = -1
        self.add_work()
        self.work[:] = 0.0

    @property
    def there(self):
        return self._there > 0

    def add_work(self):
        """Take in what has happened since the last call."""
        store = self._store
        if store.count != self._count:
            self._there[:], self._count = 0, store.count
        with runtime.precision(store.precision):
            work_kernel(store.layout, runtime.DTYPES[store.precision][0], self._serial)(
                Tables(store.reals, store.slot_offset, store.identity, store.start),
                Points(self._row_of, self._there, self.stress, self.state, self.cut, self.load, self.work, self.waiting,
                       self.changed), len(store.blocks))
