"""Kernels of a step of grains: forces of the pairs, then motion of the grains. Each pair is computed once, and each
grain adds up its own pairs in their order: the same bits for any number of threads.

In a cell that is deformed at the rate L, velocities are those beside x' = L x (SLLOD equations, Evans and Morriss
1984, doi:10.1103/PhysRevA.30.1528). L stretches along the axes and shears planes normal to z. The image of the cell
above along z is shifted by its slide (Lees and Edwards 1972, doi:10.1088/0022-3719/5/15/006).

A pair remembers [tangential spring (3), rolling spring (3), bonded, overlap at which it is free of force]. The last is
zero but of grains that have sintered, until they part.
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.micro.grains.contact import limited, turned

MEMORY = 8
ACTION = 9
"""Numbers of what a pair does: force on its first grain (3), moments on both about their middles (3 + 3)."""


class Grains(NamedTuple):
    """state (n, 9): position, velocity, spin; sizes (n, 3): radius, mass, inertia; fixed (n,): 1 for grains that keep
    their velocity."""

    state: Array
    sizes: Array
    fixed: Array


class Contacts(NamedTuple):
    """pairs (m, 2), memory (m, `MEMORY`), action (m, `ACTION`); starts (n + 1,) and members (2 m,) of `Pairs`."""

    pairs: Array
    memory: Array
    action: Array
    starts: Array
    members: Array


@ti.func
def row3(array: ti.template(), i, k):
    """Three numbers of a row."""
    return ti.Vector([array[i, k], array[i, k + 1], array[i, k + 2]])


@ti.func
def touch(grains: ti.template(), contacts: ti.template(), cell: ti.template(), law: ti.template(), k):
    """Forces and moments of a pair."""
    i, j = contacts.pairs[k, 0], contacts.pairs[k, 1]
    way, u = row3(grains.state, i, 0) - row3(grains.state, j, 0), row3(grains.state, i, 3) - row3(grains.state, j, 3)
    over = ti.round(way[2] / cell[0, 2]) if cell[0, 2] > 0.0 else 0.0
    way -= over * ti.Vector([cell[2, 0], cell[2, 1], cell[0, 2]])
    for a in ti.static(range(2)):
        if cell[0, a] > 0.0:
            way[a] -= ti.round(way[a] / cell[0, a]) * cell[0, a]
    for a in ti.static(range(3)):
        u[a] += cell[1, a] * way[a] + cell[3, a] * way[2]
    ri, rj = grains.sizes[i, 0], grains.sizes[j, 0]
    distance = way.norm()
    overlap = ri + rj - distance
    bonded = contacts.memory[k, 6] > 0.0
    depth = overlap - contacts.memory[k, 7]
    none = ti.Vector.zero(ti.f64, 3)
    force, on_i, on_j, spring, roll = none, none, none, none, none
    if depth > 0.0 or bonded:
        n = way / distance
        arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
        wi, wj = row3(grains.state, i, 6), row3(grains.state, j, 6)
        u_contact = u - (arm_i * wi + arm_j * wj).cross(n)
        reduced = grains.sizes[i, 1] * grains.sizes[j, 1] / (grains.sizes[i, 1] + grains.sizes[j, 1])
        radius, least = ri * rj / (ri + rj), ti.min(ri, rj)
        area = 3.141592653589793 * least**2
        speed = u_contact.dot(n)
        slowed = 2.0 * law[4] * ti.sqrt(law[0] * reduced) * speed
        along = u_contact - speed * n
        spring = turned(row3(contacts.memory, k, 0), n) + law[7] * along
        damped = 2.0 * law[4] * ti.sqrt(law[1] * reduced)
        wanted = -law[1] * spring - damped * along
        turn, held = wi - wj, none
        pull = law[0] * depth - slowed
        if bonded:
            before = row3(contacts.memory, k, 3)
            whirl = n.cross(u) / distance + 0.5 * (wi + wj).dot(n) * n  # of the pair
            roll = before + law[7] * (whirl.cross(before) + turn)
            soft = 0.25 * law[0] * least**2
            slow = 2.0 * law[4] * ti.sqrt(soft * reduced) * radius
            bend = -soft * (roll - roll.dot(n) * n) - slow * (turn - turn.dot(n) * n)
            twist = -0.5 * law[1] * least**2 * roll.dot(n) - slow * turn.dot(n)
            held = bend + twist * n
            tension = -pull / area + 4.0 * bend.norm() / (area * least)
            shear = (wanted.norm() - law[2] * ti.max(0.0, pull)) / area + 2.0 * abs(twist) / (area * least)
            if tension > law[5] or shear > law[6]:
                bonded = False
                roll, held = none, none
        if not bonded:
            pull = ti.max(0.0, pull)
        if depth > 0.0 or bonded:
            grip = law[2] * pull
            if not bonded and wanted.norm() > grip:
                wanted = limited(wanted, grip)
                spring = -(wanted + damped * along) / law[1]  # it slides: the spring follows
            if not bonded and law[3] > 0.0:
                turn -= turn.dot(n) * n
                roll = turned(row3(contacts.memory, k, 3), n) + law[7] * turn
                stiff = law[1] * radius**2
                slow = 2.0 * law[4] * ti.sqrt(stiff * reduced) * radius
                held = -stiff * roll - slow * turn
                limit = law[3] * radius * pull
                if held.norm() > limit:
                    held = limited(held, limit)
                    roll = -(held + slow * turn) / stiff
            force = pull * n + wanted
            on_i, on_j = -arm_i * n.cross(wanted) + held, -arm_j * n.cross(wanted) - held
    for a in ti.static(range(3)):
        contacts.memory[k, a], contacts.memory[k, 3 + a] = spring[a], roll[a]
        contacts.action[k, a], contacts.action[k, 3 + a], contacts.action[k, 6 + a] = force[a], on_i[a], on_j[a]
    contacts.memory[k, 6] = 1.0 if bonded else 0.0
    if not bonded and overlap <= 0.0:
        contacts.memory[k, 7] = 0.0


@ti.func
def move(grains: ti.template(), contacts: ti.template(), cell: ti.template(), law: ti.template(), i):
    """Move a grain by dt (leapfrog)."""
    force, moment = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
    for at in range(contacts.starts[i], contacts.starts[i + 1]):
        k = contacts.members[at]
        if k >= 0:
            force += row3(contacts.action, k, 0)
            moment += row3(contacts.action, k, 3)
        else:
            force -= row3(contacts.action, -k - 1, 0)
            moment += row3(contacts.action, -k - 1, 6)
    dt, kept = law[7], law[11]
    x, v, w = row3(grains.state, i, 0), row3(grains.state, i, 3), row3(grains.state, i, 6)
    if grains.fixed[i] == 0:
        v = kept * v + dt * (force / grains.sizes[i, 1] + ti.Vector([law[8], law[9], law[10]]))
        w = kept * w + dt * moment / grains.sizes[i, 2]
    for a in ti.static(range(3)):
        grains.state[i, a] = x[a] * (1.0 + dt * cell[1, a]) + dt * (v[a] + cell[3, a] * x[2])
        grains.state[i, 3 + a] = v[a] * (1.0 - dt * cell[1, a]) - dt * cell[3, a] * v[2]
        grains.state[i, 6 + a] = w[a]


@ti.func
def deform(cell: ti.template(), dt):
    """Sides and slide of the cell after a step; an image further is the same."""
    for a in ti.static(range(2)):
        cell[2, a] += dt * (cell[1, a] * cell[2, a] + cell[3, a] * cell[0, 2])
    for a in ti.static(range(3)):
        cell[0, a] *= 1.0 + dt * cell[1, a]
    for a in ti.static(range(2)):
        if cell[0, a] > 0.0:
            cell[2, a] -= ti.round(cell[2, a] / cell[0, a]) * cell[0, a]


@functools.cache
def step_kernel(serial):
    """Kernel of steps. cell (4, 3): sides [m] (0: not periodic), rates of strain [1/s], slide along x and y [m], rates
    of shear of x and y along z [1/s]; law (12,): `ContactLaw.numbers`, dt, acceleration of all (3), share of the
    velocity that viscous damping leaves; count: of the pairs. serial: one thread, as many steps as asked for; else all
    threads, one step."""

    @grouped_kernel(ti.f64)
    def in_turn(grains: Grains, contacts: Contacts, cell: Array, law: Array, count: int, steps: int):
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for k in range(count):
                touch(grains, contacts, cell, law, k)
            for i in range(grains.fixed.shape[0]):
                move(grains, contacts, cell, law, i)
            deform(cell, law[7])

    @grouped_kernel(ti.f64)
    def at_once(grains: Grains, contacts: Contacts, cell: Array, law: Array, count: int, steps: int):
        for k in range(count):
            touch(grains, contacts, cell, law, k)
        for i in range(grains.fixed.shape[0]):
            move(grains, contacts, cell, law, i)
        for _ in range(1):
            deform(cell, law[7])

    return in_turn if serial else at_once
