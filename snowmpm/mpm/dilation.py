"""One change of volume (F-bar), or of volume and shape, for all particles of a cell in explicit steps.

Against volumetric locking, as in steps that are solved for (`implicit.dilation`), with the cells between the knots of
the spline:

    f_bar = (j_bar / j)^(1/dim) f,    j_bar = sum_p v_p j_p / sum_p v_p,    j = det f,  f = I + dt grad v

v_p is the volume at the start of the step. Laws, and the volume of a particle, follow f_bar. Forces stay those of each
particle's stress: where the particles of a cell have the same pressure, as they do who have shared their changes of
volume, these are the forces of the mean. Coombs et al. 2018, doi:10.1016/j.cma.2018.01.010.

Particles that come from another cell bring another pressure, and since all change their volumes alike, nothing would
ever even it out: in flow, pressures of one cell part until they throw particles about. So a particle has in each step

    j_bar + RELAXED (e_bar - e),    e = tr tau / 3K,    e_bar = sum_p v_p e_p / sum_p v_p

for j_bar, e its elastic change of volume: differences fade in 1 / RELAXED steps, and the volume of the cell stays.

With f_bar = "whole" the particles of a cell share the mean of grad v, weighted by volume, in the cells between nodes.
The quadratic spline spreads an opening between two rows of nodes as a hat over two cells: two particles an axis have
3/4 of it in the cell and 1/4 in each neighbour, which would crack too, or lock. Cells have means of 1/8, 3/4 and 1/8,
and nodes can open one cell with all others at rest: a crack is one cell wide (`materials.cohesive_crack`). Means in the
cells between knots would not see a zigzag of the nodes.

A block adds up the cells that its own particles are in, one more on every side since they drift; then each cell is
added up over the blocks that know it, always in the same order. No thread writes where another one does.
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE, step_along
from snowmpm.particles.store import accessors

SPARE = 1.25
RELAXED = 0.1
"""Share of what parts the elastic changes of volume in a cell that goes in a step."""


class CellDilation:
    """The cells of an `MpmSolver`, whose particles have a column `dilation`."""

    def __init__(self, layout, precision, basis, gradient, flip, laws):
        self._per_stress = real_array([1.0 / (3.0 * law.bulk_modulus) for law in laws])
        self.precision, self._cells = precision, (EDGE[layout.dim] + 2) ** layout.dim
        self._sums = None
        self._kernels = dilation_kernels(layout, runtime.DTYPES[precision][0], basis, gradient, flip)

    def find(self, particles, grid, dt):
        """Leave with each particle what those of its cell share in a step of dt [s], by the velocities of the nodes."""
        size = particles.layout.dilation_size
        n, numbers = max(1, len(particles.blocks)) * self._cells, sums_of(size)
        if self._sums is None or self._sums.shape[0] < n:
            self._sums = ti.ndarray(ti.types.vector(numbers, runtime.DTYPES[self.precision][0]), (int(SPARE * n),))
        kernels = self._kernels
        of_particles = particles.reals, particles.slot_offset, particles.start
        elastic = *of_particles, particles.material, self._per_stress, self._sums, particles.chunk_bounds
        kernels.add(*of_particles, grid.tiles, self._sums, dt, particles.dx, particles.chunk_bounds)
        if size == 1:
            kernels.add_elastic(*elastic)
        kernels.join(self._sums, grid.first_tile, grid.tiles_at, grid.node_chunk_bounds)
        kernels.spread(*elastic)

    @property
    def bytes(self):
        """Of the sums."""
        if self._sums is None:
            return 0
        return self._sums.element_shape[0] * self._sums.shape[0] * (4 if self.precision == "f32" else 8)


def sums_of(size):
    """Numbers that a cell adds up where its particles share `size`: these times volume, volume, and, of volumes alone,
    their elastic change."""
    return size + 1 + (size == 1)


@functools.cache
def even_functions(dim, real, size):
    """Taichi functions of what the particles of a cell share, `size` numbers: `shared(L, dt)`, which is averaged, and
    `evened(L, mean, dt)`, the velocity gradient of a particle with the mean in its place.

    size 1: det f - 1, dim * dim: the velocity gradient.
    """

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
def dilation_kernels(layout, real, basis, gradient, flip):
    """Kernels `add(...)`, `add_elastic(...)`, `join(...)` and `spread(...)` of the three parts."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at, reach = accessors(layout), layout.offsets, STENCILS[basis].reach
    shape, wide = gradient == "shape", edge + 2
    grid = interpolation(dim, real, basis, not shape, shape, flip)
    of_node = grid.of_node
    size = layout.dilation_size
    even = even_functions(dim, real, size)
    relaxes, of_cell = size == 1, ti.types.vector(sums_of(size), real)

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
                        access.store(reals, places, p, at["dilation"], mean)

    return SimpleNamespace(add=add, add_elastic=add_elastic, join=join, spread=spread)
