"""What lies over the cells of a map: sums over particles in plan."""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


@functools.cache
def plan_sums_kernel(layout, real):
    """Kernel that adds up what lies over plan cells of `width` grid cells, from the cell `first_i`, `first_j` on.

    Cell 0, 0 begins at `low_x`, `low_y`, in grid cells from the origin.

    sums (columns along x, rows along y, 4): initial volume, mass, mass times speed, mass times speed squared. One
    thread, so that the sums do not depend on the number of threads.
    """
    edge, at = EDGE[layout.dim], layout.offsets
    access = accessors(layout)

    @taichi_kernel
    def add_up(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(), materials: ti.types.ndarray(),
               start: ti.types.ndarray(), coordinates: ti.types.ndarray(), sums: ti.types.ndarray(), width: ti.f64,
               low_x: ti.f64, low_y: ti.f64, first_i: int, first_j: int, n_blocks: int):
        ti.loop_config(serialize=True)
        for b in range(n_blocks):
            places = access.places(reals, slot_offset)
            for p in range(start[b], start[b + 1]):
                x = access.load(reals, places, p, at["position"], 2)
                i = ti.floor((ti.cast(edge * coordinates[b, 0], ti.f64) + x[0] - low_x) / width, ti.i32) - first_i
                j = ti.floor((ti.cast(edge * coordinates[b, 1], ti.f64) + x[1] - low_y) / width, ti.i32) - first_j
                if 0 <= i < sums.shape[0] and 0 <= j < sums.shape[1]:
                    volume = access.load(reals, places, p, at["volume"], 1)[0]
                    mass = volume * materials[material[p], DENSITY]
                    if ti.static(layout.mass_at >= 0):
                        mass += volume * access.load(reals, places, p, layout.mass_at, 1)[0]
                    sums[i, j, 0] += volume
                    sums[i, j, 1] += mass
                    speed = access.load(reals, places, p, at["velocity"], layout.dim).norm()
                    sums[i, j, 2] += mass * speed
                    sums[i, j, 3] += mass * speed**2

    return add_up


def plan_sums(store, lower, cell, shape):
    """`particles.contract.Particles.sums_in_plan` of `SortedParticles`."""
    width, edge = cell / store.dx, EDGE[store.dim]
    corner = (lower - store.origin[:2]) / store.dx
    blocks = store.blocks.coordinates[:, :2] if len(store.blocks) else np.zeros((1, 2), int)
    # A particle may stray from its block before the next sort, by less than a block
    low = np.floor((edge * (blocks.min(axis=0) - 1) - corner) / width).astype(int).clip(0, shape)
    high = np.ceil((edge * (blocks.max(axis=0) + 2) - corner) / width).astype(int).clip(0, shape)
    sums = np.zeros((*(high - low), 4))
    with runtime.precision(store.precision):
        plan_sums_kernel(store.layout, runtime.DTYPES[store.precision][0])(
            store.reals, store.slot_offset, store.material, store.materials.numbers, store.start, store.coordinates,
            sums, width, *corner.tolist(), *low.tolist(), len(store.blocks))
    return tuple(slice(first, last) for first, last in zip(low, high, strict=True)), sums
