"""Kernels of a step of grains: forces of the pairs, then motion of the grains. Each pair is computed once, and each
grain adds up its own pairs in their order: the same bits for any number of threads.

In a cell that is strained at the rates e, velocities are those beside x' = e x (SLLOD equations, Evans and Morriss
1984, doi:10.1103/PhysRevA.30.1528).

A pair remembers [tangential spring (3), rolling spring (3), bonded].
"""

import functools

import taichi as ti

from snowmpm.compiler.launch import taichi_kernel
from snowmpm.micro.grains.contact import limited, turned

MEMORY = 7
ACTION = 9
"""Numbers of what a pair does: force on its first grain (3), moments on both about their middles (3 + 3)."""


@ti.func
def row3(array: ti.template(), i, k):
    """Three numbers of a row."""
    return ti.Vector([array[i, k], array[i, k + 1], array[i, k + 2]])


@functools.cache
def pair_kernel():
    """Kernel of the contacts. state (n, 6 + 3): position, velocity, spin; sizes (n, 3): radius, mass, inertia; cell (2,
    3): sides [m] (0: not periodic) and rates of strain [1/s]; law: `ContactLaw.numbers` and dt."""

    @taichi_kernel
    def contacts(state: ti.types.ndarray(dtype=ti.f64, ndim=2), sizes: ti.types.ndarray(dtype=ti.f64, ndim=2),
                 pairs: ti.types.ndarray(dtype=ti.i32, ndim=2), memory: ti.types.ndarray(dtype=ti.f64, ndim=2),
                 action: ti.types.ndarray(dtype=ti.f64, ndim=2), cell: ti.types.ndarray(dtype=ti.f64, ndim=2),
                 law: ti.types.ndarray(dtype=ti.f64, ndim=1), count: int):
        for k in range(count):
            i, j = pairs[k, 0], pairs[k, 1]
            way, u = row3(state, i, 0) - row3(state, j, 0), row3(state, i, 3) - row3(state, j, 3)
            for a in ti.static(range(3)):
                if cell[0, a] > 0.0:
                    way[a] -= ti.round(way[a] / cell[0, a]) * cell[0, a]
                u[a] += cell[1, a] * way[a]
            ri, rj = sizes[i, 0], sizes[j, 0]
            distance = way.norm()
            overlap = ri + rj - distance
            bonded = memory[k, 6] > 0.0
            none = ti.Vector.zero(ti.f64, 3)
            force, on_i, on_j, spring, roll = none, none, none, none, none
            if overlap > 0.0 or bonded:
                n = way / distance
                arm_i, arm_j = ri - 0.5 * overlap, rj - 0.5 * overlap
                wi, wj = row3(state, i, 6), row3(state, j, 6)
                u_contact = u - (arm_i * wi + arm_j * wj).cross(n)
                reduced = sizes[i, 1] * sizes[j, 1] / (sizes[i, 1] + sizes[j, 1])
                radius = ri * rj / (ri + rj)
                area = 3.141592653589793 * ti.min(ri, rj) ** 2
                speed = u_contact.dot(n)
                pull = law[0] * overlap - 2.0 * law[4] * ti.sqrt(law[0] * reduced) * speed
                if bonded and pull < -law[5] * area:
                    bonded = False
                if not bonded:
                    pull = ti.max(0.0, pull)
                if overlap > 0.0 or bonded:
                    along = u_contact - speed * n
                    spring = turned(row3(memory, k, 0), n) + law[7] * along
                    damped = 2.0 * law[4] * ti.sqrt(law[1] * reduced)
                    wanted = -law[1] * spring - damped * along
                    grip = law[2] * ti.max(0.0, pull)
                    if bonded and wanted.norm() > grip + law[6] * area:
                        bonded = False
                        pull = ti.max(0.0, pull)
                        grip = law[2] * pull
                    most = grip + (law[6] * area if bonded else 0.0)
                    if wanted.norm() > most:
                        wanted = limited(wanted, most)
                        spring = -(wanted + damped * along) / law[1]  # it slides: the spring follows
                    force = pull * n + wanted
                    on_i, on_j = -arm_i * n.cross(wanted), -arm_j * n.cross(wanted)
                    if law[3] > 0.0:
                        turn = (wi - wj) - (wi - wj).dot(n) * n
                        roll = turned(row3(memory, k, 3), n) + law[7] * turn
                        stiff = law[1] * radius**2
                        held = -stiff * roll - 2.0 * law[4] * ti.sqrt(stiff * reduced) * radius * turn
                        limit = law[3] * radius * ti.max(0.0, pull)
                        if held.norm() > limit:
                            held = limited(held, limit)
                            roll = -(held + 2.0 * law[4] * ti.sqrt(stiff * reduced) * radius * turn) / stiff
                        on_i += held
                        on_j -= held
            for a in ti.static(range(3)):
                memory[k, a], memory[k, 3 + a] = spring[a], roll[a]
                action[k, a], action[k, 3 + a], action[k, 6 + a] = force[a], on_i[a], on_j[a]
            memory[k, 6] = 1.0 if bonded else 0.0

    return contacts


@functools.cache
def motion_kernel():
    """Kernel that moves the grains by dt (leapfrog). pull (5,): acceleration of all, dt, and the share of velocity
    that viscous damping leaves; fixed (n,): grains that keep their velocity."""

    @taichi_kernel
    def move(state: ti.types.ndarray(dtype=ti.f64, ndim=2), sizes: ti.types.ndarray(dtype=ti.f64, ndim=2),
             starts: ti.types.ndarray(dtype=ti.i32, ndim=1), members: ti.types.ndarray(dtype=ti.i32, ndim=1),
             action: ti.types.ndarray(dtype=ti.f64, ndim=2), cell: ti.types.ndarray(dtype=ti.f64, ndim=2),
             pull: ti.types.ndarray(dtype=ti.f64, ndim=1), fixed: ti.types.ndarray(dtype=ti.i32, ndim=1)):
        for i in range(fixed.shape[0]):
            force, moment = ti.Vector.zero(ti.f64, 3), ti.Vector.zero(ti.f64, 3)
            for at in range(starts[i], starts[i + 1]):
                k = members[at]
                if k >= 0:
                    force += row3(action, k, 0)
                    moment += row3(action, k, 3)
                else:
                    force -= row3(action, -k - 1, 0)
                    moment += row3(action, -k - 1, 6)
            dt, kept = pull[3], pull[4]
            x, v, w = row3(state, i, 0), row3(state, i, 3), row3(state, i, 6)
            if fixed[i] == 0:
                v = kept * v + dt * (force / sizes[i, 1] + ti.Vector([pull[0], pull[1], pull[2]]))
                w = kept * w + dt * moment / sizes[i, 2]
            for a in ti.static(range(3)):
                state[i, a] = x[a] * (1.0 + dt * cell[1, a]) + dt * v[a]
                state[i, 3 + a], state[i, 6 + a] = v[a] * (1.0 - dt * cell[1, a]), w[a]

    return move
