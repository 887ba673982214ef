"""Snow that a depth-averaged flow lays down: stopped by trees, or come to rest. It raises the 

    trees       dm/dt = -K / v per area    Feistl et al. (2014), doi:10.3189/2014JoG13J055; K of forest [Pa]
    at rest     dm/dt = -m / T             T: time of the deposition

What is laid down takes its momentum with it, so that the speed of what flows on stays. The ground rises by the volume
over a cell, spread as the depth is (`depth.smoothing`), so that the surface of the snow stays where it is.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from scipy import sparse

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.groups import Array, Double, Real, grouped_kernel
from snowmpm.depth.kernel_api import LEAST_DEPTH, MARGIN, SMOOTHING, ColumnArrays, NodeArrays, weights

MASS, MOMENTUM, ENERGY, EMPTY = 0, 1, 4, 5
"""Sums of a step: laid down [kg], momentum (3) and energy of it, columns that hold next to nothing."""
LEAST_SHARE = 1e-5
"""Volume over that of a mean column at the start which a column keeps until it is taken out."""
EMPTIED = 1.5 * LEAST_SHARE
"""The same, below which a column counts as empty."""
CROWD = 0.05
"""Share of empty columns above which they are taken out."""


@ti.func
def mirrored(cell, count):
    """The cell inside of which one beyond a side is the mirror image."""
    return ti.select(cell < 0, -1 - cell, ti.select(cell >= count, 2 * count - 1 - cell, cell))


@ti.func
def over_corners(w):
    """Weights of three nodes after half of them went to each side: the [1 2 1] / 4 of `depth.smoothing` (5,)."""
    return 0.25 * ti.Vector([w[0], 2.0 * w[0] + w[1], w[0] + 2.0 * w[1] + w[2], w[1] + 2.0 * w[2], w[2]])


class Ground(NamedTuple):
    """Heights of nx times ny nodes and beyond the sides, in rows of stride; K of each node; volume laid over it."""

    bed: Array
    stride: int
    nx: int
    ny: int
    detrainment: Array
    laid: Array


class Step(NamedTuple):
    """dt [s]; dx [m]; g [m/s2]; share of snow at rest that becomes ground; volume that a column keeps [m3]; columns."""

    dt: Real
    dx: Double
    g: Double
    resting: Real
    least: Real
    n: int


@functools.cache
def lay_kernel(real, shared):
    """Kernel that lays snow of the columns down. One thread in the order of the columns, so that sums do not depend on
    the number of threads; shared: all threads, by atomics. sums: of the step."""

    @ti.func
    def add(table: ti.template(), at, value):
        if ti.static(shared):
            ti.atomic_add(table[at], value)
        else:
            table[at] = table[at] + value

    @ti.func
    def lift(ground: ti.template(), i, j, rise):
        """Raise the bed at a cell, and at its mirror images just beyond the sides."""
        stride, nx, ny = ground.stride, ground.nx, ground.ny
        add(ground.bed, (i + MARGIN) * stride + j + MARGIN, rise)
        beyond = ti.Vector([ti.select(i == 0, -1, ti.select(i == nx - 1, nx, i)),
                            ti.select(j == 0, -1, ti.select(j == ny - 1, ny, j))])
        if beyond[0] != i:
            add(ground.bed, (beyond[0] + MARGIN) * stride + j + MARGIN, rise)
        if beyond[1] != j:
            add(ground.bed, (i + MARGIN) * stride + beyond[1] + MARGIN, rise)
        if beyond[0] != i and beyond[1] != j:
            add(ground.bed, (beyond[0] + MARGIN) * stride + beyond[1] + MARGIN, rise)

    @grouped_kernel(real)
    def lay(columns: ColumnArrays, nodes: NodeArrays, ground: Ground, sums: Array, step: Step):
        area = step.dx * step.dx
        ti.loop_config(serialize=not shared)
        for p in range(step.n):
            column = columns.reals[p]
            speed2 = column[2] ** 2 + column[3] ** 2 + column[6] ** 2
            i, j = columns.cells[p][0], columns.cells[p][1]
            rho, volume = ti.cast(columns.density[columns.material[p]], real), column[4]
            gone = 0.0 * step.dt
            here = nodes.lookup[0, i + MARGIN] + nodes.lookup[1, j + MARGIN]
            stops = ti.cast(ground.detrainment[here], real)
            if speed2 == 0.0:
                gone = step.resting * volume
            elif stops > 0.0:
                gone = step.dt * stops * volume / (rho * ti.max(LEAST_DEPTH, column[5]) * ti.sqrt(speed2))
            left = ti.max(volume - gone, ti.min(step.least, volume))
            if left < volume:
                given = ti.cast(volume, ti.f64) - ti.cast(left, ti.f64)
                wx, wy = weights(column[0]), weights(column[1])
                ax, ay = over_corners(wx), over_corners(wy)
                height, potential, depth = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                for a in ti.static(range(5)):
                    for b in ti.static(range(5)):
                        x, y = i + a - 2, j + b - 2
                        node = nodes.lookup[0, x + MARGIN] + nodes.lookup[1, y + MARGIN]
                        spread = ti.cast(SMOOTHING * ax[a] * ay[b], ti.f64)
                        if ti.static(0 < a < 4 and 0 < b < 4):
                            w = ti.cast(wx[a - 1] * wy[b - 1], ti.f64)
                            spread += (1.0 - SMOOTHING) * w
                            height += w * ground.bed[(x + MARGIN) * ground.stride + y + MARGIN]
                            potential += w * ti.cast(nodes.values[node][0], ti.f64)
                            add(ground.laid, node, w * given)
                        depth += spread * ti.cast(nodes.values[node][1], ti.f64)
                        lift(ground, mirrored(x, ground.nx), mirrored(y, ground.ny), spread * given / area)
                mass = ti.cast(rho, ti.f64) * given
                add(sums, MASS, mass)
                add(sums, MOMENTUM, mass * column[2])
                add(sums, MOMENTUM + 1, mass * column[3])
                add(sums, MOMENTUM + 2, mass * column[6])
                # Its own energy, less what lifts the snow above the ground that rises
                add(sums, ENERGY, mass * (0.5 * speed2 + step.g * (height - depth) + potential))
                column[4] = left
                columns.reals[p] = column
            if left <= ti.static(EMPTIED / LEAST_SHARE) * step.least:
                add(sums, EMPTY, ti.cast(1.0, ti.f64))

    return lay


class Deposit:
    """laid (n_nodes,): volume laid down over the cell of each node [m3]; time: T [s], None where snow at rest stays
    snow."""

    def __init__(self, grid, detrainment=None, time=None):
        """detrainment: K (nx, ny) [Pa], or None."""
        self._grid, self._time = grid, time
        self._detrainment = real_array(grid.flat(np.zeros(grid.shape) if detrainment is None else detrainment))
        self.laid = real_array(np.zeros(grid.n_nodes))
        self._any = False

    def take(self, solver, dt):
        """Lay down what stops in a step of a `DepthSolver`; -> sums (6,)."""
        store, grid = solver.particles, self._grid
        sums = np.zeros(6)
        share = 0.0
        if self._time is not None:
            share = -math.expm1(-dt / self._time) if self._time > 0.0 else 1.0
        nx, ny = grid.shape.tolist()
        lay_kernel(solver.real, solver.shared)(
            store.arrays, solver.nodes,
            Ground(solver.bed.table, solver.bed.stride, nx, ny, self._detrainment, self.laid), sums,
            Step(dt, grid.dx, -float(solver.gravity[2]), share, LEAST_SHARE * solver.unit, store.flowing))
        self._any |= sums[MASS] > 0.0
        return sums

    def in_plan(self, lower, cell, shape):
        """Volume [m3] over plan cells (columns along x, rows along y); None while there is none."""
        if not self._any:
            return None
        return over_plan(self._grid, self.laid.to_numpy()[self._grid.nodes()], lower, cell, shape)

    def state(self):
        """What changes, by name."""
        return {"laid": self.laid.to_numpy()}

    def restore(self, state):
        """Take over a `state()`."""
        self.laid.from_numpy(np.ascontiguousarray(state["laid"]))
        self._any = bool(state["laid"].any())


def over_plan(grid, volume, lower, cell, shape):
    """Volume (shape) over plan cells, of that over the cells of a `depth.plan_grid.PlanGrid` (nx, ny)."""
    parts = [_shares(grid.lower[a], grid.dx, volume.shape[a], lower[a], cell, shape[a]) for a in (0, 1)]
    return np.asarray(parts[0] @ volume @ parts[1].T)


def _shares(first, dx, count, lower, cell, shape):
    """Sparse (shape, count): the share of each interval of `count` from `first`, `dx` long, that lies in each of
    `shape` intervals from `lower`, `cell` long."""
    starts = first + dx * np.arange(count)
    low = np.floor((starts - lower) / cell + 1e-9).astype(int)
    most = int(np.ceil(dx / cell)) + 1
    rows, columns, values = [], [], []
    for step in range(most):
        at = low + step
        overlap = np.minimum(starts + dx, lower + (at + 1) * cell) - np.maximum(starts, lower + at * cell)
        held = (overlap > 1e-12 * dx) & (at >= 0) & (at < shape)
        rows.append(at[held])
        columns.append(np.flatnonzero(held))
        values.append(overlap[held] / dx)
    return sparse.csr_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                            shape=(shape, count))
