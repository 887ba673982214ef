"""Impulses of contact with dry friction, for all points at once.

With p the impulses at the points (normal first, then tangential), u* the relative velocities without them and W the
response of the bodies, u = u* + W p:

    p_n >= 0,   u_n >= b,   p_n (u_n - b) = 0                    no tension, no penetration
    |p_t| <= mu p_n,   p_t opposite to u_t where that slides     Coulomb

b: what a gap allows (-gap / dt), or what restitution asks for (-e u_n before). Solved point by point until nothing
changes (projected Gauss-Seidel: J. J. Moreau (1988), doi:10.1007/978-3-7091-2624-0_1; M. Jean (1999),
doi:10.1016/S0045-7825(98)00383-1). There is no stiffness, and no step limit of it.
"""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel

TOLERANCE = 1e-11
"""Largest change of an impulse in a sweep, over the largest impulse, at which it ends."""

SWEEPS = 2000
"""Sweeps, at most."""


def impulses(response, velocity, bias, friction, start):
    """Impulses (k, dim) [N s] along the normal and the tangents of each point, and whether the sweeps came to an end
    before they were cut off at `SWEEPS`.

    response W (k dim, k dim) [1/kg]; velocity u* (k, dim) [m/s]; bias b (k,) [m/s]; friction mu (k,) [-]; start (k,
    dim): of the step before, from which the sweeps begin.
    """
    runtime.start()
    found, settled = np.array(start, float), np.zeros(1, np.int32)
    with runtime.precision("f64"):
        _relax(found.shape[1])(found, np.ascontiguousarray(response), np.ascontiguousarray(velocity),
                               np.ascontiguousarray(bias, float), np.ascontiguousarray(friction, float), settled,
                               len(found))
    return found, bool(settled[0])


@functools.cache
def _relax(dim):
    @taichi_kernel
    def relax(p: ti.types.ndarray(), response: ti.types.ndarray(), velocity: ti.types.ndarray(),
              bias: ti.types.ndarray(), friction: ti.types.ndarray(), settled: ti.types.ndarray(), n: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            change, size, sweep = ti.cast(1.0, ti.f64), ti.cast(0.0, ti.f64), 0
            while change > TOLERANCE * size and sweep < SWEEPS:
                change, size, sweep = change * 0.0, size * 0.0, sweep + 1
                for turn in range(n):
                    k = turn
                    if sweep % 2 == 0:  # backwards too: down a stack as well as up
                        k = n - 1 - turn
                    u, before = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
                    for a in ti.static(range(dim)):
                        u[a], before[a] = velocity[k, a], p[k, a]
                    for j in range(n):
                        for a in ti.static(range(dim)):
                            for c in ti.static(range(dim)):
                                u[a] += response[k * dim + a, j * dim + c] * p[j, c]
                    normal = ti.max(0.0, before[0] - (u[0] - bias[k]) / response[k * dim, k * dim])
                    # The tangential answer is to the normal impulse of now
                    softest, slip = u[0] * 0.0, u[0] * 0.0
                    along = ti.Vector.zero(ti.f64, dim)
                    for a in ti.static(range(1, dim)):
                        u[a] += response[k * dim + a, k * dim] * (normal - before[0])
                        softest = ti.max(softest, response[k * dim + a, k * dim + a])
                    for a in ti.static(range(1, dim)):
                        along[a] = before[a] - u[a] / softest
                        slip += along[a] ** 2
                    slip = ti.sqrt(slip)
                    kept = ti.min(1.0, friction[k] * normal / ti.max(slip, 1e-300))
                    along *= kept
                    along[0] = normal
                    for a in ti.static(range(dim)):
                        change = ti.max(change, ti.abs(along[a] - before[a]))
                        size = ti.max(size, ti.abs(along[a]))
                        p[k, a] = along[a]
            if change <= TOLERANCE * size:  # not a number is neither
                settled[0] = 1

    return relax
