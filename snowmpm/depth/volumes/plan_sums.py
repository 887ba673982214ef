"""What lies over the cells of a map: sums over the cells of the flow, each spread evenly over those it covers."""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.depth.plan_grid import MARGIN

EDGE = 1e-9
"""Share of a map cell that round-off may move the edge of a cell across that of a map cell."""


@functools.cache
def sums_kernel():
    """Kernel that adds cells of the flow to map cells, as of `particles.contract.Particles.sums_in_plan`.

    state (.., 3): volume over plan H [m] and velocity in plan [m/s]; ground (.., 6) as of `arrays.GROUND`; frame (8,):
    low corner of the first cell in that of `sums` [map cells] (2,), side of a cell [map cells] and [m], least H [m],
    density [kg/m3], cells along both axes. One thread, so that sums do not depend on the number of threads.
    """

    @taichi_kernel
    def add_up(state: ti.types.ndarray(), ground: ti.types.ndarray(), sums: ti.types.ndarray(),
               frame: ti.types.ndarray(), first_i: int, first_j: int):
        side = frame[2]
        ti.loop_config(serialize=True)
        for i in range(ti.cast(frame[6], ti.i32)):
            for j in range(ti.cast(frame[7], ti.i32)):
                H = ti.cast(state[first_i + i, first_j + j, 0], ti.f64)
                if frame[4] < H:
                    u, v = (ti.cast(state[first_i + i, first_j + j, 1], ti.f64),
                            ti.cast(state[first_i + i, first_j + j, 2], ti.f64))
                    up = u * ground[first_i + i, first_j + j, 0] + v * ground[first_i + i, first_j + j, 1]
                    speed2 = u * u + v * v + up * up
                    speed, whole = ti.sqrt(speed2), H * frame[3] ** 2
                    low_x, low_y = frame[0] + i * side, frame[1] + j * side
                    k = ti.max(0, ti.cast(ti.floor(low_x + EDGE), ti.i32))
                    while k < sums.shape[0] and k < low_x + side - EDGE:
                        wide = ti.min(low_x + side, k + 1.0) - ti.max(low_x, ti.cast(k, ti.f64))
                        n = ti.max(0, ti.cast(ti.floor(low_y + EDGE), ti.i32))
                        while n < sums.shape[1] and n < low_y + side - EDGE:
                            high = ti.min(low_y + side, n + 1.0) - ti.max(low_y, ti.cast(n, ti.f64))
                            volume = whole * (wide / side) * (high / side)
                            mass = volume * frame[5]
                            sums[k, n, 0] += volume
                            sums[k, n, 1] += mass
                            sums[k, n, 2] += mass * speed
                            sums[k, n, 3] += mass * speed2
                            sums[k, n, 4] += volume * u
                            sums[k, n, 5] += volume * v
                            n += 1
                        k += 1

    return add_up


def plan_sums(store, state, least, lower, cell, shape):
    """`particles.contract.Particles.sums_in_plan` of the cells in the box of a `FlowCells`. state: its own, or another
    of the same shape; least: H [m] that counts as snow."""
    grid, box = store.grid, store.box
    at = (grid.lower + grid.dx * np.array([part.start for part in box]) - lower) / cell
    count, side = np.array([part.stop - part.start for part in box]), grid.dx / cell
    low = np.floor(at + EDGE).astype(int).clip(0, shape)
    high = np.ceil(at + side * count - EDGE).astype(int).clip(low, shape)
    sums = np.zeros((*(high - low), 6))
    with runtime.precision(store.precision):
        sums_kernel()(state, store.ground, sums, np.array([*(at - low), side, grid.dx, least, store.density, *count]),
                      *(part.start + MARGIN for part in box))
    return tuple(slice(first, last) for first, last in zip(low.tolist(), high.tolist(), strict=True)), sums
