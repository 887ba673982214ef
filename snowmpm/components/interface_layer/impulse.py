"""Impulse that the ground gives the snow above it through the points of interfaces."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker
from snowmpm.compiler.runtime import DTYPES
from snowmpm.components.interface_layer.column import COLUMN
from snowmpm.materials.symmetric import entries
from snowmpm.particles.arrays import BlockRows
from snowmpm.particles.store import accessors


@functools.cache
def impulse_kernel(layout, real, serial):
    """Kernel that adds up -dt V tau b / J of all points (`.column`), block by block."""
    dim, access, at, entry = layout.dim, accessors(layout), layout.offsets, entries(layout.dim)

    @grouped_kernel(real)
    def add_up(rows: BlockRows, chunk_bounds: Array, part: Array, total: Array, dt: Real, n_blocks: int):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for n in range(first, last):
                    found = ti.Vector.zero(ti.f64, dim)
                    for p in range(rows.start[n], rows.start[n + 1]):
                        rate = access.load(rows.reals, places, p, at[COLUMN], dim)
                        if rate.norm_sqr() > 0.0:
                            tau = access.load(rows.reals, places, p, at["stress"], layout.sym_size)
                            volume = access.load(rows.reals, places, p, at["volume"], 1)[0]
                            share = -dt * volume / access.load(rows.reals, places, p, at["volume_ratio"], 1)[0]
                            for a in ti.static(range(dim)):
                                for c in ti.static(range(dim)):
                                    found[a] += ti.cast(share * tau[entry[a][c]] * rate[c], ti.f64)
                    for a in ti.static(range(dim)):
                        part[n, a] = found[a]
        ti.loop_config(serialize=ti.static(in_order()))
        for n in range(n_blocks):
            for a in ti.static(range(dim)):
                total[a] += part[n, a]

    return add_up


class LayerImpulse:
    """Of a particle store (`SortedParticles`)."""

    def __init__(self, store, serial):
        self._store, self._part = store, None
        self._add_up = impulse_kernel(store.layout, DTYPES[store.precision][0], serial)

    def of(self, dt):
        """Impulse (dim,) [N s] of a step of dt [s], by the stresses before it."""
        store, total = self._store, np.zeros(self._store.dim)
        if self._part is None or self._part.shape[0] < max(1, len(store.blocks)):
            self._part = ti.ndarray(ti.f64, (int(1.25 * len(store.blocks)) + 8, store.dim))
        self._add_up(store.block_rows, store.chunk_bounds, self._part, total, dt, len(store.blocks))
        return total
