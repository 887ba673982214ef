"""The jumps of one or two cracks in elastic material: each follows its own law, and unloads the other."""

import functools

from snowmpm.compiler import ti

from .crack_planes import DAMAGE, OPENING, PER_CRACK, elastic_stress, jump_strain, traction
from .crack_return import crack_return
from .precision import by_precision

SWEEPS = 100
"""Over two cracks. Where they unload each other by ν/(1 − ν) of a stress, ten are usual."""


@ti.func
def row(matrix, c: ti.template()):
    """Row c of a matrix of three columns as a vector."""
    return ti.Vector([matrix[c, 0], matrix[c, 1], matrix[c, 2]])


@functools.cache
def crack_solver(most):
    """Taichi function that finds the jumps of `most` cracks, 1 or 2.

        solve(prm, free, state, planes, begun, weaker) -> jumps, numbers, work, moved

    free: the stress without any jump of the step [Pa]; planes (most, 3): unit normals of the first `begun` cracks, with
    what they are at the start of the step in `state`; weaker: the crack to begin with. jumps (most, 3): u/H; numbers
    (most, 2): damage, opening; work [J/m3]; moved: 0 where all cracks hold, −1 where no solution was found.
    """

    @ti.func
    def solve(prm: ti.template(), free, state, planes, begun, weaker):
        jumps, numbers = ti.Matrix.zero(float, most, 3), ti.Matrix.zero(float, most, 2)
        works, counts = ti.Vector.zero(float, most), ti.Vector.zero(int, most)
        tiny = ti.static(by_precision(1e-30, 1e-200))
        M = prm.K + ti.static(4.0 / 3.0) * prm.shear_modulus
        near = ti.static(by_precision(1e-6, 1e-14)) * (ti.sqrt(free.norm_sqr()) + prm.strength)
        sweep, going = 0, 1
        while going == 1 and sweep < ti.static(SWEEPS if most > 1 else 1):
            sweep += 1
            going = 0
            for turn in range(begun):
                # One place for the return, which is long: the crack whose turn it is takes its numbers from the rows
                own = weaker if turn == 0 else 1 - weaker
                n, omega, opened, tau = ti.Vector.zero(float, 3), 0.0, 0.0, free
                for c in ti.static(range(most)):
                    plane = row(planes, c)
                    if own == c:
                        n = plane
                        omega = state[ti.static(c * PER_CRACK + DAMAGE)]
                        opened = state[ti.static(c * PER_CRACK + OPENING)]
                    else:
                        tau -= elastic_stress(prm, jump_strain(free, plane, row(jumps, c)))
                t = traction(tau, n)
                t_n = t.dot(n)
                along = t - t_n * n
                t_s = along.norm()
                along /= ti.max(t_s, tiny)
                n_new, s_new, omega, opened, work, count = crack_return(prm, t_n, t_s, omega, opened)
                jump = (t_n - n_new) / M * n + (t_s - s_new) / prm.shear_modulus * along
                for c in ti.static(range(most)):
                    if own == c:
                        if M * (jump - row(jumps, c)).norm() > near:
                            going = 1
                        for i in ti.static(range(3)):
                            jumps[c, i] = jump[i]
                        numbers[c, 0], numbers[c, 1] = omega, opened
                        works[c], counts[c] = work, count
        moved, total = 0, 0.0
        for c in ti.static(range(most)):
            if c < begun:
                total += works[c]
                if counts[c] != 0:
                    moved = ti.select(moved == -1 or counts[c] < 0, -1, 1)
        if ti.static(most > 1):  # noqa: SIM102 (one is compile time)
            if begun > 1 and going == 1:
                moved = -1
        return jumps, numbers, total, moved

    return solve
