"""From columns of snow to the nodes of the plan grid: volume, momentum, and what tells how fast snow gathers there.

    V_i = sum_p V_p w_ip,   M_i = sum_p V_p v_p w_ip,   R_i = sum_p V_p v_p . grad w_ip,   G_i = sum_p V_p grad w_ip

Columns are cut into `WORKERS` parts whatever the number of threads, each with nodes of its own, so that sums do not
depend on that number; on a GPU all add to the same nodes by atomics.
"""

import functools

import taichi as ti

from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunks, is_worker, worker
from snowmpm.depth.plan_grid import MARGIN, TILE
from snowmpm.depth.spline import first_derivatives, weights

TALLIES = 6
"""Numbers of a node: V, M (2), R dx, G dx (2), volumes over the mean one of a column."""

WORKERS = 4
"""Parts that columns are cut into on a CPU: more threads than these do not help."""

SEGMENT = 128
"""Columns that one thread takes at a time; sums over them are reported together."""


@ti.func
def moved(cell, offset, way):
    """Cell and offset after a way [cells]."""
    offset += way
    shift = ti.floor(offset + 0.5)
    return cell + ti.cast(shift, ti.i32), offset - shift


@functools.cache
def scatter_kernel(real, shared, serial):
    """Kernel that drifts all columns for the time `half` [s] and adds them to the nodes.

    shared: whether all threads add to the same nodes, by atomics.
    """

    @ti.func
    def add(tallies: ti.template(), place, k: ti.template(), value):
        if ti.static(shared):
            ti.atomic_add(tallies[place, k], value)
        else:
            tallies[place, k] = tallies[place, k] + value

    @taichi_kernel
    def scatter(cells: ti.types.ndarray(), reals: ti.types.ndarray(), lookup: ti.types.ndarray(),
                tallies: ti.types.ndarray(), touched: ti.types.ndarray(), bounds: ti.types.ndarray(),
                half: real, inverse_dx: real, unit: real, n_nodes: int, n: int):
        ti.loop_config(serialize=serial)
        for worker_at in range(chunks(bounds)):
            if is_worker(worker_at):
                first_node = 0 if ti.static(shared) else worker(worker_at) * n_nodes
                for p in range(bounds[worker(worker_at)] * SEGMENT,
                               ti.min(bounds[worker(worker_at) + 1] * SEGMENT, n)):
                    v = ti.Vector([reals[p, 2], reals[p, 3]])
                    cell, f = moved(ti.Vector([cells[p, 0], cells[p, 1]]), ti.Vector([reals[p, 0], reals[p, 1]]),
                                    half * inverse_dx * v)
                    for a in ti.static(range(2)):
                        cells[p, a] = cell[a]
                        reals[p, a] = f[a]
                    volume = reals[p, 4] / unit
                    wx, wy = weights(f[0]), weights(f[1])
                    dx, dy = first_derivatives(f[0]), first_derivatives(f[1])
                    for i in ti.static(range(3)):
                        row = lookup[0, cell[0] + (i - 1 + MARGIN)]
                        for j in ti.static(range(3)):
                            node = row + lookup[1, cell[1] + (j - 1 + MARGIN)]
                            place = first_node + node
                            share = volume * wx[i] * wy[j]
                            along = volume * ti.Vector([dx[i] * wy[j], wx[i] * dy[j]])
                            add(tallies, place, 0, share)
                            add(tallies, place, 3, along.dot(v))
                            for a in ti.static(range(2)):
                                add(tallies, place, 1 + a, share * v[a])
                                add(tallies, place, 4 + a, along[a])
                            touched[place // (TILE * TILE)] = 1

    return scatter
