"""From columns of snow to the nodes of the plan grid: volume, momentum, and what tells how fast snow gathers there.

    V_i = sum_p V_p w_ip,   M_i = sum_p V_p v_p w_ip,   R_i = sum_p V_p v_p . grad w_ip,   G_i = sum_p V_p grad w_ip

Columns are cut into `WORKERS` parts whatever the number of threads, each with nodes of its own, so that sums do not
depend on that number; on a GPU all add to the same nodes by atomics.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunks, is_worker, worker
from snowmpm.depth.arrays import ColumnArrays, NodeArrays, Tallies
from snowmpm.depth.plan_grid import MARGIN, TILE
from snowmpm.depth.spline import first_derivatives, weights

TALLIES = 7
"""Numbers of a node: V, M (2), R dx, G dx (2), volumes over the mean one of a column; mass of snow cover that columns
over its cell would take up in the step, over that of a mean column of water [-]."""

WORKERS = 4
"""Parts that columns are cut into on a CPU: more threads than these do not help."""

INTAKE = 7
"""Place in the numbers of a column of the snow cover that it would take up [kg/s]."""

WATER = 1000.0
"""[kg/m3]"""

SEGMENT = 128
"""Columns that one thread takes at a time; sums over them are reported together."""


@ti.func
def moved(cell, offset, way):
    """Cell and offset after a way [cells]."""
    offset += way
    shift = ti.floor(offset + 0.5)
    return cell + ti.cast(shift, ti.i32), offset - shift


@functools.cache
def scatter_kernel(real, shared, takes, serial, sets=1):
    """Kernel that drifts all columns for the time `half` [s] and adds them to the nodes. takes: whether there is
    snow cover to take up.

    shared: whether all threads add to the same nodes, by atomics. sets: of nodes.
    """

    @ti.func
    def add(sums: ti.template(), place, values):
        if ti.static(shared):
            for k in ti.static(range(TALLIES - 1)):
                ti.atomic_add(sums[place][k], values[k])
        else:
            sums[place] = sums[place] + values

    @grouped_kernel(real)
    def scatter(columns: ColumnArrays, nodes: NodeArrays, tallies: Tallies, bounds: Array, half: Real,
                inverse_dx: Real, n: int):
        ti.loop_config(serialize=serial)
        for worker_at in range(chunks(bounds)):
            if is_worker(worker_at):
                first_node = 0 if ti.static(shared) else worker(worker_at) * tallies.n_nodes
                for p in range(bounds[worker(worker_at)] * SEGMENT,
                               ti.min(bounds[worker(worker_at) + 1] * SEGMENT, n)):
                    column = columns.reals[p]
                    v = ti.Vector([column[2], column[3]])
                    cell, f = moved(columns.cells[p], ti.Vector([column[0], column[1]]), half * inverse_dx * v)
                    own = first_node
                    if ti.static(sets > 1):
                        own += nodes.set_of[columns.material[p]]
                    columns.cells[p] = cell
                    column[0], column[1] = f[0], f[1]
                    columns.reals[p] = column
                    volume = column[4] / tallies.unit
                    wx, wy = weights(f[0]), weights(f[1])
                    dx, dy = first_derivatives(f[0]), first_derivatives(f[1])
                    for i in ti.static(range(3)):
                        row = nodes.lookup[0, cell[0] + (i - 1 + MARGIN)]
                        for j in ti.static(range(3)):
                            node = row + nodes.lookup[1, cell[1] + (j - 1 + MARGIN)]
                            place = own + node
                            share = volume * wx[i] * wy[j]
                            along = volume * ti.Vector([dx[i] * wy[j], wx[i] * dy[j]])
                            add(tallies.sums, place, ti.Vector([share, share * v[0], share * v[1], along.dot(v),
                                                                along[0], along[1], 0.0 * share]))
                            for k in ti.static(range(sets)):  # all have their numbers wherever one is
                                at = first_node + k * (tallies.n_nodes // sets) + node
                                tallies.touched[at // (TILE * TILE)] = 1
                    if ti.static(takes):
                        place = own + nodes.lookup[0, cell[0] + MARGIN] + nodes.lookup[1, cell[1] + MARGIN]
                        wanted = 2.0 * half * column[INTAKE] / (WATER * tallies.unit)
                        if ti.static(shared):
                            ti.atomic_add(tallies.sums[place][TALLIES - 1], wanted)
                        else:
                            tallies.sums[place][TALLIES - 1] = tallies.sums[place][TALLIES - 1] + wanted

    return scatter
