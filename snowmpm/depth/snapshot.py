"""Columns of snow at one moment, as the program reads particles: in three dimensions, at half their depth."""

import numpy as np

from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.smoothing import surface_heights

EMPTY = {"affine": 9, "stress": 6, "elastic": 6, "state": 1}
"""What other particles carry and columns do not, and how many numbers that would be."""

PLACES = {"volume": 4, "depth": 5}
"""Where a column's numbers lie (`columns.OFFSETS`)."""


def spline(f):
    """Weights and derivatives (n, 3) of the spline (`depth.spline`) at offsets f (n,). NumPy."""
    return (np.stack([0.5 * (0.5 - f) ** 2, 0.75 - f * f, 0.5 * (0.5 + f) ** 2], axis=1),
            np.stack([f - 0.5, -2.0 * f, f + 0.5], axis=1))


REACH = 3
"""Cells between two columns that may feel each other: each lies over its node and the two beside it, and `smoothing`
goes one further."""


class ColumnSnapshot:
    """labels (n, 2): index of the material and number of each column."""

    def __init__(self, store, near=None):
        """near (k,): rows of columns that alone are wanted. What is read of one is right if all those within `REACH`
        are among them."""
        rows = slice(store.count) if near is None else near
        self._load = store.load and store.load.copied(rows)
        ends = np.cumsum(list(store.load.sizes.values())) if store.load else ()
        self._of_load = {name: slice(end - size, end) for (name, size), end in zip(
            store.load.sizes.items() if store.load else (), ends, strict=True)}
        self._grid, self._bed = store.grid, store.bed
        self._cells = store.cells.to_numpy()[rows].astype(np.int64)
        self._reals = store.reals.to_numpy()[rows].astype(float)
        self._all = None
        self.labels = np.stack([store.material.to_numpy()[rows], store.identity.to_numpy()[rows]], axis=1)

    def surface_of(self, chosen):
        """What the columns chosen (n,) add to the height of the snow's surface at every column (n,) [m]."""
        reals = self._reals.copy()
        reals[~chosen, PLACES["volume"]] = 0.0
        return self._surface(reals)

    def _ground(self):
        """Height [m] and slope (n, 2) of the ground, and height of the snow's surface over it, at every column."""
        if self._all is None:
            n, heights = len(self._cells), self._bed.heights
            (wx, dx), (wy, dy) = (spline(self._reals[:, a]) for a in (0, 1))
            height, slope = np.zeros(n), np.zeros((n, 2))
            for i in range(3):
                for j in range(3):
                    b = heights[self._cells[:, 0] + (i - 1 + MARGIN), self._cells[:, 1] + (j - 1 + MARGIN)]
                    height += b * wx[:, i] * wy[:, j]
                    slope[:, 0] += b * dx[:, i] * wy[:, j]
                    slope[:, 1] += b * wx[:, i] * dy[:, j]
            self._all = height, slope / self._grid.dx, self._surface(self._reals)
        return self._all

    def _surface(self, reals):
        """Height of the snow's surface over the ground (n,) [m] where columns hold `reals` (n, 6)."""
        grid, surface = self._grid, np.zeros(len(self._cells))
        first, depth = depth_at_nodes(grid, self._cells, reals)
        cos2 = self._bed.cos2[tuple(slice(low, low + k) for low, k in zip(first, depth.shape, strict=True))]
        level = surface_heights(depth, cos2, grid.repeats)
        wx, wy = (spline(reals[:, a])[0] for a in (0, 1))
        columns = [grid.inner(1, self._cells[:, 1] + j - 1) - first[1] for j in range(3)]
        for i in range(3):
            row = grid.inner(0, self._cells[:, 0] + i - 1) - first[0]
            for j in range(3):
                surface += wx[:, i] * wy[:, j] * level[row, columns[j]]
        return surface

    def surface(self):
        """Height of the snow's surface over the ground (n,) [m]."""
        return self._ground()[2]

    def pull(self, plan, g):
        """Acceleration (k, 3) [m/s2] along the ground that snow at places in plan (k, 2) [m] gets from the depth of
        these columns, as a column there would (`depth.nodes`). Of a grid without periodic sides."""
        grid, bed = self._grid, self._bed
        first, depth = depth_at_nodes(grid, self._cells, self._reals)
        cos2 = bed.cos2[tuple(slice(low, low + k) for low, k in zip(first, depth.shape, strict=True))]
        level = np.pad(surface_heights(depth, cos2, grid.repeats), 1)  # zero where no column reaches
        cell, offset = grid.cells(plan)
        (wx, dx), (wy, dy) = (spline(offset[:, a]) for a in (0, 1))
        push, slope, heights = np.zeros((len(plan), 2)), np.zeros((len(plan), 2)), bed.heights
        for i in range(3):
            for j in range(3):
                node = [grid.inner(a, cell[:, a] + step - 1) for a, step in ((0, i), (1, j))]
                at = tuple((node[a] - first[a] + 1).clip(0, level.shape[a] - 1) for a in (0, 1))
                along = np.stack([dx[:, i] * wy[:, j], wx[:, i] * dy[:, j]], axis=1) / grid.dx
                push += g * level[at][:, None] * along
                under = tuple((cell[:, a] + step - 1 + MARGIN).clip(0, heights.shape[a] - 1)
                              for a, step in ((0, i), (1, j)))
                slope += heights[under][:, None] * along
        gained = slope * ((slope * push).sum(axis=1) / (1.0 + (slope**2).sum(axis=1)))[:, None] - push
        return np.column_stack([gained, (gained * slope).sum(axis=1)])

    def column(self, name):
        """(n, size), float64: velocity (3) [m/s] along the ground, volume [m3], depth [m], volume_ratio 1, and what a
        `column_load.ColumnLoad` has; zeros for what columns have none of."""
        n = len(self._cells)
        if name == "velocity":
            plan = self._reals[:, 2:4]
            return np.column_stack([plan, (plan * self._ground()[1]).sum(axis=1)])
        if name == "volume_ratio":
            return np.ones((n, 1))
        if name in self._of_load:
            metric = np.sqrt(1.0 + (self._ground()[1] ** 2).sum(axis=1))
            return self._load(self.labels[:, 0], self.thickness(), metric)[:, self._of_load[name]]
        if name in EMPTY:
            return np.zeros((n, EMPTY[name]))
        return self._reals[:, [PLACES[name]]]

    def thickness(self):
        """Of the snow where each column is, normal to the ground (n,) [m], from where all columns are now."""
        _, slope, surface = self._ground()
        return surface * np.sqrt(1.0 + (slope**2).sum(axis=1))

    def depth(self):
        """The same as of the last step."""
        return self._reals[:, 5]

    def plan(self):
        """Places in plan (n, 2) [m]."""
        return self._grid.plan(self._cells, self._reals[:, :2])

    def positions(self):
        """Scene coordinates [m] (n, 3): on the ground in plan, half of the snow's surface above it. With these, the
        potential energy of all columns is that of what they do to each other as well."""
        height, _, surface = self._ground()
        return np.column_stack([self.plan(), height + 0.5 * surface])


def depth_at_nodes(grid, cells, reals):
    """First node (2,) of the part of the grid, whole along repeated axes, that holds all columns and two nodes more on
    all sides, and H_i [m] in it, from cells (n, 2) and reals (n, 6) of columns."""
    (wx, _), (wy, _) = (spline(reals[:, a]) for a in (0, 1))
    first = np.where(grid.repeats, 0, cells.min(axis=0, initial=grid.shape.max()) - 3).clip(0, grid.shape - 1)
    last = np.where(grid.repeats, grid.shape, cells.max(axis=0, initial=0) + 4).clip(first + 1, grid.shape)
    nx, ny = last - first
    total = np.zeros(nx * ny)
    for i in range(3):
        row = (grid.inner(0, cells[:, 0] + i - 1) - first[0]) * ny
        for j in range(3):
            node = row + grid.inner(1, cells[:, 1] + j - 1) - first[1]
            total += np.bincount(node, reals[:, 4] * wx[:, i] * wy[:, j], nx * ny)
    return first, total.reshape(nx, ny) / grid.dx**2
