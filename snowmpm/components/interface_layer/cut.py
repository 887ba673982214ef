"""A saw in an interface (`.column`): the points that it has reached lose their stress, and stay."""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import runs_serially
from snowmpm.components.interface_layer.column import COLUMN, CUT
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.probe import LOOK_TIME
from snowmpm.particles.store import accessors


class Tables(NamedTuple):
    """Of the store."""

    reals: Array
    slot_offset: int
    material: Array
    identity: Array
    start: Array
    coordinates: Array


class Cut(NamedTuple):
    """Of the points `first` <= number < `last`, in the order of their numbers: index of the material and one of those
    that are cut now, else 0; what they held: stress, state, volume. severed: the first `n_severed` of their state."""

    severed: Array
    n_severed: int
    material: Array
    held: Array
    first: int
    last: int


@functools.cache
def cut_kernel(layout, real, serial):
    """Kernel that cuts the points with x < reached[0] [cells from the origin]. serial: by one thread."""
    edge, sym_size, state_size = EDGE[layout.dim], layout.sym_size, layout.state_size
    access, at, mark = accessors(layout), layout.offsets, layout.offsets[COLUMN] + CUT * layout.dim

    @grouped_kernel(real)
    def saw(store: Tables, cut: Cut, reached: Array, n_blocks: int):
        ti.loop_config(serialize=ti.static(serial))
        for b in range(n_blocks):
            places = access.places(store.reals, store.slot_offset)
            for p in range(store.start[b], store.start[b + 1]):
                row = store.identity[p] - cut.first
                if row >= 0 and row < cut.last - cut.first:
                    x = ti.cast(edge * store.coordinates[b, 0], ti.f64) + ti.cast(
                        access.load(store.reals, places, p, at["position"], 1)[0], ti.f64)
                    if x < reached[0] and access.load(store.reals, places, p, mark, 1)[0] == 0.0:
                        tau = access.load(store.reals, places, p, at["stress"], sym_size)
                        state = access.load(store.reals, places, p, at["state"], state_size)
                        for c in ti.static(range(sym_size)):
                            cut.held[row, c] = tau[c]
                        for c in ti.static(range(state_size)):
                            cut.held[row, sym_size + c] = state[c]
                            if c < cut.n_severed:
                                state[c] = cut.severed[c]
                        cut.held[row, sym_size + state_size] = access.load(store.reals, places, p, at["volume"], 1)[0]
                        cut.material[row] = ti.cast(store.material[p], ti.i32) + 1
                        access.store(store.reals, places, p, at["stress"], ti.Vector.zero(real, sym_size))
                        access.store(store.reals, places, p, at["elastic"], ti.Vector.zero(real, sym_size))
                        access.store(store.reals, places, p, at["state"], state)
                        access.store(store.reals, places, p, mark, ti.Vector([ti.cast(1.0, real)]))

    return saw


def cut_points(store, numbers, reached, severed):
    """Cut the points numbers[0] <= number < numbers[1] of a store (`SortedParticles`) with x < reached [m]: no stress
    from now on, and the law's `severed` state, if any; -> what they stored [J]."""
    layout, n = store.layout, numbers[1] - numbers[0]
    sym_size, real = layout.sym_size, store.numpy_dtype
    material, held = np.zeros(n, np.int32), np.zeros((n, sym_size + layout.state_size + 1), real)
    with runtime.precision(store.precision):
        cut_kernel(layout, runtime.DTYPES[store.precision][0], runs_serially(LOOK_TIME * store.count))(
            Tables(store.reals, store.slot_offset, store.material, store.identity, store.start, store.coordinates),
            Cut(np.array([*severed, 0.0], real), len(severed), material, held, *numbers),
            np.array([(reached - store.origin[0]) / store.dx]), len(store.blocks))
    rows = np.flatnonzero(material)
    stress, state, volume = np.split(held[rows].astype(np.float64), [sym_size, sym_size + layout.state_size], axis=1)
    return store.materials.elastic_energy(material[rows] - 1, stress, state, volume[:, 0])
