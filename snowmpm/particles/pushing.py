"""A force on some of the particles, in one pass over them."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.particles.store import accessors


@functools.cache
def push_kernel(layout, real):
    """Kernel that adds `gain` (dim,) [m/s] to the velocity of the particles `first <= number < last`."""
    access, dim = accessors(layout), layout.dim
    velocity = layout.offsets["velocity"]

    @taichi_kernel
    def push(reals: ti.types.ndarray(), slot_offset: int, identity: ti.types.ndarray(),
             gain: ti.types.ndarray(dtype=real, ndim=1), first: int, last: int, count: int):
        places = access.places(reals, slot_offset)
        for p in range(count):
            if first <= identity[p] < last:
                v = access.load(reals, places, p, velocity, dim)
                for a in ti.static(range(dim)):
                    v[a] += gain[a]
                access.store(reals, places, p, velocity, v)

    return push
