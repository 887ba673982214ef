"""Cutting the bonds of the snow along a line, in one pass over the particles."""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.particles.arrays import BlockRows
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors


class Cut(NamedTuple):
    """Largest distance in plan [cells]; first number of the particles, and that after the last; state they get."""

    radius: Real
    first: int
    last: int
    state: Array


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

    @grouped_kernel(real)
    def sever(rows: BlockRows, identity: Array, line: Array, cut: Cut, hit: Array, n_blocks: int):
        """Make those particles stress-free, set the first entries of their state, and add how many they are to hit[0].

        identity: number of each particle; line (k, dim - 1): corners in plan [cells from the origin].
        """
        for b in range(n_blocks):
            places = access.places(rows.reals, rows.slot_offset)
            for p in range(rows.start[b], rows.start[b + 1]):
                if cut.first <= identity[p] < cut.last:
                    x = access.load(rows.reals, places, p, at["position"], dim)
                    for a in ti.static(range(dim)):
                        x[a] += ti.cast(edge * rows.coordinates[b, a], real)
                    if distance2(x, line) <= cut.radius * cut.radius:
                        values = access.load(rows.reals, places, p, at["state"], layout.state_size)
                        for c in ti.static(range(layout.state_size)):
                            if c < cut.state.shape[0]:
                                values[c] = cut.state[c]
                        access.store(rows.reals, places, p, at["state"], values)
                        access.store(rows.reals, places, p, at["elastic"], ti.Vector.zero(real, layout.sym_size))
                        access.store(rows.reals, places, p, at["stress"], ti.Vector.zero(real, layout.sym_size))
                        ti.atomic_add(hit[0], 1)

    return sever
