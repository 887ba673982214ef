"""What lies over the cells of a map: sums over particles in plan."""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.particles.arrays import BlockRows
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


class Plan(NamedTuple):
    """Cells of `width` grid cells, of which the cell 0, 0 begins at low_x, low_y, in grid cells from the origin; those
    from the cell first_i, first_j on."""

    width: Real
    low_x: Real
    low_y: Real
    first_i: int
    first_j: int


@functools.cache
def plan_sums_kernel(layout, real):
    """Kernel that adds up what lies over the cells of a `Plan`.

    sums (columns along x, rows along y, 6), as of `particles.contract.Particles.sums_in_plan`. One
    thread, so that the sums do not depend on the number of threads.
    """
    edge, at = EDGE[layout.dim], layout.offsets
    access = accessors(layout)

    @grouped_kernel(ti.f64)
    def add_up(rows: BlockRows, material: Array, materials: Array, sums: Array, plan: Plan, n_blocks: int):
        ti.loop_config(serialize=True)
        for b in range(n_blocks):
            places = access.places(rows.reals, rows.slot_offset)
            for p in range(rows.start[b], rows.start[b + 1]):
                x = access.load(rows.reals, places, p, at["position"], 2)
                right = ti.cast(edge * rows.coordinates[b, 0], ti.f64) + x[0] - plan.low_x
                ahead = ti.cast(edge * rows.coordinates[b, 1], ti.f64) + x[1] - plan.low_y
                i = ti.floor(right / plan.width, ti.i32) - plan.first_i
                j = ti.floor(ahead / plan.width, ti.i32) - plan.first_j
                flows = 1
                if ti.static(layout.still_at >= 0):
                    flows = ti.cast(access.load(rows.reals, places, p, layout.still_at, 1)[0] <= 0.0, ti.i32)
                if flows == 1 and 0 <= i < sums.shape[0] and 0 <= j < sums.shape[1]:
                    volume = access.load(rows.reals, places, p, at["volume"], 1)[0]
                    mass = volume * materials[material[p], DENSITY]
                    if ti.static(layout.mass_at >= 0):
                        mass += volume * access.load(rows.reals, places, p, layout.mass_at, 1)[0]
                    sums[i, j, 0] += volume
                    sums[i, j, 1] += mass
                    velocity = access.load(rows.reals, places, p, at["velocity"], layout.dim)
                    speed = velocity.norm()
                    sums[i, j, 2] += mass * speed
                    sums[i, j, 3] += mass * speed**2
                    for axis in ti.static(range(2)):
                        sums[i, j, 4 + axis] += volume * velocity[axis]

    return add_up


def plan_sums(store, lower, cell, shape):
    """`particles.contract.Particles.sums_in_plan` of `SortedParticles`."""
    width, edge = cell / store.dx, EDGE[store.dim]
    corner = (lower - store.origin[:2]) / store.dx
    blocks = store.blocks.coordinates[:, :2] if len(store.blocks) else np.zeros((1, 2), int)
    # A particle may stray from its block before the next sort, by less than a block
    low = np.floor((edge * (blocks.min(axis=0) - 1) - corner) / width).astype(int).clip(0, shape)
    high = np.ceil((edge * (blocks.max(axis=0) + 2) - corner) / width).astype(int).clip(0, shape)
    sums = np.zeros((*(high - low), 6))
    with runtime.precision(store.precision):
        plan_sums_kernel(store.layout, runtime.DTYPES[store.precision][0])(
            store.block_rows, store.material, store.materials.numbers, sums,
            Plan(width, *corner.tolist(), *low.tolist()), len(store.blocks))
    return tuple(slice(first, last) for first, last in zip(low, high, strict=True)), sums
