"""Contact of a flat, smooth or rough wall with the snow on it, held together along the wall.

As `columns` does line by line, but on functions of motion, and the same of force, that no uniform pressure on the seen
part of the wall does work on (`joined_lines`): the normal velocity (all components, on a wall that snow sticks to) is

    v_ij = g_i d_ij - e_i,   e_i = sum of kappa (g_{i+1} - g_i) of its pairs + (T / S)_i (h_i - g_i d_i,above)

at the nodes of line i, h_i at the node above. g and h are what Galerkin's method asks: sum m (v - v*)^2 is least. The
equations couple neighbours weakly. They are solved by Jacobi's iteration from zero, its diagonal replaced by the sum of
the sizes of a row, no less than any eigenvalue: then what is not yet there when it ends is motion that is missing, and
no error ever adds energy.

Nodes behind a smooth wall that less than a hundredth of their leader's mass moves, one particle's perhaps, have the
tangential velocity that is linear along the line through the leader and the node above it, to which their momentum goes
(extended B-splines: Yamaguchi, Moriguchi & Terada 2021, doi:10.1002/nme.6620). One particle cannot tell how such a node
moves, and its stress would be off by a third of the pressure.
"""

import functools

import taichi as ti

from snowmpm.launch import taichi_kernel
from snowmpm.mpm.held_nodes import N_TOTALS, node_functions
from snowmpm.mpm.lines import REACH

SWEEPS = 12
"""Of Jacobi's iteration: 1 % of the slowest part of the solution is left."""

FAINT = 0.01
"""Mass of a node over its leader's below which it moves as its line does."""


@functools.cache
def joined_kernel(dim, real, kernel, flip, moving, stick):
    """Kernel that brings the wall of `JoinedLines` to bear; by one thread, since walls have few lines.

    moving: moments are added up; stick: all components vanish on the wall, not the normal one only.
    """
    vec4, reach, n_totals = ti.types.vector(4, real), REACH[kernel], N_TOTALS[dim]
    node = node_functions(dim, real, flip, moving)
    n_c, lateral, rows = dim if stick else 1, dim - 1, reach + 1
    ABOVE, AHEAD, BACK, ALONE = rows, rows + 1, rows + dim, rows + 2 * dim - 1
    DISTANCE, D_ABOVE, KAPPA, SHARE = dim, dim + rows, dim + rows + 1, dim + rows + dim
    G, H, R0, RG, WEIGHT, DG, DH, ACTIVE = 0, n_c, 2 * n_c, 3 * n_c, 4 * n_c, 4 * n_c + 1, 4 * n_c + 2, 4 * n_c + 3

    @ti.func
    def get(table: ti.template(), i, first):
        return ti.Vector([table[i, first + c] for c in ti.static(range(n_c))])

    @ti.func
    def put(table: ti.template(), i, first, value):
        for c in ti.static(range(n_c)):
            table[i, first + c] = value[c]

    @ti.func
    def normal_of(numbers: ti.template(), i):
        return ti.Vector([numbers[i, a] for a in ti.static(range(dim))])

    @ti.func
    def held(nodes: ti.template(), place, n):
        """What the wall holds of a node's velocity."""
        v = node.as_vector(nodes[place])
        result = ti.Vector.zero(real, n_c)
        if ti.static(stick):
            result = v
        else:
            result[0] = v.dot(n)
        return result

    @ti.func
    def above_of(nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), i):
        """Place, mass (0 if it counts for nothing) and share T / S of the node above the leader."""
        place, mass, share = ints[i, ABOVE], ti.cast(0.0, real), numbers[i, SHARE]
        if place >= 0:
            mass = nodes[room + place][3]
        return place, mass, ti.select(mass > 0.0, share, 0.0)

    @ti.func
    def coupling(ints: ti.template(), numbers: ti.template(), state: ti.template(), i, b, ahead: ti.template()):
        """Neighbour ahead or back along b, and kappa of the pair; 0 for none that is in contact."""
        other, kappa = ints[i, (AHEAD if ti.static(ahead) else BACK) + b], ti.cast(0.0, real)
        if other >= 0:  # noqa: SIM102 (Taichi looks up what stands right of `and` in any case)
            if state[other, ACTIVE] > 0.0:
                kappa = numbers[i if ti.static(ahead) else other, KAPPA + b]
        return ti.max(other, 0), kappa

    @ti.func
    def extend(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template()):
        """Give followers with hardly any mass the tangential velocity of their line."""
        leader, above = room + ints[i, 0], ints[i, ABOVE]
        if ints[i, ALONE] == 1 and above >= 0:
            above += room
            n, m_l, m_a = normal_of(numbers, i), nodes[leader][3], nodes[above][3]
            if m_l > 0.0 and m_a > 0.5 * m_l:
                v_l, v_a = node.as_vector(nodes[leader]), node.as_vector(nodes[above])
                limit, found = FAINT * m_l, 0
                p_l, p_a, mass_l, mass_a = m_l * v_l, m_a * v_a, m_l, m_a
                for j in ti.static(range(1, rows)):
                    if ints[i, j] >= 0:
                        at = nodes[room + ints[i, j]]
                        if at[3] > 0.0 and at[3] < limit:
                            found = 1
                            p = at[3] * node.as_vector(at)
                            p_l += (1.0 + j) * p
                            p_a -= float(j) * p
                            mass_l += (1.0 + j) * at[3]
                            mass_a -= float(j) * at[3]
                if found == 1:
                    new_l, new_a = p_l / mass_l, p_a / mass_a
                    for j in ti.static(range(1, rows)):
                        if ints[i, j] >= 0:
                            at = nodes[room + ints[i, j]]
                            if at[3] > 0.0 and at[3] < limit:
                                tangential(nodes, room + ints[i, j], (1.0 + j) * new_l - float(j) * new_a, n)
                    tangential(nodes, leader, new_l, n)
                    tangential(nodes, above, new_a, n)

    @ti.func
    def tangential(nodes: ti.template(), place, v, n):
        """Give a node the tangential part of v."""
        before, result = node.as_vector(nodes[place]), nodes[place]
        change = v - before
        change -= change.dot(n) * n
        for a in ti.static(range(dim)):
            result[a] += change[a]
        nodes[place] = result

    @ti.func
    def begin(i, nodes: ti.template(), room, ints: ti.template(), state: ti.template()):
        behind = ti.cast(0.0, real)
        for j in ti.static(range(1, rows)):
            if ints[i, j] >= 0:
                behind += nodes[room + ints[i, j]][3]
        state[i, ACTIVE] = ti.select(behind > 0.0, 1.0, 0.0)
        for c in ti.static(range(2 * n_c)):
            state[i, c] = 0.0

    @ti.func
    def slopes(i, share, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        """de_i / dg_i, and the sum of the sizes of the others, de_i / dh_i too."""
        own, others = -share * numbers[i, D_ABOVE], share
        for b in ti.static(range(lateral)):
            _next, ahead = coupling(ints, numbers, state, i, b, True)
            _last, back = coupling(ints, numbers, state, i, b, False)
            own += back - ahead
            others += ti.abs(ahead) + ti.abs(back)
        return own, others

    @ti.func
    def weigh(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        """Mass of a line, each node's times the sizes of all that moves it."""
        _above, _mass, share = above_of(nodes, room, ints, numbers, i)
        own, others = slopes(i, share, ints, numbers, state)
        weight = ti.cast(0.0, real)
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                weight += nodes[room + ints[i, j]][3] * (ti.abs(numbers[i, DISTANCE + j] - own) + others)
        state[i, WEIGHT] = weight

    @ti.func
    def diagonal(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        """Sum of the sizes of a row of the equations, or more: no less than its eigenvalues."""
        _above, m_a, share = above_of(nodes, room, ints, numbers, i)
        own, others = slopes(i, share, ints, numbers, state)
        total = ti.cast(0.0, real)
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            total += ti.abs(ahead) * state[next_one, WEIGHT] + ti.abs(back) * state[last_one, WEIGHT]
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                size = ti.abs(numbers[i, DISTANCE + j] - own)
                total += nodes[room + ints[i, j]][3] * size * (size + others)
        state[i, DG], state[i, DH] = total, m_a + share * state[i, WEIGHT]

    @ti.func
    def taken_off(i, share, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        """e of a line."""
        g = get(state, i, G)
        e = share * (get(state, i, H) - numbers[i, D_ABOVE] * g)
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            e += ahead * (get(state, next_one, G) - g) + back * (g - get(state, last_one, G))
        return e

    @ti.func
    def residual(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        n, g = normal_of(numbers, i), get(state, i, G)
        _above, _mass, share = above_of(nodes, room, ints, numbers, i)
        e = taken_off(i, share, ints, numbers, state)
        total, turned = g * 0.0, g * 0.0
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                place, d = room + ints[i, j], numbers[i, DISTANCE + j]
                if nodes[place][3] > 0.0:
                    left = nodes[place][3] * (held(nodes, place, n) - (d * g - e))
                    total += left
                    turned += d * left
        put(state, i, R0, total)
        put(state, i, RG, turned + share * numbers[i, D_ABOVE] * total)

    @ti.func
    def improve(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        total, slope = get(state, i, R0), get(state, i, RG)
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            slope += ahead * (total + get(state, next_one, R0)) - back * (total + get(state, last_one, R0))
        if state[i, DG] > 0.0:
            put(state, i, G, get(state, i, G) + slope / state[i, DG])
        above, m_a, share = above_of(nodes, room, ints, numbers, i)
        if m_a > 0.0:
            h = get(state, i, H)
            slope_h = m_a * (held(nodes, room + above, normal_of(numbers, i)) - h) - share * total
            put(state, i, H, h + slope_h / state[i, DH])

    @ti.func
    def give(nodes: ti.template(), room, place, u, n, totals: ti.template(), coordinates: ti.template(),
             motion: ti.template()):
        """Set what the wall holds of a node's velocity."""
        v = node.as_vector(nodes[room + place])
        if ti.static(stick):
            v = u
        else:
            v += (u[0] - v.dot(n)) * n
        node.set_velocity(nodes, room, place, v, v * 0.0, totals, coordinates, motion)

    @ti.func
    def finish(i, nodes: ti.template(), room, ints: ti.template(), numbers: ti.template(), state: ti.template(),
               totals: ti.template(), coordinates: ti.template(), motion: ti.template()):
        n, g = normal_of(numbers, i), get(state, i, G)
        above, _mass, share = above_of(nodes, room, ints, numbers, i)
        e = taken_off(i, share, ints, numbers, state)
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:  # noqa: SIM102
                if nodes[room + ints[i, j]][3] > 0.0:
                    give(nodes, room, ints[i, j], numbers[i, DISTANCE + j] * g - e, n, totals, coordinates, motion)
        if share > 0.0:
            give(nodes, room, above, get(state, i, H), n, totals, coordinates, motion)

    @taichi_kernel
    def hold(nodes: ti.types.ndarray(dtype=vec4, ndim=1), room: int, coordinates: ti.types.ndarray(),
             ints: ti.types.ndarray(), numbers: ti.types.ndarray(), state: ti.types.ndarray(),
             motion: ti.types.ndarray(), total: ti.types.ndarray(), n_lines: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            if ti.static(not stick):
                for i in range(n_lines):
                    extend(i, nodes, room, ints, numbers)
            for i in range(n_lines):
                begin(i, nodes, room, ints, state)
            for i in range(n_lines):
                weigh(i, nodes, room, ints, numbers, state)
            for i in range(n_lines):
                diagonal(i, nodes, room, ints, numbers, state)
            for sweep in range(SWEEPS):  # noqa: B007 (Taichi wants every loop variable new)
                for i in range(n_lines):
                    if state[i, ACTIVE] > 0.0:
                        residual(i, nodes, room, ints, numbers, state)
                for i in range(n_lines):
                    if state[i, ACTIVE] > 0.0:
                        improve(i, nodes, room, ints, numbers, state)
            totals = ti.Vector.zero(ti.f64, n_totals)
            for i in range(n_lines):
                if state[i, ACTIVE] > 0.0:
                    finish(i, nodes, room, ints, numbers, state, totals, coordinates, motion)
            for t in ti.static(range(n_totals)):
                total[t] += totals[t]

    return hold
