"""Functions and kernels of the means over the cells (`.mpm`).

A block adds up the cells that its own particles are in, one more on every side since they drift; then each cell is
added up over the blocks that know it, always in the same order. No thread writes where another one does.
"""

import functools
from dataclasses import dataclass
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.mpm.kernel_api import STENCILS, Inlined, interpolation
from snowmpm.particles.blocks import EDGE, step_along
from snowmpm.particles.store import accessors

RELAXED = 0.1
"""Share of what parts the elastic changes of volume in a cell that goes in a step."""


def sums_of(size):
    """Numbers that a cell adds up where its particles share `size`: these times volume, volume, and, of volumes alone,
    their elastic change."""
    return size + 1 + (size == 1)


@dataclass(frozen=True)
class CellMean(Inlined):
    """The mean of a cell in place of each particle's own. size: its numbers, 1: det f - 1, or dim * dim: grad v."""

    size: int = 1
    column = "cell_mean"

    def gradient(self, dim, real):
        """grad v with the mean in its place."""
        evened = mean_functions(dim, real, self.size).evened

        @ti.func
        def with_mean(L, v, ratio, mean, dt, dx):
            return evened(L, mean, dt), mean

        return with_mean


@functools.cache
def mean_functions(dim, real, size):
    """Taichi functions: `shared(L, dt)`, what is averaged, and `evened(L, mean, dt)`, grad v with the mean."""

    @ti.func
    def growth(A):
        second = ti.cast(0.0, real)
        for i in ti.static(range(dim)):
            for j in ti.static(range(i + 1, dim)):
                second += A[i, i] * A[j, j] - A[i, j] * A[j, i]
        result = A.trace() + second
        if ti.static(dim == 3):
            result += A.determinant()
        return result

    @ti.func
    def shared(L, dt):
        if ti.static(size == 1):
            return ti.Vector([growth(dt * L)])
        return ti.Vector([L[i, j] for i in ti.static(range(dim)) for j in ti.static(range(dim))])

    @ti.func
    def of_volume(L, wanted, dt):
        A = dt * L
        own = growth(A)
        more = (wanted - own) / ti.max(1.0 + own, 1e-3)
        # (1 + more)^(1/dim) - 1, more is of the size of a step's strain
        share = ti.static(1.0 / dim)
        swell = share * more * (1.0 + ti.static(0.5 * (1.0 / dim - 1.0)) * more)
        return L + (swell / dt) * (ti.Matrix.identity(real, dim) + A)

    @ti.func
    def evened(L, mean, dt):
        result = L
        if ti.static(size == 1):
            result = of_volume(L, mean[0], dt)
        else:
            result = ti.Matrix([[mean[i * dim + j] for j in range(dim)] for i in range(dim)])
        return result

    return SimpleNamespace(shared=shared, evened=evened)


@functools.cache
def cell_kernels(layout, real, basis, gradient, flip, mean):
    """Kernels `add(...)`, `add_elastic(...)`, `join(...)` and `spread(...)` of the three parts. mean: `CellMean`."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at, reach = accessors(layout), layout.offsets, STENCILS[basis].reach
    shape, wide = gradient == "shape", edge + 2
    grid = interpolation(dim, real, basis, not shape, shape, flip)
    of_node = grid.of_node
    size, even = mean.size, mean_functions(dim, real, mean.size)
    column, relaxes, of_cell = mean.column, size == 1, ti.types.vector(sums_of(size), real)

    @ti.func
    def cell_of(x, b):
        """Where the cell of a particle of block b lies among the sums."""
        cell = 0
        for a in ti.static(range(dim)):
            own = ti.floor(x[a] - ti.static(reach if size == 1 else 0.0), ti.i32) + 1
            cell = cell * wide + ti.max(0, ti.min(wide - 1, own))
        return b * ti.static(wide**dim) + cell

    @ti.func
    def volume_of(reals: ti.template(), places: ti.template(), p):
        """At the start of the step."""
        first = access.load(reals, places, p, at["volume"], 1)[0]
        return first * access.load(reals, places, p, at["volume_ratio"], 1)[0]

    @ti.func
    def elastic(reals: ti.template(), places: ti.template(), p, material: ti.template(), per_stress: ti.template()):
        """Elastic change of volume."""
        tau = access.load(reals, places, p, at["stress"], 3)
        return ti.cast(per_stress[ti.cast(material[p], ti.i32)], real) * (tau[0] + tau[1] + tau[2])

    @taichi_kernel
    def add(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(),
            tiles: ti.types.ndarray(dtype=of_node, ndim=1), sums: ti.types.ndarray(dtype=of_cell, ndim=1), dt: real,
            dx: real, chunk_bounds: ti.types.ndarray()):
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(reals, slot_offset)
                for b in range(begin, end):
                    for c in range(ti.static(wide**dim)):
                        sums[b * ti.static(wide**dim) + c] = of_cell(0.0)
                    for p in range(start[b], start[b + 1]):
                        x = access.load(reals, places, p, at["position"], dim)
                        address, f, w, dw = grid.locate(x, b)
                        v, moments, slopes = grid.interpolate(tiles, address, w, dw)
                        _, L = grid.gradients(f, v, moments, slopes, 1.0 / dx)
                        volume = volume_of(reals, places, p)
                        cell = cell_of(x, b)
                        shared, more = even.shared(L, dt), of_cell(0.0)
                        for k in ti.static(range(size)):
                            more[k] = volume * shared[k]
                        more[size] = volume
                        sums[cell] = sums[cell] + more

    @taichi_kernel
    def add_elastic(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(),
                    material: ti.types.ndarray(), per_stress: ti.types.ndarray(),
                    sums: ti.types.ndarray(dtype=of_cell, ndim=1), chunk_bounds: ti.types.ndarray()):
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(reals, slot_offset)
                for b in range(begin, end):
                    for p in range(start[b], start[b + 1]):
                        cell = cell_of(access.load(reals, places, p, at["position"], dim), b)
                        volume = volume_of(reals, places, p)
                        sums[cell][size + 1] += volume * elastic(reals, places, p, material, per_stress)

    @ti.func
    def part(c, packed):
        """Where cell c of a node block lies among the cells of a tile one step away, -1 where it does not."""
        place, left, inside = 0, c, 1
        for a in ti.static(range(dim)):
            own = left // ti.static(edge ** (dim - 1 - a))
            left -= own * ti.static(edge ** (dim - 1 - a))
            along = own - edge * step_along(packed, a) + 1
            inside = ti.select(along < 0 or along >= wide, 0, inside)
            place = place * wide + along
        return ti.select(inside == 1, place, -1)

    @taichi_kernel
    def join(sums: ti.types.ndarray(dtype=of_cell, ndim=1), first_tile: ti.types.ndarray(),
             tiles_at: ti.types.ndarray(), chunk_bounds: ti.types.ndarray()):
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                for n in range(begin, end):
                    for c in range(ti.static(edge**dim)):
                        total = of_cell(0.0)
                        for k in range(first_tile[n], first_tile[n + 1]):
                            place = part(c, tiles_at[k, 1])
                            if place >= 0:
                                total += sums[tiles_at[k, 0] * ti.static(wide**dim) + place]
                        if total[size] > 0.0:
                            for k in range(first_tile[n], first_tile[n + 1]):
                                place = part(c, tiles_at[k, 1])
                                if place >= 0:
                                    sums[tiles_at[k, 0] * ti.static(wide**dim) + place] = total

    @taichi_kernel
    def spread(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(), material: ti.types.ndarray(),
               per_stress: ti.types.ndarray(), sums: ti.types.ndarray(dtype=of_cell, ndim=1),
               chunk_bounds: ti.types.ndarray()):
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(reals, slot_offset)
                for b in range(begin, end):
                    for p in range(start[b], start[b + 1]):
                        cell = sums[cell_of(access.load(reals, places, p, at["position"], dim), b)]
                        mean = ti.Vector([cell[k] / cell[size] for k in ti.static(range(size))])
                        if ti.static(relaxes):
                            own = elastic(reals, places, p, material, per_stress)
                            mean[0] += ti.static(RELAXED) * (cell[size + 1] / cell[size] - own)
                        access.store(reals, places, p, at[column], mean)

    return SimpleNamespace(add=add, add_elastic=add_elastic, join=join, spread=spread)
