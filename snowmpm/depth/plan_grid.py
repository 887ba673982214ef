"""The grid of a depth-averaged flow: square cells in plan with a node in the middle of each, numbered by tiles.

A node is found by the sum of two numbers, one of its column and one of its row:

    node(i, j) = row_part[i] + column_part[j],   tile after tile, `TILE` x `TILE` nodes each

so that what lies together in plan lies together in memory, and a step touches the tiles that hold snow only. The tables
reach `MARGIN` cells beyond the sides; there, they point back to the mirror image of a node (a wall), or to the node
`n` cells on (a periodic side).
"""

import numpy as np

from snowmpm import memory
from snowmpm.compiler.arrays import int_array
from snowmpm.errors import InputError

TILE = 8
"""Nodes along the side of a tile."""

LEAST = 3
"""Cells along an axis: a column's spline meets so many nodes."""
MARGIN = 4
"""Cells beyond the sides that places may be looked up in."""


class PlanGrid:
    """shape (2,): cells along x and y, LEAST at the least; lower (2,) [m]: corner of the first cell; dx [m];
    repeats (2,): periodic axes.

    lookup: Taichi (2, cells + 2 MARGIN) of the parts of a node's number, for the cell i at i + MARGIN.
    """

    def __init__(self, lower, upper, dx, repeats=(False, False)):
        self.lower, self.dx = np.asarray(lower, float), float(dx)
        cells = np.ceil((np.asarray(upper, float) - self.lower) / dx - 1e-6).astype(int)
        self.shape, self.repeats = np.maximum(cells, LEAST), np.asarray(repeats, bool)
        if (self.repeats & (cells < LEAST)).any():
            raise InputError(f"domain: periodic sides must be {LEAST} cells of solver.dx = {dx:g} m apart at least")
        self.tiles = -(-self.shape // TILE)
        self.n_tiles = int(self.tiles.prod())
        self.n_nodes = self.n_tiles * TILE**2
        memory.require(200.0 * self.n_nodes, "solver.dx: the cells of the terrain in plan")
        self._lookup = np.zeros((2, int(self.shape.max()) + 2 * MARGIN), np.int32)
        for axis, (step, inner) in enumerate(((self.tiles[1] * TILE**2, TILE), (TILE**2, 1))):
            n = self.shape[axis]
            cell = self.inner(axis, np.arange(-MARGIN, n + MARGIN))
            self._lookup[axis, : n + 2 * MARGIN] = cell // TILE * step + cell % TILE * inner
        self.lookup = int_array(self._lookup)

    def nodes(self):
        """Number of each node (nx, ny)."""
        return (self._lookup[0, MARGIN : MARGIN + self.shape[0], None]
                + self._lookup[1, None, MARGIN : MARGIN + self.shape[1]])

    def inner(self, axis, cell):
        """Cells (n,) along an axis, of which those beyond the sides are taken for their image inside."""
        n = self.shape[axis]
        return cell % n if self.repeats[axis] else np.where(cell < 0, -1 - cell, np.where(cell < n, cell,
                                                                                          2 * n - 1 - cell))

    def number(self, i, j):
        """Number of the node of cells i, j (n,), up to `MARGIN` beyond the sides."""
        return self._lookup[0, i + MARGIN] + self._lookup[1, j + MARGIN]

    def places(self):
        """Plan positions of the nodes (nx, ny, 2) [m]."""
        axes = [self.lower[a] + (np.arange(self.shape[a]) + 0.5) * self.dx for a in (0, 1)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    def flat(self, values):
        """Values of the nodes (nx, ny, ...) by their numbers (n_nodes, ...); 0 for what fills up the last tiles."""
        flat = np.zeros((self.n_nodes, *values.shape[2:]), values.dtype)
        flat[self.nodes()] = values
        return flat

    def cells(self, plan):
        """Cells (n, 2) and offsets (n, 2) in [-1/2, 1/2) from their nodes, of plan positions (n, 2) [m]."""
        at = (plan - self.lower) / self.dx
        cell = np.floor(at)
        return cell.astype(np.int32), at - cell - 0.5

    def plan(self, cell, offset):
        """Plan positions (n, 2) [m] of cells and offsets."""
        return self.lower + (cell + 0.5 + offset) * self.dx
