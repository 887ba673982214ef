"""Motion of members that meet in joints, in substeps, compiled (`framework` has the equations)."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.components.structures.rod_motion import put, vector

SMALL = 1e-4
"""Angle [rad] below which sines and cotangents are taken from their series, exact to round-off there."""

# Columns of places: position, velocity, force from without, force from within, mass, whether it is a foot
X, V, F, INNER, MASS, HELD = 0, 3, 6, 9, 12, 13
# Columns of turns: quaternion, angular momentum, moment from within, inverse of the inertia at the start, whether it
# turns
Q, SPIN, MOMENT, INVERSE, FREE = 0, 4, 7, 10, 19
# Columns of elements: axes at the start, length, stiffnesses E A, G J, E I, yield moment, hardening, 1 / breaking
# moment and force; then plastic rotations of both ends, axial force, torsion, moments of both ends about both axes
# across, stress of each end over strength, the largest moment so far; whether each end passes on a moment
AXES, REST, AXIAL, TWIST, BEND, YIELD, HARDENING, BREAKING, PULLING = 0, 9, 10, 11, 12, 13, 14, 15, 16
PLASTIC, NORMAL, TORSION, BENT, STRESS, LARGEST, WHOLE = 17, 21, 22, 23, 27, 29, 30
# Numbers of all of it, then what the steps add to: impulse of feet, damping and ground, work of yielding, substeps;
# the largest stress over strength
SUBSTEP, DRAG, GIVEN, WORK, DONE, WORST = 0, 1, 2, 5, 6, 7


@functools.cache
def framework_kernel():
    """Kernel move(places (p, 14), turns (t, 20), elements (n, 32), links (n, 4), numbers (8,), ground (4,), count):
    `count` substeps, or as many as it takes until an end has to break; ground as in `rod_motion.rod_kernel`."""

    @ti.func
    def add(table: ti.template(), row, column: ti.template(), value):
        for a in ti.static(range(3)):
            table[row, column + a] = table[row, column + a] + value[a]

    @ti.func
    def carried(turns: ti.template(), row, v, sign):
        """R v, or R^T v for sign = -1."""
        u = vector(turns, row, Q + 1)
        t = 2.0 * u.cross(v)
        return v + sign * turns[row, Q] * t + u.cross(t)

    @ti.func
    def product(turns: ti.template(), row, column: ti.template(), v):
        """A v of a matrix of its row."""
        return ti.Vector([turns[row, column + 3 * i] * v[0] + turns[row, column + 3 * i + 1] * v[1]
                          + turns[row, column + 3 * i + 2] * v[2] for i in ti.static(range(3))])

    @ti.func
    def rotation_vector(A: ti.template()):
        """theta of the rotation with columns A."""
        w = 0.5 * ti.Vector([A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]])
        sine = w.norm()
        return w * ti.select(sine > 1e-12, ti.atan2(sine, 0.5 * (A.trace() - 1.0)) / ti.max(sine, 1e-300), 1.0)

    @ti.func
    def conjugate(theta: ti.template(), m: ti.template()):
        """Moment that does the work of m on d theta: J_l^-T m."""
        t = theta.norm()
        c = 1.0 / 12.0
        if t > SMALL:
            c = (1.0 - 0.5 * t / ti.tan(0.5 * t)) / (t * t)
        once = theta.cross(m)
        return m + 0.5 * once + c * theta.cross(once)

    @ti.func
    def deform(places: ti.template(), turns: ti.template(), elements: ti.template(), links: ti.template(),
               numbers: ti.template()):
        """Forces on places and moments on turns where they are now."""
        for i in range(places.shape[0]):
            put(places, i, INNER, ti.Vector.zero(ti.f64, 3))
        for i in range(turns.shape[0]):
            put(turns, i, MOMENT, ti.Vector.zero(ti.f64, 3))
        for e in range(elements.shape[0]):
            a, b, s, t = links[e, 0], links[e, 1], links[e, 2], links[e, 3]
            edge = vector(places, b, X) - vector(places, a, X)
            length = edge.norm()
            r1 = edge / length
            across = vector(elements, e, AXES + 3)
            q = 0.5 * (carried(turns, s, across, 1.0) + carried(turns, t, across, 1.0))
            r3 = r1.cross(q).normalized()
            frame = ti.Matrix.rows([r1, r3.cross(r1), r3])
            axes = ti.Matrix.cols([vector(elements, e, AXES + 3 * k) for k in ti.static(range(3))])
            theta, second, moments = ti.Matrix.zero(ti.f64, 2, 3), ti.Matrix.zero(ti.f64, 2, 2), ti.Matrix.zero(
                ti.f64, 2, 3)
            for end in range(2):
                A = ti.Matrix.zero(ti.f64, 3, 3)
                for k in range(3):
                    column = frame @ carried(turns, links[e, 2 + end],
                                             ti.Vector([axes[0, k], axes[1, k], axes[2, k]]), 1.0)
                    for i in ti.static(range(3)):
                        A[i, k] = column[i]
                found = rotation_vector(A)
                for i in ti.static(range(3)):
                    theta[end, i] = found[i]
                second[end, 0], second[end, 1] = A[0, 1], A[1, 1]
            k = elements[e, BEND] / elements[e, REST]
            plastic = ti.Matrix([[elements[e, PLASTIC + 2 * end + i] for i in ti.static(range(2))]
                                 for end in ti.static(range(2))])
            bent = k * ti.Matrix([[4.0, 2.0], [2.0, 4.0]]) @ (
                ti.Matrix([[theta[end, 1], theta[end, 2]] for end in ti.static(range(2))]) - plastic)
            # What is beyond the yield surface of both ends, along their moments; one slips, or both
            size = ti.Vector([ti.Vector([bent[end, 0], bent[end, 1]]).norm() for end in ti.static(range(2))])
            over = ti.Vector([elements[e, WHOLE + end] * (size[end] - elements[e, YIELD] - elements[e, HARDENING] * 4.0
                              * k * ti.Vector([plastic[end, 0], plastic[end, 1]]).norm())
                              for end in ti.static(range(2))])
            if over[0] > 0.0 or over[1] > 0.0:
                own = 4.0 * k * (1.0 + elements[e, HARDENING])
                other = 2.0 * k * (bent[0, 0] * bent[1, 0] + bent[0, 1] * bent[1, 1]) / ti.max(size[0] * size[1],
                                                                                              1e-300)
                slip = ti.Vector([own * over[0] - other * over[1], own * over[1] - other * over[0]]) / (
                    own * own - other * other)
                if slip[0] < 0.0 or slip[1] < 0.0 or over[0] < 0.0 or over[1] < 0.0:
                    slip = ti.max(over, 0.0) / own
                    if over[0] > 0.0 and over[1] > 0.0:
                        # Only the one that is further beyond: it takes the other one back
                        slip = ti.select(over[0] > over[1], ti.Vector([slip[0], 0.0]), ti.Vector([0.0, slip[1]]))
                for end in range(2):
                    for i in ti.static(range(2)):
                        plastic[end, i] += slip[end] * bent[end, i] / ti.max(size[end], 1e-300)
                        elements[e, PLASTIC + 2 * end + i] = plastic[end, i]
                bent = k * ti.Matrix([[4.0, 2.0], [2.0, 4.0]]) @ (
                    ti.Matrix([[theta[end, 1], theta[end, 2]] for end in ti.static(range(2))]) - plastic)
                for end in ti.static(range(2)):
                    numbers[WORK] = numbers[WORK] + slip[end] * ti.Vector([bent[end, 0], bent[end, 1]]).norm()
            pull = elements[e, AXIAL] * (length / elements[e, REST] - 1.0)
            twist = elements[e, TWIST] / elements[e, REST] * (theta[1, 0] - theta[0, 0])
            elements[e, NORMAL], elements[e, TORSION] = pull, twist
            sides = ti.Vector([-1.0, 1.0])
            for end in range(2):
                moment = conjugate(ti.Vector([theta[end, 0], theta[end, 1], theta[end, 2]]),
                                   ti.Vector([sides[end] * twist, bent[end, 0], bent[end, 1]]))
                for i in ti.static(range(3)):
                    moments[end, i] = moment[i]
                now = elements[e, WHOLE + end] * ti.Vector([bent[end, 0], bent[end, 1]]).norm()
                elements[e, BENT + 2 * end], elements[e, BENT + 2 * end + 1] = bent[end, 0], bent[end, 1]
                stress = now * elements[e, BREAKING] + elements[e, WHOLE + end] * ti.abs(pull) * elements[e, PULLING]
                elements[e, STRESS + end], numbers[WORST] = stress, ti.max(numbers[WORST], stress)
                elements[e, LARGEST] = ti.max(elements[e, LARGEST], now)
            # By the derivatives of axis and mean of the second axes
            q1, q2 = 0.5 * (second[0, 0] + second[1, 0]), 0.5 * (second[0, 1] + second[1, 1])
            m = ti.Vector([moments[0, i] + moments[1, i] for i in ti.static(range(3))])
            rolled = m[0] / q2
            force = frame.transpose() @ ti.Vector([pull, -m[2] / length, (m[1] + rolled * q1) / length])
            add(places, a, INNER, force)
            add(places, b, INNER, -force)
            for end in range(2):
                own = ti.Vector([moments[end, 0] - 0.5 * rolled * second[end, 1],
                                 moments[end, 1] + 0.5 * rolled * second[end, 0], moments[end, 2]])
                add(turns, links[e, 2 + end], MOMENT, -(frame.transpose() @ own))

    @taichi_kernel
    def move(places: ti.types.ndarray(), turns: ti.types.ndarray(), elements: ti.types.ndarray(),
             links: ti.types.ndarray(), numbers: ti.types.ndarray(), ground: ti.types.ndarray(), count: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            h, drag = numbers[SUBSTEP], numbers[DRAG]
            normal = ti.Vector([ground[a] for a in ti.static(range(3))])
            numbers[DONE], numbers[WORST] = 0.0, 0.0
            for substep in range(count + 1):
                if numbers[WORST] < 1.0:
                    deform(places, turns, elements, links, numbers)
                if substep < count and numbers[WORST] < 1.0:
                    numbers[DONE] = numbers[DONE] + 1.0
                    given = ti.Vector.zero(ti.f64, 3)
                    for i in range(places.shape[0]):
                        v, mass = vector(places, i, V), places[i, MASS]
                        acting = vector(places, i, F) + vector(places, i, INNER)
                        if places[i, HELD] > 0.0:
                            given += acting
                        else:
                            slowed = drag * mass * v
                            given += slowed
                            v += h * (acting - slowed) / mass
                            x = vector(places, i, X) + h * v
                            deep = ground[3] - normal.dot(x)
                            if deep > 0.0:
                                x += deep * normal
                                sinking = ti.min(normal.dot(v), 0.0) * normal
                                v -= sinking
                                given += mass / h * sinking
                            put(places, i, V, v)
                            put(places, i, X, x)
                    for a in ti.static(range(3)):
                        numbers[GIVEN + a] = numbers[GIVEN + a] - h * given[a]
                    for i in range(turns.shape[0]):
                        if turns[i, FREE] > 0.0:
                            spin = (1.0 - h * drag) * vector(turns, i, SPIN) + h * vector(turns, i, MOMENT)
                            put(turns, i, SPIN, spin)
                            omega = carried(turns, i, product(turns, i, INVERSE, carried(turns, i, spin, -1.0)), 1.0)
                            half = 0.5 * h * omega.norm()
                            share = 0.5 * h * ti.select(half > SMALL, ti.sin(half) / ti.max(half, 1e-300),
                                                        1.0 - half * half / 6.0)
                            c, u, w = ti.cos(half), share * omega, vector(turns, i, Q + 1)
                            whole = turns[i, Q]
                            real, rest = c * whole - u.dot(w), c * w + whole * u + u.cross(w)
                            size = ti.sqrt(real * real + rest.dot(rest))
                            turns[i, Q] = real / size
                            put(turns, i, Q + 1, rest / size)

    return move
