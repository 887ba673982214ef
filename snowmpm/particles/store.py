"""The particle store: only the numbers that a scene's laws need, in a few tables of equal width.

A particle's numbers are cut into tables, a row per particle on a CPU (the numbers of a row share a cache line: 13 %
faster scatter than a column each, measured) and a column per particle on a GPU (coalesced). All tables lie in one array
of slots, one slot more than there are tables: a sort moves the first table to the free slot, the second one to the slot
that became free, and so on, so that it needs room for one more table, not for all of them. Table t lies in slot
(t + slot_offset) modulo the number of slots. Kernels see the offsets of `Layout` as constants.

Taichi counts the entries of an array with 32 bits: 45 to 60 million particles in 3-D, by the numbers that each has. A
GPU has memory for more. Beyond that two columns in single precision share an entry of 64 bits (`Layout.paired`), for
twice as many particles; their number when a run begins decides.

Positions are kept relative to the particle's owner block, in cells, so that float32 resolves 3e-7 of a cell however
large the terrain is.
"""

import functools
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import runs_serially
from snowmpm.compiler.runtime import DTYPES

MATERIAL, IDENTITY = 0, 1
"""Columns of `ParticleStore.labels`: index of the material, number given at seeding."""

INDEX_BITS = 31
LARGEST_INDEX = (1 << INDEX_BITS) - 1
MOST_TABLES = 5
UNROLLED = 32
"""Rounds of a loop that Taichi unrolls without a warning."""

SPARE = 1.5
"""Room for particles over those that ask for it."""

MOST_MATERIALS = 256
"""A material index is one byte."""

COPY_TIME = 2e-8
"""Of a particle on one thread [s], about."""


@dataclass(frozen=True)
class Layout:
    """Which reals a particle carries and where.

    position [cells, from its block], velocity [m/s], affine: C [1/s], row major; elastic: the law's elastic variable
    (be - I), stress: Kirchhoff stress [Pa], both symmetric (4 numbers in plane strain, 6 in 3-D); state: the law's
    internal variables; volume_ratio: J = det F; volume: reference volume [m3]; more: names of the columns of
    components, and their numbers; mass_column: of these, the one whose first number is a mass per reference volume
    [kg/m3] that the particle has beside that of its material, "" without one; still_column: of these, the one whose
    first number is above 0 for snow that is no part of the flow, "" without one; paired: two columns share an entry of
    64 bits, only in single precision and with a column per particle.
    """

    dim: int
    state_size: int
    by_row: bool = True
    more: tuple[tuple[str, int], ...] = ()
    mass_column: str = ""
    still_column: str = ""
    paired: bool = False

    @property
    def sym_size(self):
        return 4 if self.dim == 2 else 6

    @functools.cached_property
    def sizes(self):
        d = self.dim
        return {"position": d, "velocity": d, "affine": d * d, "elastic": self.sym_size, "stress": self.sym_size,
                "state": self.state_size, "volume_ratio": 1, "volume": 1,
                **dict(self.more)}

    @functools.cached_property
    def offsets(self):
        ends = np.cumsum(list(self.sizes.values()))
        return {name: int(end - size) for (name, size), end in zip(self.sizes.items(), ends, strict=True)}

    @property
    def mass_at(self):
        """Offset of the mass of `mass_column`, -1 without one."""
        return self.offsets.get(self.mass_column, -1)

    @property
    def still_at(self):
        """Offset of the mark of `still_column`, -1 without one."""
        return self.offsets.get(self.still_column, -1)

    @property
    def width(self):
        return sum(self.sizes.values())

    @functools.cached_property
    def tables(self):
        """(number of tables, columns of each): the cut that takes least room with the spare table."""
        whole = 2 if self.paired else 1
        cuts = [(n, -(-self.width // (n * whole)) * whole) for n in range(2, MOST_TABLES + 1)]
        return min(cuts, key=lambda cut: (cut[0] + 1) * cut[1])

    @property
    def most_particles(self):
        """Particles whose numbers Taichi can tell apart: it counts the entries of an array with 32 bits, and where they
        are more it reads and writes others without a word."""
        n_tables, width = self.tables
        rows = LARGEST_INDEX // (width // 2 if self.paired else width)
        return (min(rows, self.row_mask + 1) if self.by_row else rows) // (n_tables + 1)

    @property
    def row_mask(self):
        """The number of a row has no other bits. Kernels say so, since the compiler must doubt otherwise, for fear of
        indices beyond 32 bits, that the entries of a row follow each other, and works out the place of each."""
        return (1 << INDEX_BITS - (self.tables[1] - 1).bit_length()) - 1

    def columns(self, name):
        return slice(self.offsets[name], self.offsets[name] + self.sizes[name])

    def fitting(self, count, precision):
        """This layout, or a paired one where so many particles cannot be told apart otherwise and it is possible."""
        if count <= self.most_particles or self.by_row or precision != "f32":
            return self
        return replace(self, paired=True)


@ti.func
def joined(low, high):
    """Entry of 64 bits that holds two numbers in single precision."""
    return ti.cast(ti.bit_cast(low, ti.u32), ti.u64) | (ti.cast(ti.bit_cast(high, ti.u32), ti.u64) << 32)


@ti.func
def halves(entry):
    """The two numbers of `joined`."""
    return ti.Vector([ti.bit_cast(ti.cast(entry, ti.u32), ti.f32), ti.bit_cast(ti.cast(entry >> 32, ti.u32), ti.f32)])


@functools.cache
def accessors(layout):
    """Taichi functions of the array of slots `reals`, as attributes.

    places(reals, slot_offset): where every table begins, and the free slot, for the other two;
    load(reals, places, p, offset, n): n numbers of particle p; store(reals, places, p, offset, vector).
    """
    n_tables, width = layout.tables

    def cells(offset, n):
        """(table, column in it) of n columns."""
        return [divmod(column, width) for column in range(offset, offset + n)]

    def rows(offset, n):
        """(table, first entry of n that lies in it, whether all of its row is meant) of n columns."""
        parts = sorted({table for table, _ in cells(offset, n)})
        return [(t, t * width - offset, offset <= t * width and (t + 1) * width <= offset + n) for t in parts]

    if layout.by_row:

        @ti.func
        def places(reals: ti.template(), slot_offset):
            capacity = reals.shape[0] // ti.static(n_tables + 1)
            return ti.Vector([(slot_offset + t) % ti.static(n_tables + 1) * capacity
                              for t in ti.static(range(n_tables + 1))])

        @ti.func
        def load(reals: ti.template(), places, p, offset: ti.template(), n: ti.template()):
            return ti.Vector([reals[(places[t] + p) & layout.row_mask][c] for t, c in ti.static(cells(offset, n))])

        @ti.func
        def store(reals: ti.template(), places, p, offset: ti.template(), values):
            # A whole row at once costs a quarter of the instructions of its entries one by one
            for t, first, whole in ti.static(rows(offset, values.n)):
                row = (places[t] + p) & layout.row_mask
                if ti.static(whole):
                    reals[row] = ti.Vector([values[first + c] for c in ti.static(range(width))])
                else:
                    for c in ti.static(range(max(0, -first), min(width, values.n - first))):
                        reals[row][c] = values[first + c]

    else:
        entries = width // 2 if layout.paired else width

        @ti.func
        def places(reals: ti.template(), slot_offset):
            capacity = reals.shape[0] // ti.static((n_tables + 1) * entries)
            return ti.Vector([(slot_offset + t) % ti.static(n_tables + 1) * capacity * entries
                              for t in ti.static(range(n_tables + 1))])

    if layout.paired:

        def pairs(offset, n):
            """(table, entry in it, first of n numbers that it holds, -1 where it holds one before) of n columns."""
            first = offset // 2
            return [(*divmod(entry, entries), 2 * entry - offset) for entry in range(first, (offset + n + 1) // 2)]

        @ti.func
        def load(reals: ti.template(), places, p, offset: ti.template(), n: ti.template()):
            capacity = reals.shape[0] // ti.static((n_tables + 1) * entries)
            values = ti.Vector.zero(ti.f32, n)
            for t, c, first in ti.static(pairs(offset, n)):
                both = halves(reals[places[t] + c * capacity + p])
                for i in ti.static(range(2)):
                    if ti.static(0 <= first + i < n):
                        values[first + i] = both[i]
            return values

        @ti.func
        def store(reals: ti.template(), places, p, offset: ti.template(), values):
            capacity = reals.shape[0] // ti.static((n_tables + 1) * entries)
            for t, c, first in ti.static(pairs(offset, values.n)):
                at = places[t] + c * capacity + p
                both = ti.Vector.zero(ti.f32, 2)
                if ti.static(not 0 <= first < values.n - 1):  # the other half stays
                    both = halves(reals[at])
                for i in ti.static(range(2)):
                    if ti.static(0 <= first + i < values.n):
                        both[i] = values[first + i]
                reals[at] = joined(both[0], both[1])

    elif not layout.by_row:

        @ti.func
        def load(reals: ti.template(), places, p, offset: ti.template(), n: ti.template()):
            capacity = reals.shape[0] // ti.static((n_tables + 1) * width)
            return ti.Vector([reals[places[t] + c * capacity + p] for t, c in ti.static(cells(offset, n))])

        @ti.func
        def store(reals: ti.template(), places, p, offset: ti.template(), values):
            capacity = reals.shape[0] // ti.static((n_tables + 1) * width)
            for i in ti.static(range(values.n)):
                t, c = ti.static(cells(offset + i, 1)[0])
                reals[places[t] + c * capacity + p] = values[i]

    return SimpleNamespace(places=places, load=load, store=store)


@functools.cache
def store_kernels(layout, real, serial):
    """Kernels that copy particles from and to NumPy, and move them: `read`, `write`, `move_labels`, `move_table`.

    serial: by one thread.
    """
    access, (n_tables, width) = accessors(layout), layout.tables
    exact = ti.i32 if real == ti.f32 else ti.i64

    @taichi_kernel
    def read(reals: ti.types.ndarray(), slot_offset: int, begin: int, rows: ti.types.ndarray()):
        """Particles from `begin` on."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(rows.shape[0]):
            values = access.load(reals, access.places(reals, slot_offset), begin + p, 0, layout.width)
            for first in ti.static(range(0, layout.width, UNROLLED)):
                for c in ti.static(range(first, min(first + UNROLLED, layout.width))):
                    rows[p, c] = values[c]

    @taichi_kernel
    def write(reals: ti.types.ndarray(), slot_offset: int, begin: int, rows: ti.types.ndarray()):
        """Particles from `begin` on."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(rows.shape[0]):
            values = ti.Vector([rows[p, c] for c in ti.static(range(layout.width))])
            access.store(reals, access.places(reals, slot_offset), begin + p, 0, values)

    @taichi_kernel
    def move_labels(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(),
                    identity: ti.types.ndarray(), target: ti.types.ndarray(), count: int, alive: int):
        """By way of the free slot, bit by bit."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            if target[p] >= 0:
                pair = ti.Vector([ti.bit_cast(ti.cast(material[p], exact), real),
                                  ti.bit_cast(ti.cast(identity[p], exact), real)])
                access.store(reals, access.places(reals, slot_offset), target[p], ti.static(n_tables * width), pair)
        ti.loop_config(serialize=ti.static(serial))
        for p in range(alive):
            pair = access.load(reals, access.places(reals, slot_offset), p, ti.static(n_tables * width), 2)
            material[p] = ti.cast(ti.bit_cast(pair[0], exact), ti.u8)
            identity[p] = ti.cast(ti.bit_cast(pair[1], exact), ti.i32)

    @taichi_kernel
    def move_table(reals: ti.types.ndarray(), slot_offset: int, target: ti.types.ndarray(), count: int):
        """Table 0 at this turn, to the free slot."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            if target[p] >= 0:
                places = access.places(reals, slot_offset)
                access.store(reals, places, target[p], ti.static(n_tables * width),
                             access.load(reals, places, p, 0, width))

    return SimpleNamespace(read=read, write=write, move_labels=move_labels, move_table=move_table)


class ParticleStore:
    """Particles of one simulation; `count` rows are alive, the rest is room.

    reals, slot_offset: the tables, for `accessors`; material (bytes), identity: NumPy-like arrays of the labels;
    target: the row that a sort gives each particle, -1 for none.
    """

    def __init__(self, layout, capacity, precision):
        self.layout = layout
        self.precision = precision
        dtype, self.numpy_dtype = DTYPES[precision]
        self._allocate(capacity)
        self.changes = 0
        """How often columns were written from outside a step: who keeps copies of them has to look again."""
        self._kernels = store_kernels(layout, dtype, runs_serially(COPY_TIME * capacity))

    def _allocate(self, capacity):
        """Room for so many particles, and none in it."""
        dtype, (n_tables, width) = DTYPES[self.precision][0], self.layout.tables
        rows = (n_tables + 1) * max(1, capacity)
        if self.layout.by_row:
            self.reals = ti.ndarray(ti.types.vector(width, dtype), rows)
        elif self.layout.paired:
            self.reals = ti.ndarray(ti.u64, rows * width // 2)
        else:
            self.reals = ti.ndarray(dtype, rows * width)
        self.material = ti.ndarray(ti.u8, max(1, capacity))
        self.identity, self.target = (ti.ndarray(ti.i32, max(1, capacity)) for _ in range(2))
        self.capacity, self.slot_offset, self.count = capacity, 0, 0

    def make_room(self, count):
        """Room for `count` particles at least, with those that there are."""
        if count > self.capacity:
            table, labels = self.table(), self.labels()
            self._allocate(min(int(SPARE * count), max(count, self.layout.most_particles)))
            self.replace(table, labels)

    def fill(self, columns, material, identity):
        """Set every particle from NumPy columns {name: (n, size)}; names left out start at zero."""
        table = np.zeros((len(material), self.layout.width), self.numpy_dtype)
        for name, values in columns.items():
            table[:, self.layout.columns(name)] = np.reshape(values, (len(table), self.layout.sizes[name]))
        self.replace(table, np.stack([material, identity], axis=1))

    def table(self):
        """Copy of the reals of the living particles, (count, width)."""
        rows = np.empty((self.count, self.layout.width), self.numpy_dtype)
        for begin in self._pieces():
            self._kernels.read(self.reals, self.slot_offset, begin, rows[begin : begin + self._piece])
        return rows

    @property
    def _piece(self):
        """Rows of a NumPy table whose entries can be told apart."""
        return LARGEST_INDEX // self.layout.width

    def _pieces(self):
        """First particle of each piece."""
        return range(0, self.count, self._piece)

    def labels(self):
        """Copy of (material, identity) of the living particles, (count, 2)."""
        return np.stack([self.material.to_numpy()[: self.count].astype(np.int32),
                         self.identity.to_numpy()[: self.count]], axis=1)

    def replace(self, table, labels):
        """Set every particle from copies of `table()` and `labels()`; raises ValueError when they have no room."""
        if len(table) > self.capacity or np.max(labels[:, MATERIAL], initial=0) >= MOST_MATERIALS:
            raise ValueError(f"room for {self.capacity} particles of {MOST_MATERIALS} materials")
        self.count = len(table)
        for array, column, dtype in ((self.material, MATERIAL, np.uint8), (self.identity, IDENTITY, np.int32)):
            whole = np.zeros(array.shape, dtype)
            whole[: self.count] = labels[:, column]
            array.from_numpy(whole)
        self.overwrite(table)

    def overwrite(self, table):
        """Put back a changed copy of `table()`."""
        self.changes += 1
        table = np.ascontiguousarray(table, self.numpy_dtype)
        for begin in self._pieces():
            self._kernels.write(self.reals, self.slot_offset, begin, table[begin : begin + self._piece])

    def move(self, alive):
        """Bring every particle to the row that `target` names, `alive` of them; the others are gone."""
        kernels = self._kernels
        kernels.move_labels(self.reals, self.slot_offset, self.material, self.identity, self.target, self.count, alive)
        slots = self.layout.tables[0] + 1
        for table in range(slots - 1):
            kernels.move_table(self.reals, (self.slot_offset + table) % slots, self.target, self.count)
        # Every table went one slot back
        self.slot_offset = (self.slot_offset - 1) % slots
        self.count = alive

    @property
    def bytes_per_particle(self):
        """All arrays, room for a sort included."""
        n_tables, width = self.layout.tables
        return (n_tables + 1) * width * np.dtype(self.numpy_dtype).itemsize + 1 + 4 + 4
