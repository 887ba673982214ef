"""Plastic strain averaged over a fixed length, so that a band that softens takes the same work on every grid.

    κ_i <- κ_i + <Δκ>_i,    <Δκ>(x) = Σ_j V_j α(x, x_j) Δκ_j / Σ_j V_j α(x, x_j)

The integral average of nonlocal plasticity (Bažant & Jirásek 2002, doi:10.1061/(ASCE)0733-9399(2002)128:11(1119)),
of what the variable gains in a step, so that what a particle has moves on with it. The strength of a law follows the
averaged κ; its flow stays its own. Constants are left as they are, also at free surfaces and walls, where α is cut
off.

The weight is that of a lattice of its own, at rest and finer than the length l: quadratic B-splines to its nodes,
[1 4 6 4 1]/16 along each axis, the same splines back. It is a bell of variance 3/2 a² per axis, a the spacing of the
lattice. With a = l / `SPACINGS` a slip u on a plane counts at its place as if it was spread over l: α, summed along
the plane, is 1/l there, within 1 % wherever the plane lies.

Sums are those of whole numbers, which do not depend on their order: results are the same for any number of threads.
"""

import functools
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import taichi as ti

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.compiler.runtime import DTYPES
from snowmpm.errors import InputError
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors

SPACINGS = 1.0 / 0.3157
"""The length over the spacing of its lattice: one over the value of the weight in its middle, a mean over places."""
MARGIN = 3
"""Cells around the blocks that a lattice covers, since particles drift, and nodes around these for the splines."""
MOST_NODES = 1 << 28
BITS = 56
"""Of the sums of a node, some below the 63 that there are."""


class Rows(NamedTuple):
    """Particles by blocks."""

    reals: Array
    slot_offset: int
    material: Array
    start: Array
    coordinates: Array
    chunk_bounds: Array


class Nodes(NamedTuple):
    """A lattice: sums of (V Δκ, V) of its nodes; first node, number of nodes, whether they repeat (dim each); nodes per
    cell (dim); material -> whether it is averaged here."""

    sums: Array
    first: Array
    count: Array
    repeats: Array
    per_cell: Array
    averaged: Array


@functools.cache
def averaging_kernels(layout, real, index, serial):
    """Kernels `remember`, `gain`, `clear`, `scatter`, `blur` and `gather` of state variable `index`; serial: by one
    thread."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at = accessors(layout), layout.offsets
    column = at["state"] + index

    @ti.func
    def add(sums: ti.template(), k, value):
        if ti.static(serial):
            sums[k] = sums[k] + value
        else:
            ti.atomic_add(sums[k], value)

    @ti.func
    def locate(nodes: ti.template(), x, b, coordinates: ti.template()):
        """Numbers of the first of three nodes along each axis, and their weights by axis."""
        base, w = ti.Vector.zero(ti.i32, dim), ti.Matrix.zero(ti.f64, dim, 3)
        for a in ti.static(range(dim)):
            y = (ti.cast(edge * coordinates[b, a], ti.f64) + ti.cast(x[a], ti.f64)) * nodes.per_cell[a]
            base[a] = ti.floor(y - 0.5, ti.i32)
            f = y - ti.cast(base[a], ti.f64)
            w[a, 0], w[a, 1], w[a, 2] = 0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2
            base[a] -= nodes.first[a]
        return base, w

    @ti.func
    def node(nodes: ti.template(), base, step: ti.template()):
        """Number of a node, `step` from the first of its particle."""
        k = 0
        for a in ti.static(range(dim)):
            n = nodes.count[a]
            i = base[a] + step[a]
            if nodes.repeats[a] == 1:
                i = (i % n + n) % n
            k = k * n + ti.max(0, ti.min(n - 1, i))
        return k

    @grouped_kernel(real)
    def remember(rows: Rows, kept: Array, count: int):
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            kept[p] = access.load(rows.reals, access.places(rows.reals, rows.slot_offset), p, column, 1)[0]

    @grouped_kernel(real)
    def gain(rows: Rows, kept: Array, averaged: Array, most: Array, count: int):
        """Leave Δκ in `kept`, the κ before, and the largest of the materials that are averaged in `most`."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            places = access.places(rows.reals, rows.slot_offset)
            more = access.load(rows.reals, places, p, column, 1)[0] - kept[p]
            if averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                kept[p] = more
                if more != 0.0:
                    ti.atomic_max(most[0], ti.abs(ti.cast(more, ti.f64)))

    @taichi_kernel
    def clear(sums: ti.types.ndarray(), n: int):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(n):
            sums[k] = ti.cast(0, ti.i64)

    @grouped_kernel(real)
    def scatter(rows: Rows, nodes: Nodes, kept: Array, per_gain: Real, per_volume: Real):
        for i in range(chunks(rows.chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, rows.chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(begin, end):
                    for p in range(rows.start[b], rows.start[b + 1]):
                        if nodes.averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                            x = access.load(rows.reals, places, p, at["position"], dim)
                            base, w = locate(nodes, x, b, rows.coordinates)
                            volume = access.load(rows.reals, places, p, at["volume"], 1)[0]
                            volume *= access.load(rows.reals, places, p, at["volume_ratio"], 1)[0]
                            share = ti.cast(volume, ti.f64) * per_volume
                            more = ti.cast(kept[p], ti.f64) * per_gain
                            for step in ti.static(ti.ndrange(*(3,) * dim)):
                                k, weight = node(nodes, base, step), share
                                for a in ti.static(range(dim)):
                                    weight *= w[a, step[a]]
                                add(nodes.sums, 2 * k + 1, ti.cast(weight, ti.i64))
                                if more != 0.0:
                                    add(nodes.sums, 2 * k, ti.cast(weight * more, ti.i64))

    @taichi_kernel
    def blur(sums: ti.types.ndarray(), out: ti.types.ndarray(), n_nodes: int, stride: int, count: int, repeats: int):
        """[1 4 6 4 1] along an axis of `count` nodes that are `stride` apart."""
        ti.loop_config(serialize=ti.static(serial))
        for k in range(n_nodes):
            i = k // stride % count
            for c in ti.static(range(2)):
                total = ti.cast(0, ti.i64)
                for step, weight in ti.static(((-2, 1), (-1, 4), (0, 6), (1, 4), (2, 1))):
                    j = i + step
                    if repeats == 1:
                        j = (j % count + count) % count
                    if 0 <= j < count:
                        total += weight * sums[2 * (k + (j - i) * stride) + c]
                out[2 * k + c] = total

    @grouped_kernel(real)
    def gather(rows: Rows, nodes: Nodes, kept: Array, per_gain: Real):
        for i in range(chunks(rows.chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, rows.chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(begin, end):
                    for p in range(rows.start[b], rows.start[b + 1]):
                        if nodes.averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                            x = access.load(rows.reals, places, p, at["position"], dim)
                            base, w = locate(nodes, x, b, rows.coordinates)
                            above, below = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                            for step in ti.static(ti.ndrange(*(3,) * dim)):
                                k, weight = node(nodes, base, step), ti.cast(1.0, ti.f64)
                                for a in ti.static(range(dim)):
                                    weight *= w[a, step[a]]
                                above += weight * ti.cast(nodes.sums[2 * k], ti.f64)
                                below += weight * ti.cast(nodes.sums[2 * k + 1], ti.f64)
                            mean = ti.cast(above / (per_gain * ti.max(below, 1.0)), real)
                            now = access.load(rows.reals, places, p, column, 1)
                            now[0] += mean - kept[p]
                            access.store(rows.reals, places, p, column, now)

    return SimpleNamespace(remember=remember, gain=gain, clear=clear, scatter=scatter, blur=blur, gather=gather)


class Lattice:
    """The nodes of one length, around the blocks of the particles."""

    def __init__(self, particles, length, averaged):
        """length [m]; averaged (n,): whether each material is averaged over it."""
        dim, edge = particles.dim, EDGE[particles.dim]
        spacing = length / SPACINGS / particles.dx
        self._period = edge * particles._period
        # A whole number of nodes in a period
        self._per_cell = np.where(self._period > 0, np.maximum(1, np.round(self._period / spacing))
                                  / np.maximum(self._period, 1), 1.0 / spacing)
        self._length = length
        self._fixed = int_array(self._period > 0), real_array(self._per_cell), int_array(averaged)
        # Volumes of a node add up to that of its share of space, four times that where particles crowd
        room = np.prod(1.0 / self._per_cell) + 1.0
        self.per_volume = 2.0 ** np.floor(BITS - 4 * dim - np.log2(8.0 * room)) / particles.dx**dim
        self._sums = ()

    def follow(self, blocks, edge):
        """Cover the blocks there are. Raises InputError for more nodes than can be."""
        low, high = edge * blocks.coordinates.min(axis=0), edge * (blocks.coordinates.max(axis=0) + 1)
        first, last = (np.floor(cells * self._per_cell).astype(int) for cells in (low - MARGIN, high + MARGIN))
        first, last = np.where(self._period > 0, 0, first - MARGIN), last + MARGIN
        count = np.where(self._period > 0, np.round(self._per_cell * self._period).astype(int), last - first + 1)
        n = int(np.prod(count))
        if n > MOST_NODES:
            raise InputError(f"nonlocal_length = {self._length:g} m: needs {n:,} nodes around all particles, at most"
                             f" {MOST_NODES:,}; choose a larger one")
        if not self._sums or self._sums[0].shape[0] < 2 * n:
            self._sums = tuple(ti.ndarray(ti.i64, (2 * int(1.25 * n),)) for _ in range(2))
        self._n, self._count = n, count
        self._place = int_array(first), int_array(count)

    def average(self, kernels, rows, kept, most):
        """Spread the gains `kept` of the particles; most: the largest of them."""
        nodes = Nodes(self._sums[0], *self._place, *self._fixed)
        kernels.clear(self._sums[0], 2 * self._n)
        per_gain = 2.0 ** -np.ceil(np.log2(most))
        kernels.scatter(rows, nodes, kept, per_gain, self.per_volume)
        here, there = self._sums
        stride = self._n
        for n, period in zip(self._count, self._period, strict=True):
            stride //= int(n)
            kernels.blur(here, there, self._n, stride, int(n), int(period > 0))
            here, there = there, here
        kernels.gather(rows, nodes._replace(sums=here), kept, per_gain)

    @property
    def bytes(self):
        return sum(8 * array.shape[0] for array in self._sums)


class FadingAverage:
    """What the materials of a solver's particles lose of their strength, averaged over their lengths."""

    def __init__(self, particles, precision, serial):
        """serial: by one thread. Raises InputError for a length that needs too many nodes."""
        self._particles, laws = particles, particles.materials.laws
        lengths = [law.averaging_length or 0.0 for law in laws]
        index = {law.FADES for law, length in zip(laws, lengths, strict=True) if length}
        assert len(index) == 1, "laws that are averaged keep their variable at one place of the state"
        real = DTYPES[precision][0]
        self._kernels = averaging_kernels(particles.layout, real, index.pop(), serial)
        self._averaged = int_array(np.array(lengths) > 0.0)
        self._lattices = [Lattice(particles, length, np.array(lengths) == length)
                          for length in sorted({*lengths} - {0.0})]
        self._most, self._real = np.zeros(1), real
        self._kept = self._blocks = None
        self._follow()

    @classmethod
    def of(cls, particles, precision, serial):
        """None where no material is averaged."""
        if not any(law.averaging_length for law in particles.materials.laws):
            return None
        return cls(particles, precision, serial)

    def remember(self):
        """Before the laws of a step: what their variable is."""
        store = self._particles
        self._follow()
        if self._kept is None or self._kept.shape[0] < store.count:
            self._kept = ti.ndarray(self._real, (max(1, store.capacity),))
        self._kernels.remember(self._rows, self._kept, store.count)

    def spread(self):
        """After the laws of a step, before any sort: in place of what each particle gained, the mean around it."""
        self._most[0] = 0.0
        self._kernels.gain(self._rows, self._kept, self._averaged, self._most, self._particles.count)
        most = float(self._most[0])
        if 0.0 < most < np.inf:
            for lattice in self._lattices:
                lattice.average(self._kernels, self._rows, self._kept, most)

    @property
    def _rows(self):
        store = self._particles
        return Rows(store.reals, store.slot_offset, store.material, store.start, store.coordinates, store.chunk_bounds)

    def _follow(self):
        blocks = self._particles.blocks
        if blocks is not self._blocks and len(blocks):
            self._blocks = blocks
            for lattice in self._lattices:
                lattice.follow(blocks, EDGE[self._particles.dim])

    @property
    def bytes(self):
        """Of lattices and what is remembered."""
        kept = 0 if self._kept is None else self._kept.shape[0] * (4 if self._real == ti.f32 else 8)
        return kept + sum(lattice.bytes for lattice in self._lattices)
