"""What lies over the cells of a map: sums over columns, each spread over the cells around it.

In both directions, a column is spread as a hat, 1 - |x - x_p| / w, whose half width w is the cell of the plan grid, or
that of the map where it is smaller. Cells of a map as large as those of the grid then get the shares N of the spline.
"""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel


@ti.func
def behind(u):
    """Share of a hat of half width 1 that lies before u."""
    low, high = ti.max(-1.0, ti.min(u, 0.0)), ti.max(0.0, ti.min(u, 1.0))
    return 0.5 * (1.0 + low) ** 2 + high - 0.5 * high**2


@ti.func
def shares(f, wide):
    """Of a column at the offset f [cells of the map] from the middle of a cell, in the cell before it, in it and after
    it; wide: cells of the map over half the width of the hat, 1 or more."""
    before, within = behind((-0.5 - f) * wide), behind((0.5 - f) * wide)
    return ti.Vector([before, within - before, 1.0 - within])


@functools.cache
def sums_kernel():
    """Kernel that adds the columns to map cells, as of `particles.contract.Particles.sums_in_plan`. frame (5,): map
    cells in a cell of the plan grid, where the map's window begins [map cells] (2,), first column and one past the
    last. One thread, so that sums do not depend on the number of threads."""

    @taichi_kernel
    def add_up(cells: ti.types.ndarray(), reals: ti.types.ndarray(), material: ti.types.ndarray(),
               density: ti.types.ndarray(), sums: ti.types.ndarray(), frame: ti.types.ndarray()):
        ratio, low_x, low_y = frame[0], frame[1], frame[2]
        wide = ti.max(1.0, 1.0 / ratio)
        ti.loop_config(serialize=True)
        for p in range(ti.cast(frame[3], ti.i32), ti.cast(frame[4], ti.i32)):
            at = ti.Vector([(ti.cast(cells[p][0], ti.f64) + reals[p][0] + 0.5) * ratio - low_x,
                            (ti.cast(cells[p][1], ti.f64) + reals[p][1] + 0.5) * ratio - low_y])
            cell = ti.cast(ti.floor(at), ti.i32)
            f = at - cell - 0.5
            wx, wy = shares(f[0], wide), shares(f[1], wide)
            speed2 = ti.cast(reals[p][2] ** 2 + reals[p][3] ** 2 + reals[p][6] ** 2, ti.f64)
            speed, rho = ti.sqrt(speed2), density[material[p]]
            for i in ti.static(range(3)):
                for j in ti.static(range(3)):
                    row, column = cell[0] + i - 1, cell[1] + j - 1
                    if 0 <= row < sums.shape[0] and 0 <= column < sums.shape[1]:
                        volume = wx[i] * wy[j] * reals[p][4]
                        mass = volume * rho
                        sums[row, column, 0] += volume
                        sums[row, column, 1] += mass
                        sums[row, column, 2] += mass * speed
                        sums[row, column, 3] += mass * speed2
                        for axis in ti.static(range(2)):
                            sums[row, column, 4 + axis] += volume * reals[p][2 + axis]

    return add_up


@functools.cache
def box_kernel():
    """Kernel that finds the least and the largest cell of the columns from `first` to before `end`: box (2, 2)."""

    @taichi_kernel
    def surround(cells: ti.types.ndarray(), box: ti.types.ndarray(), first: int, end: int):
        for _ in range(1):
            low, high = cells[first], cells[first]
            for p in range(first + 1, end):
                low, high = ti.min(low, cells[p]), ti.max(high, cells[p])
            for axis in ti.static(range(2)):
                box[0, axis], box[1, axis] = low[axis], high[axis]

    return surround


def plan_sums(store, lower, cell, shape, rows):
    """`particles.contract.Particles.sums_in_plan` of the rows (first, one past the last) of `depth.columns.Columns`."""
    grid, ratio = store.grid, store.grid.dx / cell
    corner = (np.asarray(lower) - grid.lower) / cell
    if rows[0] == rows[1]:
        return (slice(0, 0), slice(0, 0)), np.zeros((0, 0, 6))
    box = np.zeros((2, 2), np.int32)
    box_kernel()(store.cells, box, *rows)
    low = np.floor(box[0] * ratio - corner - 1.0).astype(int).clip(0, shape)
    high = np.ceil((box[1] + 1) * ratio - corner + 1.0).astype(int).clip(low, shape)
    sums = np.zeros((*(high - low), 6))
    with runtime.precision(store.precision):
        sums_kernel()(store.cells, store.reals, store.material, store.densities, sums,
                      np.array([ratio, *(corner + low), *rows]))
    return tuple(slice(first, last) for first, last in zip(low, high, strict=True)), sums
