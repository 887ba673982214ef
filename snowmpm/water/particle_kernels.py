"""Passes over the particles for the water in their pores."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.store import accessors

MASS, PRESSURE, SOLID, RATIO, YIELDED = range(5)
"""Entries of the column "water": mass of water per reference volume [kg/m3], pore pressure [Pa], volume of the
skeleton's grains per reference volume [-], J at the last exchange [-], `seepage`'s yielded volume per reference volume
[-]."""

N_WATER = 5


def read_columns(dim):
    """Slices of the rows that `read` fills, by name."""
    sizes = {"position": dim, "velocity": dim, "affine2": 1, "volume": 1, "ratio": 1, "water": N_WATER}
    found, at = {}, 0
    for name, size in sizes.items():
        found[name] = slice(at, at + size) if size > 1 else at
        at += size
    return found, at


@functools.cache
def water_kernels(layout, real):
    """Kernels over the particles p < count:

    read: position, velocity, C : C, reference volume, J and water of each, into rows (`read_columns`)
    write: the column "water" from rows (n, N_WATER)
    moisten: the state variable index_of[material] of each (-1: none) from `content` (n,)
    pressurise: tau -= J p I, the total stress of effective stress and pore pressure
    """
    access, at, dim = accessors(layout), layout.offsets, layout.dim
    width = read_columns(dim)[1]

    @taichi_kernel
    def read(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(dtype=ti.f64, ndim=2), count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            x = access.load(reals, places, p, at["position"], dim)
            v = access.load(reals, places, p, at["velocity"], dim)
            for a in ti.static(range(dim)):
                rows[p, a], rows[p, dim + a] = ti.cast(x[a], ti.f64), ti.cast(v[a], ti.f64)
            rows[p, 2 * dim] = ti.cast(access.load(reals, places, p, at["affine"], dim * dim).norm_sqr(), ti.f64)
            rows[p, 2 * dim + 1] = ti.cast(access.load(reals, places, p, at["volume"], 1)[0], ti.f64)
            rows[p, 2 * dim + 2] = ti.cast(access.load(reals, places, p, at["volume_ratio"], 1)[0], ti.f64)
            held = access.load(reals, places, p, at["water"], N_WATER)
            for c in ti.static(range(N_WATER)):
                rows[p, ti.static(width - N_WATER) + c] = ti.cast(held[c], ti.f64)

    @taichi_kernel
    def write(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(dtype=ti.f64, ndim=2), count: int):
        for p in range(count):
            held = ti.Vector([ti.cast(rows[p, c], real) for c in ti.static(range(N_WATER))])
            access.store(reals, access.places(reals, slot_offset), p, at["water"], held)

    @taichi_kernel
    def moisten(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(),
                index_of: ti.types.ndarray(dtype=ti.i32, ndim=1), content: ti.types.ndarray(dtype=ti.f64, ndim=1),
                count: int):
        for p in range(count):
            index = index_of[ti.cast(material[p], ti.i32)]
            if index >= 0:
                places = access.places(reals, slot_offset)
                state = access.load(reals, places, p, at["state"], layout.state_size)
                for c in ti.static(range(layout.state_size)):
                    if c == index:
                        state[c] = ti.cast(content[p], real)
                access.store(reals, places, p, at["state"], state)

    @taichi_kernel
    def pressurise(reals: ti.types.ndarray(), slot_offset: int, count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            pressure = access.load(reals, places, p, at["water"], N_WATER)[PRESSURE]
            ratio = access.load(reals, places, p, at["volume_ratio"], 1)[0]
            tau = access.load(reals, places, p, at["stress"], layout.sym_size)
            for a in ti.static(range(3)):
                tau[a] -= ratio * pressure
            access.store(reals, places, p, at["stress"], tau)

    return SimpleNamespace(read=read, write=write, moisten=moisten, pressurise=pressurise)
