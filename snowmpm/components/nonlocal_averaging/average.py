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

from typing import Any

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.runtime import DTYPES
from snowmpm.components.nonlocal_averaging.declare import KEY
from snowmpm.components.nonlocal_averaging.kernels import Nodes, Rows, averaging_kernels
from snowmpm.errors import InputError
from snowmpm.particles.blocks import EDGE
from snowmpm.stepping.component import Adapter

SPACINGS = 1.0 / 0.3157
"""The length over the spacing of its lattice: one over the value of the weight in its middle, a mean over places."""
MARGIN = 3
"""Cells around the blocks that a lattice covers, since particles drift, and nodes around these for the splines."""
MOST_NODES = 1 << 28
BITS = 56
"""Of the sums of a node, some below the 63 that there are."""


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
        self._sums: tuple[Any, ...] = ()

    def rebuild(self, blocks, edge):
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


class FadingAverage(Adapter):
    """What the materials of a solver's particles lose of their strength, averaged over their lengths."""

    name = "nonlocal_averaging"

    def __init__(self, laws):
        """laws: by material index."""
        self._lengths = np.array([law.of_components.get(KEY, 0.0) for law in laws])
        index = {law.FADES for law, length in zip(laws, self._lengths, strict=True) if length}
        assert len(index) == 1, "laws that are averaged keep their variable at one place of the state"
        self._index = index.pop()

    def begin(self, solver):
        """Take a solver's particles. Raises InputError for a length that needs too many nodes."""
        self._particles, self._real = solver.particles, DTYPES[solver.precision][0]
        self._kernels = averaging_kernels(solver.particles.layout, self._real, self._index, solver.serial)
        self._averaged = int_array(self._lengths > 0.0)
        self._lattices = [Lattice(solver.particles, length, self._lengths == length)
                          for length in sorted({*self._lengths.tolist()} - {0.0})]
        self._most, self._kept, self._blocks = np.zeros(1), None, None
        self._rebuild()

    def before_gather(self, dt):
        """Before the laws of a step: remember what their variable is."""
        store = self._particles
        self._rebuild()
        if self._kept is None or self._kept.shape[0] < store.count:
            self._kept = ti.ndarray(self._real, (max(1, store.capacity),))
        self._kernels.remember(self._rows, self._kept, store.count)

    def after_gather(self, dt):
        """After the laws of a step, before any sort: in place of what each particle gained, the mean around it."""
        self._most[0] = 0.0
        self._kernels.gain(self._rows, self._kept, self._averaged, self._most, self._particles.count)
        most = float(self._most[0])
        if 0.0 < most < np.inf:
            for lattice in self._lattices:
                lattice.average(self._kernels, self._rows, self._kept, most)

    def work(self):
        """Particles, and the step."""
        return {"particle": self._particles.count, "step": 1.0}

    @property
    def _rows(self):
        store = self._particles
        return Rows(store.reals, store.slot_offset, store.material, store.start, store.coordinates, store.chunk_bounds)

    def _rebuild(self):
        blocks = self._particles.blocks
        if blocks is not self._blocks and len(blocks):
            self._blocks = blocks
            for lattice in self._lattices:
                lattice.rebuild(blocks, EDGE[self._particles.dim])

    @property
    def bytes(self):
        """Of lattices and what is remembered."""
        kept = 0 if self._kept is None else self._kept.shape[0] * (4 if self._real == ti.f32 else 8)
        return kept + sum(lattice.bytes for lattice in self._lattices)
