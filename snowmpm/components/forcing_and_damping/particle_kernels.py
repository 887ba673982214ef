"""Passes over the particles for forces that no neighbour and no surface gives."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


@functools.cache
def particle_kernels(layout, real):
    """Kernels for blocks b of particles start[b] <= p < start[b + 1]:

    read: local position [cells], velocity, reference volume, J of each, into rows (n, 2 dim + 2)
    push: add `gain` (n, dim) [m/s] to the velocities
    confine: add `pressure` (n,) [Pa] to the normal Kirchhoff stresses
    slow: keep the share `damping_factor` of the velocities and their gradients
    sums: of m v and of m (v^2 + D C:C) of each block, (blocks, dim + 1); second_moment: D [m2]
    """
    access, at, dim = accessors(layout), layout.offsets, layout.dim

    @taichi_kernel
    def read(reals: ti.types.ndarray(), slot_offset: int, rows: ti.types.ndarray(dtype=ti.f64, ndim=2), count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            x, v = access.load(reals, places, p, at["position"], dim), access.load(reals, places, p, at["velocity"],
                                                                                   dim)
            for a in ti.static(range(dim)):
                rows[p, a], rows[p, dim + a] = ti.cast(x[a], ti.f64), ti.cast(v[a], ti.f64)
            rows[p, 2 * dim] = ti.cast(access.load(reals, places, p, at["volume"], 1)[0], ti.f64)
            rows[p, 2 * dim + 1] = ti.cast(access.load(reals, places, p, at["volume_ratio"], 1)[0], ti.f64)

    @taichi_kernel
    def push(reals: ti.types.ndarray(), slot_offset: int, gain: ti.types.ndarray(dtype=ti.f64, ndim=2), count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            v = access.load(reals, places, p, at["velocity"], dim)
            for a in ti.static(range(dim)):
                v[a] += ti.cast(gain[p, a], real)
            access.store(reals, places, p, at["velocity"], v)

    @taichi_kernel
    def confine(reals: ti.types.ndarray(), slot_offset: int, pressure: ti.types.ndarray(dtype=ti.f64, ndim=1),
                count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            tau = access.load(reals, places, p, at["stress"], layout.sym_size)
            for a in ti.static(range(3)):
                tau[a] += ti.cast(pressure[p], real)
            access.store(reals, places, p, at["stress"], tau)

    @taichi_kernel
    def slow(reals: ti.types.ndarray(), slot_offset: int, damping_factor: real, count: int):
        for p in range(count):
            places = access.places(reals, slot_offset)
            access.store(reals, places, p, at["velocity"],
                         damping_factor * access.load(reals, places, p, at["velocity"], dim))
            access.store(reals, places, p, at["affine"],
                         damping_factor * access.load(reals, places, p, at["affine"], dim * dim))

    @taichi_kernel
    def sums(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(), materials: ti.types.ndarray(),
             start: ti.types.ndarray(), second_moment: ti.f64, of_block: ti.types.ndarray(dtype=ti.f64, ndim=2),
             n_blocks: int):
        for b in range(n_blocks):
            places, total = access.places(reals, slot_offset), ti.Vector.zero(ti.f64, dim + 1)
            for p in range(start[b], start[b + 1]):
                v = ti.cast(access.load(reals, places, p, at["velocity"], dim), ti.f64)
                C = ti.cast(access.load(reals, places, p, at["affine"], dim * dim), ti.f64)
                volume = ti.cast(access.load(reals, places, p, at["volume"], 1)[0], ti.f64)
                mass = volume * ti.cast(materials[ti.cast(material[p], ti.i32), DENSITY], ti.f64)
                if ti.static(layout.mass_at >= 0):
                    mass += volume * ti.cast(access.load(reals, places, p, layout.mass_at, 1)[0], ti.f64)
                for a in ti.static(range(dim)):
                    total[a] += mass * v[a]
                total[dim] += mass * (v.norm_sqr() + second_moment * C.norm_sqr())
            for c in ti.static(range(dim + 1)):
                of_block[b, c] = total[c]

    return SimpleNamespace(read=read, push=push, confine=confine, slow=slow, sums=sums)
