"""Particles that are held where they are, and what that takes from them."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors

HELD = 1.5
"""Mark above which a particle is held."""


@functools.cache
def anchor_kernel(layout, real, column):
    """Kernel that stops the marked particles of n; given (dim + 1,): impulse [N s] and energy [J] that this gave them,
    added. One thread, so that the sums do not depend on the number of threads."""
    access, dim, at = accessors(layout), layout.dim, layout.offsets

    @grouped_kernel(real)
    def stop(reals: Array, slot_offset: int, material: Array, materials: Array, given: Array, n: int):
        ti.loop_config(serialize=True)
        for p in range(n):
            places = access.places(reals, slot_offset)
            if access.load(reals, places, p, at[column], 1)[0] > HELD:
                v = access.load(reals, places, p, at["velocity"], dim)
                mass = ti.cast(access.load(reals, places, p, at["volume"], 1)[0] * materials[material[p], DENSITY],
                               ti.f64)
                for a in ti.static(range(dim)):
                    given[a] -= mass * v[a]
                given[dim] -= 0.5 * mass * v.norm_sqr()
                access.store(reals, places, p, at["velocity"], ti.Vector.zero(real, dim))
                access.store(reals, places, p, at["affine"], ti.Vector.zero(real, dim * dim))

    return stop
