"""Contact with a surface that cuts the grid anywhere, to second order.

A surface (signed distance d, unit normal n out of the solid) crosses lines of nodes, each of which has a leader l above
the surface and followers f beside and behind it (`lines`).
A velocity that vanishes on the surface is linear in d beside it, so the constrained part of a follower is d_f / d_l
times that of its leader. It is imposed as Galerkin's method asks, on test functions that vanish on the surface too:
with r_f = d_f / d_l and v* the velocities without contact (relative to the solid),

    v_l = (m_l v*_l + sum_f r_f m_f v*_f) / (m_l + sum_f r_f^2 m_f),      v_f = r_f v_l

for all components (stick), or for the normal one only (slip, separate), where the tangential ones stay as they are:
the natural condition of zero shear. A linear velocity is reproduced, and a uniform stress gives a line no net force,
because the splines reproduce linear functions; so the wall is exact to second order, wherever it lies between the
nodes. A wall made of nodes that are held acts as if shifted by a third of a cell. Momentum is conserved: what a line
gains, J = sum m (v - v*), is the impulse of the solid.

That is in the mean over a line: beside a surface of slope t in the grid, a test function w keeps -t dx^2 / 4
d/dx (dw/dn) on it. Where the surface ends at another one (an inner corner) or the snow does, a pressure p does the work
of a force pair p t dx^2 / 4 on this: the stress is off by about the pressure there, by 2 % from 3 cells on. Flat walls
at rest that never let go of the snow (slip, stick) hold their lines together instead where they meet
(`joined_contact`). In cells that an oblique surface cuts, few particles stand for a node: 10 % within half a cell (M5).

    slip:      J_n as it comes
    separate:  none if J_n < 0 (it would pull), or as long as snow has not arrived (below)
    Coulomb:   of the change that would make the tangential part stick, J_t, the share min(1, mu max(J_n, 0) / |J_t|)

Snow has arrived where the followers' mass over the leader's is at least what snow above a gap of `lines.GAP` has:
without the measure it would stop a cell above the wall. It does not depend on how dense the snow lies. (A gradual onset
would be a damper: it took a third of the energy of a bar that bounces.)

Snow on one face of an edge also moves nodes beside the other face, up to 3/2 cells beyond the edge. A line there acts
once snow has come around the edge by `lines.GAP`: when its leader has the mass, over that of the node beside it towards
the edge, that such snow gives it. Without this measure the upright flank of a plate stopped a block that slid off the
plate's flat top.

(Bardenhagen, Brackbill & Sulsky 2000, doi:10.1016/S0045-7825(99)00338-2, for the nodes' one by one.) Nodes are held
one by one (`contact_velocity`) where they are deep in the solid or without a leader (below a ridge, say), and, so that
no grain of a thin flow sinks in, where they follow at z < `HELD` in a line that is not in contact, or in one that has
most of its snow below the surface (`PRESSED`).
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, in_order, is_worker
from snowmpm.mpm.contact.arrays import ContactNodes, LineArrays
from snowmpm.mpm.contact.contact_node import N_TOTALS, node_functions
from snowmpm.mpm.contact.lines import REACH
from snowmpm.mpm.node import block_nodes
from snowmpm.mpm.picker import picker
from snowmpm.particles.blocks import EDGE
from snowmpm.stepping.contact_velocity import SEPARATE, STICK, contact_velocity

PRESSED = 3.0
"""Followers' mass over the leader's, relative to what it is for snow that fills the half-space above the surface, above
which most of the snow lies below the surface, or closer to it than a quarter of a cell: a lone grain, say. A velocity
linear in d that leaves the wall would carry what lies below further in, so the nodes of the line are held one by one
instead."""

HELD = -0.5
"""z below which followers of a line without contact are held one by one."""

NOWHERE = -1e3
"""In place of `HELD` for a line beyond an edge that no snow has come around."""

FAINTEST = 1e-12
"""Share of the followers' mass below which a line has too little to be linear with: it then rests on the surface."""


class Rubbing(NamedTuple):
    """Code of the contact, coefficient of friction; coefficients and the window of nodes that they are of, or what
    another velocity field took off (`contact_kernel`)."""

    code: int
    friction: Real
    coefficients: Array
    window: Array


class Work(NamedTuple):
    """Contact blocks to visit, n of them, cut into chunks."""

    n: int
    chunk_bounds: Array
    blocks: Array


@functools.cache
def contact_kernel(dim, real, kernel, flip, moving, serial, varies=False, relieved=False):
    """Kernel that brings one surface (`lines.Lines`) to bear on the nodes of the contact blocks.

    moving: the solid moves as `motion` says (`contact_node`), and moments are added up too. varies: the coefficient of
    friction is that of the node in plan: coefficients (nx, ny) of those from window[0], window[1] on
    (`stepping.basal_friction`), in place of `friction`. relieved: `Work` names the contact blocks to visit, and
    coefficients (nodes, dim or more) holds the impulse that another velocity field took off each node
    (`field_pairs.FieldPairs.relief`): friction is of what is left.
    """
    reach, edge, stride = REACH[kernel], EDGE[dim], block_nodes(dim)
    n_totals = N_TOTALS[dim]
    node, pick = node_functions(dim, real, moving), picker(relieved)

    @ti.func
    def coefficient(place, coordinates: ti.template(), rubbing: ti.template()):
        mu = rubbing.friction
        if ti.static(varies):
            at, c, q = ti.Vector.zero(ti.i32, 2), place // ti.static(stride), place % ti.static(stride)
            for a in ti.static(range(dim - 1)):
                i = edge * coordinates[c, a] + q // ti.static(edge ** (dim - 1 - a)) % edge - rubbing.window[a]
                at[a] = ti.max(0, ti.min(i, rubbing.window[2 + a] - 1))
            mu = ti.cast(rubbing.coefficients[at[0], at[1]], real)
        return mu

    @ti.func
    def normal_of(relief: ti.template(), place, n):
        """Part along n of what the other field gave a node."""
        found = ti.cast(0.0, real)
        for a in ti.static(range(dim)):
            found += relief[place, a] * n[a]
        return found

    @ti.func
    def own_share(relief: ti.template(), place, n, u, mass):
        """Share of the impulse that stops a node at the wall by which the node itself presses."""
        share = ti.cast(1.0, real)
        if ti.static(relieved):
            whole = -mass * u.dot(n)
            if whole > 0.0:
                share = ti.max(0.0, ti.min(1.0, 1.0 + normal_of(relief, place, n) / whole))
        return share

    @ti.func
    def act_on_line(line, at: ti.template(), lines: ti.template(), rubbing: ti.template(), friction, dx,
                    totals: ti.template()):
        leader, code = lines.places[line, 0], rubbing.code
        n = ti.Vector([lines.numbers[line, a] for a in ti.static(range(dim))])
        mass, found = at.nodes[at.offset + leader][3], ti.cast(0.0, real)
        place, ratio = ti.Vector.zero(ti.i32, reach), ti.Vector.zero(real, reach)
        masses, u_f = ti.Vector.zero(real, reach), ti.Matrix.zero(real, reach, dim)
        for j in ti.static(range(reach)):
            place[j], ratio[j] = lines.places[line, 1 + j], lines.numbers[line, dim + j]
            if place[j] >= 0:
                masses[j] = at.nodes[at.offset + place[j]][3]
            found += masses[j]
        if found > 0.0:
            u = node.as_vector(at.nodes[at.offset + leader])
            u -= node.solid_velocity(leader, at.coordinates, at.motion, dx)
            effective, momentum = mass, mass * u
            given, led, ratios = ti.cast(0.0, real), ti.cast(0.0, real), mass  # sums of the other's impulse along n
            if ti.static(relieved):
                given = normal_of(rubbing.coefficients, leader, n)
                led = given
            for j in ti.static(range(reach)):
                if masses[j] > 0.0:
                    solid = node.solid_velocity(place[j], at.coordinates, at.motion, dx)
                    u_j = node.as_vector(at.nodes[at.offset + place[j]]) - solid
                    for a in ti.static(range(dim)):
                        u_f[j, a] = u_j[a]
                    effective += ratio[j] * ratio[j] * masses[j]
                    momentum += ratio[j] * masses[j] * u_j
                    if ti.static(relieved):
                        own = normal_of(rubbing.coefficients, place[j], n)
                        ratios += ratio[j] * masses[j]
                        given, led = given + own, led + ratio[j] * own
            target = momentum * 0.0
            if effective > FAINTEST * found:
                target = momentum / effective
                given -= ratios / effective * led
            # Impulse that makes the line linear: J_n along n, J_t along the surface
            J = mass * (target - u)
            for j in ti.static(range(reach)):
                J += masses[j] * (ratio[j] * target - u_f[j, :])
            J_n = J.dot(n)
            share_n, share_t, held_below = ti.cast(1.0, real), ti.cast(1.0, real), ti.cast(HELD, real)
            if code == SEPARATE:
                share_n = ti.select(J_n > 0.0 and found >= mass * lines.numbers[line, dim + reach + 2], 1.0, 0.0)
                if found >= PRESSED * mass * lines.numbers[line, dim + reach] and target.dot(n) > 0.0:
                    share_n, held_below = 0.0, 1.0
            beside = lines.places[line, 1 + reach]
            if beside >= 0:  # noqa: SIM102 (Taichi looks up what stands right of `and` in any case)
                if mass < lines.numbers[line, dim + reach + 3] * at.nodes[at.offset + beside][3]:
                    share_n, held_below = 0.0, ti.cast(NOWHERE, real)
            if code != STICK:
                limit = friction * ti.max(0.0, J_n + given) * share_n
                share_t = ti.min(1.0, limit / ti.max((J - J_n * n).norm(), 1e-30))
            if share_n > 0.0 and mass > 0.0:  # a hidden leader keeps its velocity (`hidden_nodes`)
                change = target - u
                part = change.dot(n) * n
                node.set_velocity(at.nodes, at.offset, leader, u + part + share_t * (change - part),
                                  node.solid_velocity(leader, at.coordinates, at.motion, dx), totals, at.coordinates,
                                  at.motion)
            for j in ti.static(range(reach)):
                if masses[j] > 0.0:
                    u_j = u_f[j, :]
                    after = u_j
                    if share_n > 0.0:
                        change = ratio[j] * target - u_j
                        part = change.dot(n) * n
                        after = u_j + part + share_t * (change - part)
                    elif ratio[j] * lines.numbers[line, dim + reach + 1] < held_below:
                        own = own_share(rubbing.coefficients, place[j], n, u_j, masses[j])
                        after = contact_velocity(u_j, n, code, friction * own)
                    solid = node.solid_velocity(place[j], at.coordinates, at.motion, dx)
                    node.set_velocity(at.nodes, at.offset, place[j], after, solid, totals, at.coordinates, at.motion)

    @grouped_kernel(real)
    def resolve_contact(at: ContactNodes, lines: LineArrays, rubbing: Rubbing, dx: Real, part: Array, total: Array,
                        work: Work):
        ti.loop_config(serialize=ti.static(serial))
        for w in range(chunks(work.chunk_bounds)):
            if is_worker(w):
                first, last = chunk(w, work.chunk_bounds)
                for k in range(first, last):
                    c = pick(work.blocks, k)
                    totals = ti.Vector.zero(ti.f64, n_totals)
                    for line in range(lines.start[c], lines.start[c + 1]):
                        mu = coefficient(lines.places[line, 0], at.coordinates, rubbing)
                        act_on_line(line, at, lines, rubbing, mu, dx, totals)
                    for i in range(lines.deep_start[c], lines.deep_start[c + 1]):
                        place = lines.deep[i]
                        if at.nodes[at.offset + place][3] > 0.0:
                            n = ti.Vector([lines.deep_normals[i, a] for a in ti.static(range(dim))])
                            solid = node.solid_velocity(place, at.coordinates, at.motion, dx)
                            mu = coefficient(place, at.coordinates, rubbing)
                            u = node.as_vector(at.nodes[at.offset + place]) - solid
                            mu *= own_share(rubbing.coefficients, place, n, u, at.nodes[at.offset + place][3])
                            u = contact_velocity(u, n, rubbing.code, mu)
                            node.set_velocity(at.nodes, at.offset, place, u, solid, totals, at.coordinates,
                                              at.motion)
                    for t in ti.static(range(n_totals)):
                        part[c, t] = totals[t]
        ti.loop_config(serialize=ti.static(in_order()))
        for k in range(work.n):
            for t in ti.static(range(n_totals)):
                total[t] += part[pick(work.blocks, k), t]

    return resolve_contact
