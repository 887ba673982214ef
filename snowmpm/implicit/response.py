"""Stress of particles for a step's deformation, and its consistent tangent, of every law alike.

A step deforms a particle by f = I + A, A = sum_I u_I (x) g_I. Its law gives the Kirchhoff stress tau; the force on node
I is V P g_I with

    P = tau f^-T,      C_ijkl = dP_ij / dA_kl

(V: reference volume). C holds the material and the geometric part of the tangent at once. It is the derivative of the
law's own return map by central differences of its result, one pair of calls for each entry of A, so it is consistent
with what the law does in a finite step, whatever the law. With steps of 1e-4 of the strain that the law sees, the error
is about 1e-8 of C; it falls with the square of the step, while round-off of float64 adds 1e-12. A tangent coded by hand
for each law would be exact to round-off, take fewer calls, and would have to be written and kept right for each.
"""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.materials.symmetric import PAIRS
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import Layout

RELATIVE_STEP = 1e-4
"""Step of the differences over the strain that the law sees."""

LEAST_STRAIN, MOST_STRAIN = 1e-6, 0.1
"""Limits of that strain."""


class Before(NamedTuple):
    """What particles bring to a step: h (n, 4 or 6), state (n, k), J (n,), material (n,)."""

    h: Array
    state: Array
    ratio: Array
    material: Array


class Laws(NamedTuple):
    """`MaterialTable.numbers` and `law_of`."""

    numbers: Array
    law_of: Array


class After(NamedTuple):
    """What a step makes of them: h, state, J, tau (n, 4 or 6), plastic work [J/m3] (n,), iterations of the law (n,), -1
    where it failed, P (n, dim, dim), det f (n,), C (n, dim, dim, dim, dim)."""

    h: Array
    state: Array
    ratio: Array
    tau: Array
    work: Array
    iterations: Array
    P: Array
    growth: Array
    C: Array

    @classmethod
    def room(cls, before, dim, tangents):
        """Arrays for the particles of a `Before`."""
        n = len(before.ratio)
        C = np.zeros((n if tangents else 1, dim, dim, dim, dim))
        return cls(np.zeros_like(before.h), np.zeros_like(before.state), np.zeros(n), np.zeros_like(before.h),
                   np.zeros(n), np.zeros(n, np.int32), np.zeros((n, dim, dim)), np.zeros(n), C)


def respond(materials, before, A, dt, tangents):
    """`After` of particles that deform by A (n, dim, dim) in dt [s]; materials: a `MaterialTable` of float64.

    tangents: C too.
    """
    dim = A.shape[1]
    after = After.room(before, dim, tangents)
    if len(A):
        with runtime.precision("f64"):
            kernel = response_kernel(dim, before.state.shape[1], materials.functions)
            kernel(np.ascontiguousarray(A), before, Laws(materials.numbers, materials.law_of), after, int(tangents), dt)
    return after


@functools.cache
def response_kernel(dim, state_size, laws):
    """laws: `LawFunctions` of the scene."""
    n_laws, updates, n_sym = len(laws), [law.update for law in laws], 4 if dim == 2 else 6
    parameters_of = response_functions(Layout(dim, state_size, by_row=True), ti.f64, laws).parameters_of
    pairs, entries = PAIRS[:n_sym], dim * dim

    @ti.func
    def in_space(tau):
        """The dim x dim part of a symmetric tensor."""
        T = ti.Matrix.zero(ti.f64, dim, dim)
        for k in ti.static(range(n_sym)):
            i, j = ti.static(pairs[k])
            if ti.static(i < dim and j < dim):
                T[i, j] = tau[k]
                T[j, i] = tau[k]
        return T

    @grouped_kernel(ti.f64, plain=True)
    def find(A: Array, before: Before, laws: Laws, after: After, tangents: int, dt: Real):
        for p in range(A.shape[0]):
            own = ti.cast(before.material[p], ti.i32)
            h, state = ti.Vector.zero(ti.f64, n_sym), ti.Vector.zero(ti.f64, state_size)
            for k in ti.static(range(n_sym)):
                h[k] = before.h[p, k]
            for k in ti.static(range(state_size)):
                state[k] = before.state[p, k]
            own_A = ti.Matrix.zero(ti.f64, dim, dim)
            for i, j in ti.static(ti.ndrange(dim, dim)):
                own_A[i, j] = A[p, i, j]
            seen = 0.5 * h.norm() + own_A.norm()
            step = RELATIVE_STEP * ti.min(ti.max(seen, LEAST_STRAIN), MOST_STRAIN)
            for call in range(1 + tangents * 2 * entries):
                moved, entry = own_A, (call - 1) // 2
                sign = ti.cast(1 - 2 * ((call - 1) % 2), ti.f64)
                if call > 0:
                    for i, j in ti.static(ti.ndrange(dim, dim)):
                        if entry == i * dim + j:
                            moved[i, j] += sign * step
                h_new, tau, state_new, work, iterations = h, h, state, 0.0, 0
                for k in ti.static(range(n_laws)):
                    if laws.law_of[own] == k:
                        h_new, tau, state_new, work, iterations = updates[k](
                            parameters_of(k, laws.numbers, own), h, state, moved, dt)
                f = moved + ti.Matrix.identity(ti.f64, dim)
                growth = f.determinant()
                P = ti.Matrix.zero(ti.f64, dim, dim)
                if growth > 0.0:
                    P = in_space(tau) @ f.inverse().transpose()
                if call == 0:
                    for k in ti.static(range(n_sym)):
                        after.h[p, k], after.tau[p, k] = h_new[k], tau[k]
                    for k in ti.static(range(state_size)):
                        after.state[p, k] = state_new[k]
                    after.ratio[p], after.growth[p] = before.ratio[p] * growth, growth
                    after.work[p], after.iterations[p] = work, iterations
                    for i, j in ti.static(ti.ndrange(dim, dim)):
                        after.P[p, i, j] = P[i, j]
                else:
                    for i, j in ti.static(ti.ndrange(dim, dim)):
                        before_it = after.C[p, i, j, entry // dim, entry % dim]  # += would be atomic
                        after.C[p, i, j, entry // dim, entry % dim] = before_it + 0.5 * sign / step * P[i, j]

    return find
