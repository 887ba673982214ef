"""Motion of a chain of segments in substeps, compiled (`rod` has the equations)."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel

STRAIGHT = 1e-12
"""Sine of the turn of a hinge below which its angle is taken for it."""

NEVER = 1e300
"""Moment that no hinge reaches."""

# Columns of nodes: place, velocity, force from without, force from within, mass
X, V, F, INNER, MASS = 0, 3, 6, 9, 12
# Columns of hinges: plastic rotation, moment, direction below, own direction, own length, stiffness, broken
PLASTIC, MOMENT, BELOW, OWN, LENGTH, STIFF, BROKEN = 0, 3, 6, 9, 12, 13, 14
# Numbers of the rod, then what the steps add to
SUBSTEP, DRAG, AXIAL, REST, YIELD, HARDENING, BREAKING, CLAMP, HELD, WORK, LARGEST = 0, 1, 2, 3, 4, 5, 6, 7, 10, 13, 14


@ti.func
def vector(table: ti.template(), row, column: ti.template()):
    """Three numbers of a row from a column on."""
    return ti.Vector([table[row, column + a] for a in ti.static(range(3))])


@ti.func
def put(table: ti.template(), row, column: ti.template(), value):
    """Write them."""
    for a in ti.static(range(3)):
        table[row, column + a] = value[a]


@functools.cache
def rod_kernel():
    """Kernel move(nodes (n + 1, 13), hinges (n, 15), numbers (15,), ground (4,), count): `count` substeps of velocity
    Verlet. ground: normal of a plane, and its level along it [m], below which no node but the clamped one goes: what
    would is put back on it, and keeps its velocity along it."""

    @ti.func
    def deform(nodes: ti.template(), hinges: ti.template(), numbers: ti.template(), n):
        """Moments of the hinges and forces on the nodes where they are now."""
        below = ti.Vector([numbers[CLAMP + a] for a in ti.static(range(3))])
        for s in range(n):
            edge = vector(nodes, s + 1, X) - vector(nodes, s, X)
            length = edge.norm()
            d = edge / length
            # Plastic rotations turn with the segments below their hinges
            plastic = vector(hinges, s, PLASTIC)
            plastic += vector(hinges, s, BELOW).cross(below).cross(plastic)
            axis = below.cross(d)
            sine = axis.norm()
            turn = axis * ti.select(sine > STRAIGHT, ti.atan2(sine, below.dot(d)) / ti.max(sine, 1e-300), 1.0)
            k = hinges[s, STIFF]
            moment = k * (turn - plastic)
            if hinges[s, BROKEN] > 0.0:
                moment *= 0.0
            else:
                size = moment.norm()
                # Linear hardening with the plastic rotation so far
                over = size - numbers[YIELD] - numbers[HARDENING] * k * plastic.norm()
                if over > 0.0:
                    slip = over / (k * (1.0 + numbers[HARDENING]))
                    plastic += moment / size * slip
                    moment = k * (turn - plastic)
                    size = moment.norm()
                    numbers[WORK] = numbers[WORK] + size * slip
                if size >= numbers[BREAKING]:
                    hinges[s, BROKEN] = 1.0
                    moment *= 0.0
            put(hinges, s, PLASTIC, plastic)
            put(hinges, s, MOMENT, moment)
            put(hinges, s, BELOW, below)
            put(hinges, s, OWN, d)
            hinges[s, LENGTH] = length
            below = d
        inner = ti.Vector.zero(ti.f64, 3)
        for s in range(n):
            d, length = vector(hinges, s, OWN), hinges[s, LENGTH]
            torque = -vector(hinges, s, MOMENT)
            if s < n - 1:
                torque += vector(hinges, s + 1, MOMENT)
            pull = numbers[AXIAL] * (length / numbers[REST] - 1.0) * d - torque.cross(d) / length
            put(nodes, s, INNER, inner + pull)
            inner = -pull
        put(nodes, n, INNER, inner)

    @taichi_kernel
    def move(nodes: ti.types.ndarray(), hinges: ti.types.ndarray(), numbers: ti.types.ndarray(),
             ground: ti.types.ndarray(), count: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            n, h = hinges.shape[0], numbers[SUBSTEP]
            deform(nodes, hinges, numbers, n)
            for _substep in range(count):
                # The clamp takes what acts on the lowest node; damping and the ground take momentum too
                held = vector(nodes, 0, F) + vector(nodes, 0, INNER)
                for i in range(n + 1):
                    v, mass = vector(nodes, i, V), nodes[i, MASS]
                    slowed = numbers[DRAG] * mass * v
                    held += slowed
                    if i > 0:
                        v += h * (vector(nodes, i, F) + vector(nodes, i, INNER) - slowed) / mass
                        x = vector(nodes, i, X) + h * v
                        normal = ti.Vector([ground[a] for a in ti.static(range(3))])
                        deep = ground[3] - normal.dot(x)
                        if deep > 0.0:
                            x += deep * normal
                            sinking = ti.min(normal.dot(v), 0.0) * normal
                            v -= sinking
                            held += mass / h * sinking
                        put(nodes, i, V, v)
                        put(nodes, i, X, x)
                for a in ti.static(range(3)):
                    numbers[HELD + a] = numbers[HELD + a] - h * held[a]
                deform(nodes, hinges, numbers, n)
                numbers[LARGEST] = ti.max(numbers[LARGEST], vector(hinges, 0, MOMENT).norm())

    return move
