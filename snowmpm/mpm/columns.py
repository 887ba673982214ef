"""Contact with a surface that cuts the grid anywhere, to second order.

Where a surface (signed distance d, unit normal n out of the solid) crosses a line of nodes along the axis k on which
|n_k| is largest, z = d / |n_k| is the distance to it along that line, in cells. The nodes of a line are

    leader      the first with z > 1/2
    followers   the `reach` nodes below it, z <= 1/2: beside the surface and behind it
    deep nodes  further down

A velocity that vanishes on the surface is linear in d beside it, so the constrained part of a follower is d_f / d_l
times that of its leader. It is imposed as Galerkin's method asks, on test functions that vanish on the surface too:
with r_f = d_f / d_l and v* the velocities without contact (relative to the solid),

    v_l = (m_l v*_l + sum_f r_f m_f v*_f) / (m_l + sum_f r_f^2 m_f),      v_f = r_f v_l

for all components (stick), or for the normal one only (slip, separate), where the tangential ones stay as they are:
the natural condition of zero shear. A linear velocity is reproduced, and a uniform stress gives a line no net force,
because the splines reproduce linear functions; so the wall is exact to second order, wherever it lies between the
nodes. A wall made of nodes that are held acts as if shifted by a third of a cell. Momentum is conserved: what a line
gains, J = sum m (v - v*), is the impulse of the solid.

    slip:      J_n as it comes
    separate:  none if J_n < 0 (it would pull), and only as far as snow has arrived: see `touching`
    Coulomb:   of the change that would make the tangential part stick, J_t, the share min(1, mu |J_n| / |J_t|)

(Bardenhagen, Brackbill & Sulsky 2000, doi:10.1016/S0045-7825(99)00338-2, for the nodes' one by one.) Deep nodes, and
followers without a leader (below a ridge, say), are held one by one (`contact_velocity`).
"""

import functools

import taichi as ti

from snowmpm.blocks import EDGE
from snowmpm.contact import SEPARATE, STICK, contact_velocity
from snowmpm.parallel import chunk, chunks, is_worker

REACH = {"quadratic": 3, "cubic": 4}
"""Followers of a line at most: how far below a leader the nodes of snow on the surface lie."""

FARTHEST = 2.5
"""z up to which a node can be a leader; 1.5 on a plane, more where the surface curves."""

TILT = 0.02
"""By how much another axis must be more normal to the surface before it takes the place of the last one."""

TOUCH = (0.4, 0.8)
"""Followers' mass over the leader's, relative to what it is for snow that fills the half-space above the surface, at
which contact sets in and is complete. A gap between snow and wall lowers it: without the measure, snow would stop
a cell above the wall. It does not depend on how dense the snow lies."""

N_TOTALS = {2: 5, 3: 8}
"""What a surface gave the snow: impulse, minus work, moment about the reference point, minus the work of the solid."""


def half_space_mass(kernel):
    """Function -> mass of node at z, of snow that fills z > 0, over its mass far above: the integral of the spline."""

    @ti.func
    def quadratic(z):
        u = ti.min(ti.max(z, -1.5), 1.5)
        inner = 0.5 + u * (0.75 - u * u / 3.0)
        tail = (1.5 - ti.abs(u)) ** 3 / 6.0
        return ti.select(ti.abs(u) < 0.5, inner, ti.select(u > 0.0, 1.0 - tail, tail))

    @ti.func
    def cubic(z):
        u = ti.min(ti.max(z, -2.0), 2.0)
        a = ti.abs(u)
        inner = 2.0 / 3.0 * a - a**3 / 3.0 + a**4 / 8.0
        outer = 0.5 - (2.0 - a) ** 4 / 24.0
        half = ti.select(a < 1.0, inner, outer)
        return 0.5 + ti.select(u > 0.0, half, -half)

    return {"quadratic": quadratic, "cubic": cubic}[kernel]


@functools.cache
def contact_kernel(dim, real, kernel, flip, stored, moving):
    """Kernel that brings one surface to bear on the nodes of the contact blocks (`contact_blocks.ContactBlocks`).

    stored: distance and normal of each node come from `walls`, where `slots[c]` >= 0; else the surface is the plane
    `x[axis] = level`, its normal along `sign`. moving: the solid moves as `motion` says: velocity, angular velocity,
    reference point (three numbers each; angular velocity about the normal of the plane in 2-D is its last), lengths in
    cells.
    """
    edge = EDGE[dim]
    n_nodes = edge**dim
    stride = n_nodes * (2 if flip else 1)
    vec4 = ti.types.vector(4, real)
    reach = REACH[kernel]
    mass_share = half_space_mass(kernel)

    @ti.func
    def place(q):
        """Integer coordinates of node q in its block."""
        i = ti.Vector.zero(ti.i32, dim)
        for a in ti.static(range(dim)):
            i[a] = q // ti.static(edge ** (dim - 1 - a)) % edge
        return i

    @ti.func
    def wall_at(c, q, slots: ti.template(), walls: ti.template(), coordinates: ti.template(), axis, sign, level):
        """Normal, distance [cells], and whether they are known."""
        wall, known = vec4(0.0), 0
        if ti.static(stored):
            slot = slots[c]
            if slot >= 0:
                known = 1
                wall = walls[slot * n_nodes + q]
        else:
            known = 1
            i = place(q)
            for a in ti.static(range(dim)):
                if a == axis:
                    wall[a] = ti.cast(sign, real)
                    at = ti.cast(edge * coordinates[c, a] + i[a], ti.f64)
                    wall[3] = ti.cast((at - level) * sign, real)
        return wall, known

    @ti.func
    def along(wall):
        """Axis of the line, direction out of the solid on it, z."""
        k, best, component = dim - 1, ti.abs(wall[dim - 1]) + TILT, wall[dim - 1]
        for a in ti.static(range(dim - 1)):
            if ti.abs(wall[a]) > best:
                k, best, component = a, ti.abs(wall[a]), wall[a]
        return k, ti.select(component > 0.0, 1, -1), wall[3] / ti.max(ti.abs(component), 1e-6)

    @ti.func
    def step_along_line(c, q, k, steps, neighbours: ti.template()):
        """Contact block and node `steps` nodes further along axis k; block -1 where there is none."""
        width = 1
        for a in ti.static(range(dim - 1)):
            width = ti.select(k == a, edge ** (dim - 1 - a), width)
        here = q // width % edge
        there, block = here + steps, c
        if there < 0:
            there += edge
            block = neighbours[c, 2 * k]
        elif there >= edge:
            there -= edge
            block = neighbours[c, 2 * k + 1]
        return block, q + (there - here) * width

    @ti.func
    def steps_to_leader(z):
        """Nodes from a follower at z <= 1/2 up to the first with z > 1/2."""
        return ti.floor(1.5 - z, ti.i32)

    @ti.func
    def as_vector(node):
        return ti.Vector([node[a] for a in ti.static(range(dim))])

    @ti.func
    def solid_velocity(c, q, coordinates: ti.template(), motion: ti.template(), dx):
        """Velocity of the solid at a node [m/s]."""
        v = ti.Vector.zero(real, dim)
        if ti.static(moving):
            x = offset(c, q, coordinates, motion) * dx
            if ti.static(dim == 2):
                w = ti.cast(motion[5], real)
                v = ti.Vector([ti.cast(motion[0], real) - w * x[1], ti.cast(motion[1], real) + w * x[0]])
            else:
                w = ti.Vector([ti.cast(motion[3 + a], real) for a in ti.static(range(3))])
                v = ti.Vector([ti.cast(motion[a], real) for a in ti.static(range(3))]) + w.cross(x)
        return v

    @ti.func
    def offset(c, q, coordinates: ti.template(), motion: ti.template()):
        """From the reference point to a node [cells]."""
        i, x = place(q), ti.Vector.zero(real, dim)
        for a in ti.static(range(dim)):
            x[a] = ti.cast(ti.cast(edge * coordinates[c, a] + i[a], ti.f64) - motion[6 + a], real)
        return x

    @ti.func
    def tally(totals: ti.template(), before, after, mass, x, solid):
        """Add what one node gained: impulse [N s], energy it lost [J], moment [N s cells], work it did on the solid."""
        J = mass * (after - before)
        for a in ti.static(range(dim)):
            totals[a] += ti.cast(J[a], ti.f64)
        # Force times the velocity at the end of the step, as the scheme itself does work
        totals[dim] -= ti.cast(J.dot(after), ti.f64)
        if ti.static(dim == 2):
            totals[3] += ti.cast(x[0] * J[1] - x[1] * J[0], ti.f64)
        else:
            moment = x.cross(J)
            for a in ti.static(range(3)):
                totals[4 + a] += ti.cast(moment[a], ti.f64)
        totals[N_TOTALS[dim] - 1] -= ti.cast(J.dot(solid), ti.f64)

    @ti.func
    def write(nodes: ti.template(), address, v, mass):
        node = vec4(0.0)
        for a in ti.static(range(dim)):
            node[a] = v[a]
        node[3] = mass
        nodes[address] = node

    @ti.kernel
    def resolve_contact(nodes: ti.types.ndarray(dtype=vec4, ndim=1), room: int, coordinates: ti.types.ndarray(),
                        neighbours: ti.types.ndarray(), slots: ti.types.ndarray(),
                        walls: ti.types.ndarray(dtype=vec4, ndim=1), axis: int, sign: int, level: ti.f64,
                        motion: ti.types.ndarray(), dx: real, code: int, friction: real, part: ti.types.ndarray(),
                        total: ti.types.ndarray(), n_blocks: int, shares: ti.types.ndarray()):
        for w in range(chunks(shares)):
            if is_worker(w):
                first, last = chunk(w, shares)
                for c in range(first, last):
                    totals = ti.Vector.zero(ti.f64, N_TOTALS[dim])
                    own = 1
                    if ti.static(stored):
                        own = ti.select(slots[c] >= 0, 1, 0)
                    for q in range(n_nodes * own):
                        wall, known = wall_at(c, q, slots, walls, coordinates, axis, sign, level)
                        k, up, z = along(wall)
                        here = room + c * stride + q
                        if z > 0.5 and z < FARTHEST:
                            # A leader, if nodes below follow it
                            n = as_vector(wall)
                            own_v = solid_velocity(c, q, coordinates, motion, dx)
                            mass = nodes[here][3]
                            u = as_vector(nodes[here]) - own_v
                            address, ratio = ti.Vector.zero(ti.i32, reach), ti.Vector.zero(real, reach)
                            masses, below = ti.Vector.zero(real, reach), 0
                            us = ti.Matrix.zero(real, reach, dim)
                            effective, momentum = mass, mass * u
                            full, found = ti.cast(0.0, real), ti.cast(0.0, real)
                            for j in ti.static(range(reach)):
                                address[j] = -1
                                full += mass_share(z - (j + 1))
                                cf, qf = step_along_line(c, q, k, -up * (j + 1), neighbours)
                                if cf >= 0:
                                    wall_f, known_f = wall_at(cf, qf, slots, walls, coordinates, axis, sign, level)
                                    k_f, up_f, z_f = along(wall_f)
                                    follows = known_f == 1 and k_f == k and up_f == up and z_f <= 0.5
                                    at = room + cf * stride + qf
                                    m_f = nodes[at][3]
                                    if follows and steps_to_leader(z_f) == j + 1 and m_f > 0.0:
                                        r = wall_f[3] / wall[3]
                                        u_f = as_vector(nodes[at]) - solid_velocity(cf, qf, coordinates, motion, dx)
                                        address[j], ratio[j], masses[j], below = at, r, m_f, 1
                                        for a in ti.static(range(dim)):
                                            us[j, a] = u_f[a]
                                        effective += r * r * m_f
                                        momentum += r * m_f * u_f
                                        found += m_f
                            if below == 1:
                                # Without mass in the leader, followers on the surface have nothing to be linear with
                                target = momentum * 0.0
                                if effective > 1e-12 * found:
                                    target = momentum / effective
                                a_n = target.dot(n)
                                # Impulses that would stop the normal part, and the tangential one
                                J_n, J_t = mass * (a_n - u.dot(n)), mass * (target - u)
                                for j in ti.static(range(reach)):
                                    u_f = ti.Vector([us[j, a] for a in ti.static(range(dim))])
                                    J_n += masses[j] * (ratio[j] * a_n - u_f.dot(n))
                                    J_t += masses[j] * (ratio[j] * target - u_f)
                                J_t -= J_t.dot(n) * n
                                share_n, share_t = ti.cast(1.0, real), ti.cast(1.0, real)
                                if code == SEPARATE:
                                    expected = full / mass_share(z)
                                    there = found / ti.max(mass, 1e-6 * found)
                                    measure = (there / expected - TOUCH[0]) / ti.static(TOUCH[1] - TOUCH[0])
                                    share_n = ti.select(J_n > 0.0, ti.max(0.0, ti.min(1.0, measure)), 0.0)
                                if code != STICK:
                                    limit = friction * ti.abs(J_n) * share_n
                                    share_t = ti.min(1.0, limit / ti.max(J_t.norm(), 1e-30))
                                if share_n + share_t > 0.0:
                                    change = target - u
                                    part_n = change.dot(n) * n
                                    after = u + share_n * part_n + share_t * (change - part_n) + own_v
                                    tally(totals, u + own_v, after, mass, offset(c, q, coordinates, motion), own_v)
                                    write(nodes, here, after, mass)
                                    for j in ti.static(range(reach)):
                                        if address[j] >= 0:
                                            at = address[j]
                                            cf, qf = step_along_line(c, q, k, -up * (j + 1), neighbours)
                                            v_s = solid_velocity(cf, qf, coordinates, motion, dx)
                                            u_f = ti.Vector([us[j, a] for a in ti.static(range(dim))])
                                            change = ratio[j] * target - u_f
                                            part_n = change.dot(n) * n
                                            after = u_f + share_n * part_n + share_t * (change - part_n) + v_s
                                            tally(totals, u_f + v_s, after, masses[j],
                                                  offset(cf, qf, coordinates, motion), v_s)
                                            write(nodes, at, after, masses[j])
                        elif known == 1 and wall[3] <= 0.0 and nodes[here][3] > 0.0:
                            j = steps_to_leader(z)
                            led = 0
                            if j <= reach:
                                cl, ql = step_along_line(c, q, k, up * j, neighbours)
                                if cl >= 0:
                                    wall_l, known_l = wall_at(cl, ql, slots, walls, coordinates, axis, sign, level)
                                    k_l, up_l, z_l = along(wall_l)
                                    leads = known_l == 1 and k_l == k and up_l == up and z_l > 0.5 and z_l < FARTHEST
                                    led = ti.select(leads, 1, 0)
                            if led == 0:
                                v_s = solid_velocity(c, q, coordinates, motion, dx)
                                before, mass = as_vector(nodes[here]), nodes[here][3]
                                after = contact_velocity(before - v_s, as_vector(wall), code, friction) + v_s
                                tally(totals, before, after, mass, offset(c, q, coordinates, motion), v_s)
                                write(nodes, here, after, mass)
                    for t in ti.static(range(N_TOTALS[dim])):
                        part[c, t] = totals[t]
        ti.loop_config(serialize=True)
        for c in range(n_blocks):
            for t in ti.static(range(N_TOTALS[dim])):
                total[t] += part[c, t]

    return resolve_contact
