"""Stress updates of a pack of particles, a vector register of them at a time.

The loop vectoriser of the compiler takes a loop over arrays that are local to a function and whose body is a straight
line. So a kernel fills local arrays, one number for each of LANES particles. `update_pack` applies a law's
`vector_update` to them, `update_lane` does again what that could not, and the kernel stores what came out:

    h, tau: `size` arrays each; state: one for each variable; A: dim² arrays, by rows; work; iterations (integers)

    held: what a `StagedUpdate` keeps of a lane

Every one is a ti.Vector of LANES entries (`[ti.Vector.zero(real, LANES) for _ in ti.static(range(n))]`); results take
the place of h and state.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from snowmpm.compiler import ti

from .law import REDO

LANES = 16
"""Particles in a pack: a whole number of vector registers in float32 as in float64."""


@ti.func
def read_lane(arrays: ti.template(), lane):
    """The numbers of one lane as a vector."""
    return ti.Vector([arrays[k][lane] for k in ti.static(range(len(arrays)))])


@ti.func
def read_matrix_lane(arrays: ti.template(), lane):
    """The dim² numbers of one lane as a matrix."""
    dim = ti.static(2 if len(arrays) == 4 else 3)
    return ti.Matrix(
        [[arrays[dim * i + j][lane] for j in ti.static(range(dim))] for i in ti.static(range(dim))]
    )


@ti.func
def write_lane(arrays: ti.template(), lane, vector):
    """Set the numbers of one lane."""
    for k in ti.static(range(len(arrays))):
        arrays[k][lane] = vector[k]


@ti.func
def write_matrix_lane(arrays: ti.template(), lane, matrix):
    """Set the dim² numbers of one lane."""
    for i in ti.static(range(matrix.n)):
        for j in ti.static(range(matrix.n)):
            arrays[matrix.n * i + j][lane] = matrix[i, j]


@ti.func
def joined(a, b):
    """The numbers of two vectors in one."""
    return ti.Vector([a[k] for k in ti.static(range(a.n))] + [b[k] for k in ti.static(range(b.n))])


@ti.func
def part(a, first: ti.template(), n: ti.template()):
    """n numbers of a vector from the first on."""
    return ti.Vector([a[k] for k in ti.static(range(first, first + n))])


class StagedUpdate(NamedTuple):
    """A straight-line update in parts, each a loop over the lanes of a pack, for which some numbers of a lane are held.

        begin(prm, h, state, A, dt)       -> what is held from number `first` on, as a vector
        step                              one after the other, as long as number `going` of a lane is not 0: pairs of
                                          (prm, state, held) -> vector, and the number from which on it is held
        end(prm, state, held, yields)     -> h, τ, state, dissipation, iterations, as `Law.update`

    A pack in which nobody is going is spared the steps, and one where number `changed` is 0 in every lane a return map:
    `end` is then made for yields = False. And short loops may be faster than a long one, since a processor works on as
    many lanes at once as their instructions fit into its window. A step must leave alone what needs no more of it: then
    no lane hangs on the others. Held are two tensors besides `numbers`.
    """

    begin: Callable[..., Any]
    first: int
    step: tuple[tuple[Callable[..., Any], int], ...]
    end: Callable[..., Any]
    going: int
    changed: int
    numbers: int


MOST_STEPS = 5
"""Steps of a stage for all lanes, after which those that want more are left to a law's `update`."""


def held_numbers(vector_update, entries):
    """Numbers a lane that `update_pack` wants to hold for a law's `vector_update`. entries: of a symmetric tensor."""
    return vector_update.numbers + 2 * entries if isinstance(vector_update, StagedUpdate) else 0


@ti.func
def update_pack(vector_update: ti.template(), prm: ti.template(), dt, pack: ti.template()):
    """`vector_update`, a law's straight-line update, for all lanes, which share their parameters.

    pack: by name, arrays of a number a lane: h, state, A, read; h, tau, state, written; "held", `held_numbers` of them
    or more, for the law itself; "work" and "iterations", a vector each, written. Lanes where iterations[lane] is REDO
    keep h and state: `update_lane` must follow. Lanes that hold no particle may hold anything.
    """
    h, state, A, held = ti.static(pack["h"], pack["state"], pack["A"], pack["held"])
    if ti.static(isinstance(vector_update, StagedUpdate)):
        for lane in range(LANES):
            numbers = vector_update.begin(prm, read_lane(h, lane), read_lane(state, lane), read_matrix_lane(A, lane),
                                          dt)
            n, rest = ti.static(vector_update.numbers - vector_update.first,
                                numbers.n - (vector_update.numbers - vector_update.first))
            write_lane(held[vector_update.first : vector_update.numbers], lane, part(numbers, 0, n))
            write_lane(held[vector_update.numbers : vector_update.numbers + rest], lane, part(numbers, n, rest))
        going, changed, steps = _sum(held[vector_update.going]), _sum(held[vector_update.changed]), 0
        while going > 0.0 and steps < MOST_STEPS:
            for function, place in ti.static(vector_update.step):
                for lane in range(LANES):
                    numbers = function(prm, read_lane(state, lane), _held_of(vector_update, held, h, lane))
                    write_lane(held[place : place + numbers.n], lane, numbers)
            going = _sum(held[vector_update.going])
            steps += 1
        if changed > 0.0:
            for lane in range(LANES):
                h_new, stress, state_new, dissipation, count = vector_update.end(
                    prm, read_lane(state, lane), _held_of(vector_update, held, h, lane), True
                )
                _write_result(pack, lane, h_new, stress, state_new, dissipation, count)
        else:
            for lane in range(LANES):
                h_new, stress, state_new, dissipation, count = vector_update.end(
                    prm, read_lane(state, lane), _held_of(vector_update, held, h, lane), False
                )
                _write_result(pack, lane, h_new, stress, state_new, dissipation, count)
    else:
        for lane in range(LANES):
            h_new, stress, state_new, dissipation, count = vector_update(
                prm, read_lane(h, lane), read_lane(state, lane), read_matrix_lane(A, lane), dt
            )
            _write_result(pack, lane, h_new, stress, state_new, dissipation, count)


@ti.func
def _sum(array: ti.template()):
    """By halves, which do not wait for each other."""
    sums = ti.Vector([array[k] + array[k + LANES // 2] for k in ti.static(range(LANES // 2))])
    for n in ti.static([LANES >> k for k in range(2, LANES.bit_length())]):
        for k in ti.static(range(n)):
            sums[k] += sums[k + n]
    return sums[0]


@ti.func
def _held_of(vector_update: ti.template(), held: ti.template(), h: ti.template(), lane):
    return ti.Vector([held[k][lane] for k in ti.static(range(held_numbers(vector_update, len(h))))])


@ti.func
def _write_result(pack: ti.template(), lane, h_new, stress, state_new, dissipation, count):
    redo = count == REDO
    write_lane(pack["h"], lane, ti.select(redo, read_lane(pack["h"], lane), h_new))
    write_lane(pack["tau"], lane, stress)
    write_lane(pack["state"], lane, ti.select(redo, read_lane(pack["state"], lane), state_new))
    pack["work"][lane] = dissipation
    pack["iterations"][lane] = count


@ti.func
def update_lane(update: ti.template(), lane, prm: ti.template(), dt, pack: ti.template()):
    """`update`, a law's update of one particle, for one lane of a pack as `update_pack` takes it."""
    h_new, stress, state_new, dissipation, count = update(
        prm, read_lane(pack["h"], lane), read_lane(pack["state"], lane), read_matrix_lane(pack["A"], lane), dt
    )
    write_lane(pack["h"], lane, h_new)
    write_lane(pack["tau"], lane, stress)
    write_lane(pack["state"], lane, state_new)
    pack["work"][lane] = dissipation
    pack["iterations"][lane] = count
