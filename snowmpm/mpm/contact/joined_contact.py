"""Contact of a flat, smooth or rough wall with the snow on it, held together along the wall.

As `wall_contact` does line by line, but on functions of motion, and the same of force, that no uniform pressure on the
seen part of the wall does work on (`joined_lines`): the normal velocity (all components, on a wall that snow sticks to)
is

    v_ij = g_i d_ij - e_i,   e_i = sum of kappa (g_{i+1} - g_i) of its pairs + (T / S)_i (h_i - g_i d_i,above)

at the nodes of line i, h_i at the node above. g and h are what Galerkin's method asks: sum m (v - v*)^2 is least. The
equations couple neighbours weakly; conjugate gradients solve them from zero, so that the energy of the motion grows
towards that of the solution, and what is missing when they end never adds any (Hestenes & Stiefel 1952,
doi:10.6028/jres.049.044). Before, nodes behind a smooth wall with hardly any snow follow their lines (`faint_nodes`).
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.mpm.contact.arrays import ContactNodes
from snowmpm.mpm.contact.contact_node import N_TOTALS, node_functions
from snowmpm.mpm.contact.faint_nodes import extension_function
from snowmpm.mpm.contact.lines import REACH

STEPS = 20
"""Of the conjugate gradients at most."""

SMALL = 1e-12
"""Square of the error over that at the start at which they end."""


@functools.cache
def joined_kernel(dim, real, kernel, flip, moving, stick):
    """Kernel that brings the wall of `JoinedLines` to bear; by one thread, since walls have few lines.

    moving: moments are added up; stick: all components vanish on the wall, not the normal one only.
    """
    reach, n_totals = REACH[kernel], N_TOTALS[dim]
    node, extend = node_functions(dim, real, moving), extension_function(dim, real, kernel)
    n_c, lateral, rows = dim if stick else 1, dim - 1, reach + 1
    ABOVE, AHEAD, BACK, ALONE = rows, rows + 1, rows + dim, rows + 2 * dim - 1
    DISTANCE, D_ABOVE, KAPPA, SHARE = dim, dim + rows, dim + rows + 1, dim + rows + dim
    Y, R, D, Q = 0, 2 * n_c, 4 * n_c, 6 * n_c  # solution, what is left, direction, the equations' effect on it: g, h
    S0, S1, MASS, DIAGONAL, ACTIVE = 8 * n_c, 9 * n_c, 10 * n_c, 10 * n_c + 1, 10 * n_c + 3

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
    def above_of(nodes: ti.template(), contact_offset, ints: ti.template(), numbers: ti.template(), i):
        """Place, mass (0 if it counts for nothing) and share T / S of the node above the leader."""
        place, mass, share = ints[i, ABOVE], ti.cast(0.0, real), numbers[i, SHARE]
        if place >= 0:
            mass = nodes[contact_offset + place][3]
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
    def begin(i, nodes: ti.template(), contact_offset, ints: ti.template(), state: ti.template()):
        mass, behind = ti.cast(0.0, real), ti.cast(0.0, real)
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                mass += nodes[contact_offset + ints[i, j]][3]
                if ti.static(j > 0):
                    behind += nodes[contact_offset + ints[i, j]][3]
        state[i, MASS], state[i, ACTIVE] = mass, ti.select(behind > 0.0, 1.0, 0.0)
        for c in ti.static(range(2 * n_c)):
            state[i, Y + c] = 0.0

    @ti.func
    def diagonal(i, nodes: ti.template(), contact_offset, ints: ti.template(), numbers: ti.template(),
                 state: ti.template()):
        _above, m_a, share = above_of(nodes, contact_offset, ints, numbers, i)
        own, total = -share * numbers[i, D_ABOVE], ti.cast(0.0, real)  # de_i / dg_i
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            own += back - ahead
            total += ahead * ahead * state[next_one, MASS] + back * back * state[last_one, MASS]
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                total += nodes[contact_offset + ints[i, j]][3] * (numbers[i, DISTANCE + j] - own) ** 2
        state[i, DIAGONAL], state[i, DIAGONAL + 1] = total, m_a + share * share * state[i, MASS]

    @ti.func
    def taken_off(i, share, first, ints: ti.template(), numbers: ti.template(), state: ti.template()):
        """e of a line, of g and h from a column on."""
        g = get(state, i, first)
        e = share * (get(state, i, first + n_c) - numbers[i, D_ABOVE] * g)
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            e += ahead * (get(state, next_one, first) - g) + back * (g - get(state, last_one, first))
        return e

    @ti.func
    def sum_line(of: ti.template(), i, nodes: ti.template(), contact_offset, ints: ti.template(),
                 numbers: ti.template(), state: ti.template()):
        """Sums of m v and m v d of a line's nodes: of the direction's velocities, or those that the nodes have."""
        n, g = normal_of(numbers, i), get(state, i, D)
        e, S_0, S_1 = g * 0.0, g * 0.0, g * 0.0
        if ti.static(of == "direction"):
            _above, _mass, share = above_of(nodes, contact_offset, ints, numbers, i)
            e = taken_off(i, share, D, ints, numbers, state)
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:
                place, d = contact_offset + ints[i, j], numbers[i, DISTANCE + j]
                if nodes[place][3] > 0.0:
                    v = d * g - e
                    if ti.static(of == "nodes"):
                        v = held(nodes, place, n)
                    S_0 += nodes[place][3] * v
                    S_1 += nodes[place][3] * d * v
        put(state, i, S0, S_0)
        put(state, i, S1, S_1)

    @ti.func
    def tested(of: ti.template(), i, nodes: ti.template(), contact_offset, ints: ti.template(), numbers: ti.template(),
               state: ti.template()):
        """What these velocities are worth to the functions of g and of h."""
        above, m_a, share = above_of(nodes, contact_offset, ints, numbers, i)
        S_0, of_h = get(state, i, S0), ti.Vector.zero(real, n_c)
        of_g = get(state, i, S1) + share * numbers[i, D_ABOVE] * S_0
        for b in ti.static(range(lateral)):
            next_one, ahead = coupling(ints, numbers, state, i, b, True)
            last_one, back = coupling(ints, numbers, state, i, b, False)
            of_g += ahead * (S_0 + get(state, next_one, S0)) - back * (S_0 + get(state, last_one, S0))
        if m_a > 0.0:
            v = get(state, i, D + n_c)
            if ti.static(of == "nodes"):
                v = held(nodes, contact_offset + above, normal_of(numbers, i))
            of_h = m_a * v - share * S_0
        return of_g, of_h

    @ti.func
    def scaled(i, state: ti.template()):
        """What is left over the diagonal, and its product with what is left."""
        r_g, r_h = get(state, i, R), get(state, i, R + n_c)
        z_g, z_h = r_g * 0.0, r_h * 0.0
        if state[i, DIAGONAL] > 0.0:
            z_g = r_g / state[i, DIAGONAL]
        if state[i, DIAGONAL + 1] > 0.0:
            z_h = r_h / state[i, DIAGONAL + 1]
        return z_g, z_h, r_g.dot(z_g) + r_h.dot(z_h)

    @ti.func
    def give(at: ti.template(), place, u, n, totals: ti.template()):
        """Set what the wall holds of a node's velocity."""
        v = node.as_vector(at.nodes[at.offset + place])
        if ti.static(stick):
            v = u
        else:
            v += (u[0] - v.dot(n)) * n
        node.set_velocity(at.nodes, at.offset, place, v, v * 0.0, totals, at.coordinates, at.motion)

    @ti.func
    def finish(i, at: ti.template(), ints: ti.template(), numbers: ti.template(), state: ti.template(),
               totals: ti.template()):
        n, g = normal_of(numbers, i), get(state, i, Y)
        above, _mass, share = above_of(at.nodes, at.offset, ints, numbers, i)
        e = taken_off(i, share, Y, ints, numbers, state)
        for j in ti.static(range(rows)):
            if ints[i, j] >= 0:  # noqa: SIM102
                if at.nodes[at.offset + ints[i, j]][3] > 0.0:
                    give(at, ints[i, j], numbers[i, DISTANCE + j] * g - e, n, totals)
        if share > 0.0:
            give(at, above, get(state, i, Y + n_c), n, totals)

    @grouped_kernel(real)
    def hold(at: ContactNodes, ints: Array, numbers: Array, state: Array, total: Array, n_lines: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            if ti.static(not stick):
                for i in range(n_lines):
                    if ints[i, ALONE] == 1:
                        extend(i, at.nodes, at.offset, ints, normal_of(numbers, i))
            for i in range(n_lines):
                begin(i, at.nodes, at.offset, ints, state)
            for i in range(n_lines):
                if state[i, ACTIVE] > 0.0:
                    diagonal(i, at.nodes, at.offset, ints, numbers, state)
                    sum_line("nodes", i, at.nodes, at.offset, ints, numbers, state)
            left = ti.cast(0.0, real)
            for i in range(n_lines):
                if state[i, ACTIVE] > 0.0:
                    r_g, r_h = tested("nodes", i, at.nodes, at.offset, ints, numbers, state)
                    put(state, i, R, r_g)
                    put(state, i, R + n_c, r_h)
                    z_g, z_h, product = scaled(i, state)
                    put(state, i, D, z_g)
                    put(state, i, D + n_c, z_h)
                    left += product
            enough = SMALL * left
            for step in range(STEPS):  # noqa: B007 (Taichi wants every loop variable new)
                if left > enough:
                    for i in range(n_lines):
                        if state[i, ACTIVE] > 0.0:
                            sum_line("direction", i, at.nodes, at.offset, ints, numbers, state)
                    curvature, before = ti.cast(0.0, real), left
                    for i in range(n_lines):
                        if state[i, ACTIVE] > 0.0:
                            q_g, q_h = tested("direction", i, at.nodes, at.offset, ints, numbers, state)
                            put(state, i, Q, q_g)
                            put(state, i, Q + n_c, q_h)
                            curvature += q_g.dot(get(state, i, D)) + q_h.dot(get(state, i, D + n_c))
                    left = 0.0
                    for i in range(n_lines):
                        if state[i, ACTIVE] > 0.0:
                            for c in ti.static(range(2 * n_c)):
                                state[i, Y + c] += before / curvature * state[i, D + c]
                                state[i, R + c] -= before / curvature * state[i, Q + c]
                            _z_g, _z_h, product = scaled(i, state)
                            left += product
                    for i in range(n_lines):
                        if state[i, ACTIVE] > 0.0:
                            z_g, z_h, _product = scaled(i, state)
                            put(state, i, D, z_g + left / before * get(state, i, D))
                            put(state, i, D + n_c, z_h + left / before * get(state, i, D + n_c))
            totals = ti.Vector.zero(ti.f64, n_totals)
            for i in range(n_lines):
                if state[i, ACTIVE] > 0.0:
                    finish(i, at, ints, numbers, state, totals)
            for t in ti.static(range(n_totals)):
                total[t] += totals[t]

    return hold
