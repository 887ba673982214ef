"""Stress updates of a pack of particles, a vector register of them at a time.

The loop vectoriser of the compiler takes a loop over arrays that are local to a function and whose body is a straight
line. So a kernel fills local arrays, one number for each of LANES particles, `update_pack` applies a law's `lanes` to
them, `update_lane` does again what that could not, and the kernel stores what came out:

    h, tau: `size` arrays each; state: one for each variable; A: dim² arrays, by rows; work; iterations (integers)

Every one is a ti.Vector of LANES entries (`[ti.Vector.zero(real, LANES) for _ in ti.static(range(n))]`); results take
the place of h and state.
"""

import taichi as ti

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
def update_pack(lanes: ti.template(), prm, dt, h: ti.template(), state: ti.template(), A: ti.template(),
                tau: ti.template(), work: ti.template(), iterations: ti.template()):  # fmt: skip
    """`lanes`, a law's straight-line update, for all lanes, which share their parameters.

    Lanes where iterations[lane] is REDO keep h and state: `update_lane` must follow. Lanes that hold no particle may
    hold anything.
    """
    for lane in range(LANES):
        h_old, state_old = read_lane(h, lane), read_lane(state, lane)
        h_new, stress, state_new, dissipation, count = lanes(prm, h_old, state_old, read_matrix_lane(A, lane), dt)
        redo = count == REDO
        write_lane(h, lane, ti.select(redo, h_old, h_new))
        write_lane(tau, lane, stress)
        write_lane(state, lane, ti.select(redo, state_old, state_new))
        work[lane] = dissipation
        iterations[lane] = count


@ti.func
def update_lane(update: ti.template(), lane, prm, dt, h: ti.template(), state: ti.template(), A: ti.template(),
                tau: ti.template(), work: ti.template(), iterations: ti.template()):  # fmt: skip
    """`update`, a law's update of one particle, for one lane."""
    h_new, stress, state_new, dissipation, count = update(
        prm, read_lane(h, lane), read_lane(state, lane), read_matrix_lane(A, lane), dt
    )
    write_lane(h, lane, h_new)
    write_lane(tau, lane, stress)
    write_lane(state, lane, state_new)
    work[lane] = dissipation
    iterations[lane] = count
