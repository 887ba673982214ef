"""Cutting the bonds of the snow along a line, in one pass over the particles."""

import functools

from snowmpm.compiler import ti
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors


@functools.cache
def sever_kernel(layout, real):
    """Kernel `sever(...)` that cuts the bonds of the particles `first <= number < last` within `radius` of a line."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access = accessors(layout)
    at = layout.offsets

    @ti.func
    def distance2(x, line: ti.template()):
        """Squared distance in plan [cells2] of x (dim,) from a line (k, dim - 1) of one or more corners."""
        best = ti.cast(1e30, real)
        for k in range(line.shape[0]):
            ahead, along, square = ti.cast(0.0, real), ti.cast(0.0, real), ti.cast(0.0, real)
            following = ti.min(k + 1, line.shape[0] - 1)
            for a in ti.static(range(dim - 1)):
                side = line[following, a] - line[k, a]
                along += (x[a] - line[k, a]) * side
                square += side * side
            share = ti.max(0.0, ti.min(1.0, along / ti.max(square, 1e-30)))
            for a in ti.static(range(dim - 1)):
                ahead += (x[a] - line[k, a] - share * (line[following, a] - line[k, a])) ** 2
            best = ti.min(best, ahead)
        return best

    @ti.kernel
    def sever(reals: ti.types.ndarray(), slot_offset: int, identity: ti.types.ndarray(), start: ti.types.ndarray(),
              coordinates: ti.types.ndarray(), line: ti.types.ndarray(dtype=real, ndim=2), radius: real, first: int,
              last: int, state: ti.types.ndarray(dtype=real, ndim=1), n_blocks: int) -> int:
        """Make those particles stress-free, set the first entries of their state to `state`, and return how many.

        reals, slot_offset, identity (number of each particle), start, coordinates: tables of the store. line
        (k, dim - 1): corners in plan [cells from the origin]; radius: largest distance in plan [cells].
        """
        hit, places = 0, access.places(reals, slot_offset)
        for b in range(n_blocks):
            for p in range(start[b], start[b + 1]):
                if first <= identity[p] < last:
                    x = access.load(reals, places, p, at["position"], dim)
                    for a in ti.static(range(dim)):
                        x[a] += ti.cast(edge * coordinates[b, a], real)
                    if distance2(x, line) <= radius * radius:
                        values = access.load(reals, places, p, at["state"], layout.state_size)
                        for c in ti.static(range(layout.state_size)):
                            if c < state.shape[0]:
                                values[c] = state[c]
                        access.store(reals, places, p, at["state"], values)
                        access.store(reals, places, p, at["elastic"], ti.Vector.zero(real, layout.sym_size))
                        access.store(reals, places, p, at["stress"], ti.Vector.zero(real, layout.sym_size))
                        hit += 1
        return hit

    return sever
