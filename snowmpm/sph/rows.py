"""What particles show their neighbours: one row of numbers each, in the units of cells.

    source  x [cells, from its block], v [m/s], S, m, V, z [, R] [, D]     read by the momentum sum
    moved   x, v, V                                                  read by the velocity gradient

S: stress over density squared [Pa m6/kg2], or stress [Pa], as the form of the momentum sum wants it; in the plane (xx,
yy, xy) or in space (6 entries). m, V: mass and present volume per cell volume [kg/m3, 1]; z: rho c [kg/m2/s]; R:
artificial stress, in the measure of S; D: stretching [m/s/cell]. Dummy particles have rows like particles, after them.
"""

from dataclasses import dataclass
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array
from snowmpm.compiler.runtime import DTYPES
from snowmpm.errors import SimulationError
from snowmpm.particles.store import INDEX_BITS

PLANE = (0, 1, 3)
"""Entries of a plane strain tensor (xx, yy, zz, xy) that act in the plane."""


@dataclass(frozen=True)
class RowLayout:
    """Columns of the rows. tension: whether they carry an artificial stress; ordered: whether a stretching; full:
    whether S is S K^-1, by rows (`update`), which is not symmetric."""

    dim: int
    tension: bool = False
    ordered: bool = False
    full: bool = False

    @property
    def force_pairs(self):
        """(a, b) of each entry of S as the rows carry it."""
        return tuple((a, b) for a in range(self.dim) for b in range(self.dim)) if self.full else self.pairs

    @property
    def n_stress(self):
        return {2: 3, 3: 6}[self.dim]

    @property
    def pairs(self):
        """(a, b) of each entry of S."""
        return ((0, 0), (1, 1), (0, 1)) if self.dim == 2 else ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))

    @property
    def entries(self):
        """Entry of the law's stress that each entry of S is."""
        return PLANE if self.dim == 2 else tuple(range(6))

    @property
    def at(self):
        """First column of each part of a source row."""
        d, n, f = self.dim, self.n_stress, 2 * self.dim + len(self.force_pairs)
        return {"x": 0, "v": d, "S": 2 * d, "m": f, "V": f + 1, "z": f + 2, "R": f + 3, "D": f + 3 + n * self.tension}

    @property
    def source_width(self):
        return 2 * self.dim + len(self.force_pairs) + self.n_stress * (self.tension + self.ordered) + 3

    @property
    def moved_width(self):
        return 2 * self.dim + 1

    @property
    def row_mask(self):
        """The number of a row has no other bits. Kernels say so, since the compiler must doubt otherwise, for fear of
        indices beyond 32 bits, that the entries of a row follow each other, and works out the place of each."""
        return (1 << INDEX_BITS - 1 - self.source_width.bit_length()) - 1


class RowTables(NamedTuple):
    """The tables of `Rows`, as kernels take them."""

    source: Array
    moved: Array


class Rows:
    """The two tables of rows of particles and dummies, of a working precision."""

    def __init__(self, layout, precision, n):
        self.layout, self.real = layout, DTYPES[precision][0]
        self.n = max(1, n)
        if self.n > layout.row_mask + 1:
            raise SimulationError(f"SPH needs {self.n:,} rows, of particles and of dummies; {layout.row_mask + 1:,} at "
                                  "most fit the 32-bit indices of Taichi's arrays; choose a larger solver.dx")
        self.source = ti.ndarray(ti.types.vector(layout.source_width, self.real), (self.n,))
        self.moved = ti.ndarray(ti.types.vector(layout.moved_width, self.real), (self.n,))
        self.tables = RowTables(self.source, self.moved)

    def write(self, particles, positions):
        """Set the source rows of the particles (n, source_width), at these positions (n, dim)."""
        whole = self.source.to_numpy()
        whole[: len(particles)] = particles
        whole[: len(particles), : self.layout.dim] = positions
        self.source.from_numpy(whole)

    @property
    def bytes(self):
        return self.n * (self.layout.source_width + self.layout.moved_width) * (4 if self.real == ti.f32 else 8)
