"""The snow in the cells of a flow by finite volumes, as the program reads particles."""

import numpy as np

from snowmpm.annotations import derived
from snowmpm.compiler.runtime import DTYPES
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.snapshot import EMPTY, spline
from snowmpm.depth.volumes.arrays import GROUND
from snowmpm.depth.volumes.plan_sums import plan_sums
from snowmpm.particles.contract import Particles
from snowmpm.particles.material_table import MaterialTable
from snowmpm.particles.snapshot_probe import SnapshotProbe

SIZES = {"velocity": 2, "volume": 1, "depth": 1}
"""Numbers of a cell that is read."""

LEAST = 1e-7
"""Depth [m] from which a cell is read as snow; what is thinner counts in the totals alone."""


class FlowCells(Particles):
    """state_array (nx + 2 MARGIN, ny + 2 MARGIN, 3): volume over plan H [m], velocity in plan [m/s]; ground (..., 6) as
    of `kernels.GROUND`; heights (...) of the ground under the middles of the cells [m]. later: pairs of a time [s] and
    H (nx, ny) of snow that lies still until then, and does not touch what flows over it."""

    def __init__(self, population, laws, grid, precision):
        """Of a `Population`; the solver fills in the ground."""
        self.grid, self.precision = grid, precision
        shape, real = tuple(grid.shape + 2 * MARGIN), DTYPES[precision][1]
        self.ground, self.heights = np.zeros((*shape, GROUND), real), np.zeros(0)
        self.materials = MaterialTable(laws, precision)
        self.density = float(self.materials.density[population.material[0]]) if len(population.volumes) else 1.0
        self.material = int(population.material[0]) if len(population.volumes) else 0
        self.state_array = np.zeros((*shape, 3), real)
        self.repeats, self.constants, self.sorts = np.append(grid.repeats, False), {}, 0
        self.removed = {"count": 0, "mass": 0.0, "taken": 0.0, "energy": 0.0, "entrained": 0.0, "laid": 0.0,
                        "momentum": np.zeros(3), "carried": 0.0}
        self.laid_in_plan = []
        """Functions of components: (lower, cell, shape) -> volume [m3] that became ground over plan cells, or None"""
        self.later = [(float(time), self._spread(population, population.starts == time)[..., 0])
                      for time in np.unique(population.starts[population.starts > 0.0])]
        self.inner(self.state_array)[:] = self._spread(population, population.starts <= 0.0)
        self.everywhere()
        # Cells are numbered by their place, whether there is snow in them or not
        self.bodies = np.zeros(int(grid.shape.prod()), int)
        self._seen = None

    def _spread(self, population, chosen):
        """H and velocity (nx, ny, 3) of a part of the population, spread by the spline, so that where particles lie
        within cells does not show, over the cells that hold some: no snow begins beyond the release. What the spline
        would give to others stays in its cell, so that an even layer is even to its edges."""
        grid = self.grid
        cell, offset = grid.cells(population.positions[chosen, :2])
        cell = np.column_stack([grid.inner(axis, cell[:, axis]) for axis in (0, 1)])
        held, found = np.zeros(grid.shape, bool), np.zeros((int(grid.shape.prod()), 3))
        held[tuple(cell.T)] = True
        own = np.ravel_multi_index(tuple(cell.T), tuple(grid.shape))
        (wx, _), (wy, _) = (spline(offset[:, axis]) for axis in (0, 1))
        places, shares = [], []
        for i, j in np.ndindex(3, 3):
            at = grid.inner(0, cell[:, 0] + i - 1), grid.inner(1, cell[:, 1] + j - 1)
            places.append(np.ravel_multi_index(at, tuple(grid.shape)))
            shares.append(wx[:, i] * wy[:, j] * held[at])
        places, shares = [*places, own], [*shares, 1.0 - np.sum(shares, axis=0)]
        volume = population.volumes[chosen] * shares
        values = np.ones(len(cell)), *population.velocities[chosen, :2].T
        for k, value in enumerate(values):
            found[:, k] = np.bincount(np.concatenate(places), (volume * value).ravel(), len(found))
        found[:, 1:] /= np.maximum(found[:, :1], 1e-30)
        found[:, 0] /= grid.dx**2
        return found.reshape(*grid.shape, 3)

    def find_origins(self):
        """Where the snow of each cell was, once the ground is known. Snow that is found where there was none came from
        somewhere: that is taken to be the highest place of the release."""
        self.origins = np.column_stack([self.grid.places().reshape(-1, 2), self.inner(self.heights).ravel()])
        self.everywhere()
        wet = (self._all_depth() > LEAST).ravel()
        if wet.any():
            self.origins[~wet] = self.origins[wet][self.origins[wet, 2].argmax()]

    def everywhere(self):
        """Snow may be in any cell. The solver narrows `box`, slices (2,) of the cells that may hold some."""
        self.box = tuple(slice(0, n) for n in self.grid.shape.tolist())

    def _all_depth(self):
        """H in the cells of `box` of the snow that flows and of that which lies still, float64."""
        if self.later:
            self.everywhere()
        return sum((H for _, H in self.later), self.inner(self.state_array)[self.box][..., 0].astype(float))

    def release(self, time):
        """Let snow go whose time has come; -> whether there was some."""
        gone = [H for start, H in self.later if start <= time + 1e-9 * max(1.0, time)]
        self.later = self.later[len(gone) :]
        for H in gone:
            inner = self.inner(self.state_array)
            before = inner[..., 0].astype(float)
            inner[..., 1:] *= (before / np.maximum(before + H, 1e-30))[..., None]
            inner[..., 0] = before + H
        return bool(gone)

    def lay(self, mass, momentum, energy):
        """Count snow that was laid down in a step: mass [kg], momentum (3,) [kg m/s] and energy [J]."""
        self.changed()
        self.removed["laid"] += mass
        self.removed["momentum"] = self.removed["momentum"] + momentum
        self.removed["energy"] += energy

    @staticmethod
    def inner(array):
        """The part of an array (nx + 2 MARGIN, ny + 2 MARGIN, ...) within the sides."""
        return array[MARGIN:-MARGIN, MARGIN:-MARGIN]

    def changed(self):
        """To be called when the snow has moved."""
        self._seen = None

    @derived
    def count(self):
        """Cells with snow."""
        return int(np.count_nonzero(self._all_depth() > LEAST))

    @derived
    def mass(self):
        """Of all snow [kg]."""
        still = sum(float(H.sum()) for _, H in self.later)
        # Of all cells: a sum over the box would depend on when it was last narrowed, and a resumed run on that
        return (still + float(self.inner(self.state_array)[..., 0].sum(dtype=float))) * self.grid.dx**2 * self.density

    @property
    def sizes(self):
        """Numbers that a cell carries."""
        return SIZES

    @property
    def number_bytes(self):
        """Bytes of a number."""
        return self.state_array.itemsize

    @property
    def bytes_per_particle(self):
        """Memory of a cell."""
        return 26.0 * self.number_bytes

    @property
    def n_blocks(self):
        """Tiles that hold snow."""
        wet = np.argwhere(self.inner(self.state_array)[..., 0] > LEAST) // 8
        return len(np.unique(wet, axis=0))

    def snapshot(self):
        """`CellSnapshot` of the cells with snow as they are now; the same one until they change."""
        if self._seen is None:
            self._seen = CellSnapshot(self, self._all_depth())
        return self._seen

    def column(self, name):
        """Copy of one column (n, size), as `CellSnapshot.column` has it."""
        return self.snapshot().column(name)

    def positions(self):
        """Scene coordinates [m] (n, 3), at half the depth."""
        return self.snapshot().positions()

    def probe(self, chosen, total):
        """`SnapshotProbe` of the cells with the numbers `chosen` (k,) of `total`."""
        return SnapshotProbe(self, chosen)

    def masses(self):
        """Mass of each cell with snow (n,) [kg]."""
        return self.snapshot().column("volume")[:, 0] * self.density

    def momentum(self):
        """Of all snow that flows (3,) [kg m/s]."""
        H, u, v = (self.inner(self.state_array)[..., k].astype(float) for k in range(3))  # all cells: see `mass`
        slope = self.inner(self.ground)
        unit = self.density * self.grid.dx**2
        return unit * np.array([(H * u).sum(), (H * v).sum(), (H * (u * slope[..., 0] + v * slope[..., 1])).sum()])

    def sums_in_plan(self, lower, cell, shape):
        """Sums over plan cells (`particles.contract.Particles`), each cell spread evenly over those it covers."""
        return plan_sums(self, self.state_array, LEAST, lower, cell, shape)

    def resting_in_plan(self, lower, cell, shape):
        """Volume of snow that waits, and of what was laid down (`particles.contract.Particles`)."""
        parts = [found for of in self.laid_in_plan if (found := of(lower, cell, shape)) is not None]
        volume = sum(parts[1:], parts[0]) if parts else None
        if self.later:
            volume = np.zeros(shape) if volume is None else volume
            self.everywhere()
            still = np.zeros(self.state_array.shape)
            self.inner(still)[..., 0] = sum(H for _, H in self.later)
            window, sums = plan_sums(self, still, 0.0, lower, cell, shape)
            volume[window] += sums[..., 0]
        return volume

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All cells, by name."""
        return {"cells": self.state_array.copy(), "removed": {**self.removed}, "sorts": self.sorts,
                "to_come": len(self.later)}

    def restore(self, state):
        """Take over a `state()`."""
        self.state_array[:] = state["cells"]
        self.removed = {**state["removed"], "momentum": np.array(state["removed"]["momentum"])}
        self.sorts, self.later = state["sorts"], self.later[len(self.later) - int(state["to_come"]) :]
        self.everywhere()
        self.changed()


class CellSnapshot:
    """Cells with snow at one moment. labels (n, 2): index of the material, and number of the cell, which it keeps;
    cells (n, 2) in plan."""

    def __init__(self, store, depth):
        """depth: H in the cells of the box of the store, of which what lies still slows the mean of the cell down."""
        inner = store.inner(store.state_array)
        within = np.nonzero(depth > LEAST)
        at = tuple(one + part.start for one, part in zip(within, store.box, strict=True))
        self.cells = np.column_stack(at)
        self._values, self._ground = inner[at].astype(float), store.inner(store.ground)[at].astype(float)
        self._values[:, 1:] *= (self._values[:, 0] / depth[within])[:, None]
        self._values[:, 0] = depth[within]
        self._heights, self._grid = store.inner(store.heights)[at], store.grid
        number = np.ravel_multi_index(at, tuple(store.grid.shape)) if len(self.cells) else np.zeros(0, int)
        self.labels = np.column_stack([np.full(len(number), store.material), number])

    def column(self, name):
        """(n, size), float64: velocity (3) [m/s] along the ground, volume [m3], depth normal to the ground [m],
        volume_ratio 1; zeros for what cells have none of."""
        n = len(self.cells)
        if name == "velocity":
            plan = self._values[:, 1:]
            return np.column_stack([plan, (plan * self._ground[:, :2]).sum(axis=1)])
        if name == "volume_ratio":
            return np.ones((n, 1))
        if name in EMPTY:
            return np.zeros((n, EMPTY[name]))
        return {"volume": self._values[:, :1] * self._grid.dx**2,
                "depth": self._values[:, :1] * self._ground[:, 5:]}[name]

    def depth(self):
        """Thickness normal to the ground (n,) [m]."""
        return self.column("depth")[:, 0]

    thickness = depth

    def plan(self):
        """Places in plan (n, 2) [m]: the middles of the cells."""
        return self._grid.plan(self.cells, 0.0)

    def positions(self):
        """Scene coordinates [m] (n, 3): half of the snow's surface above the ground."""
        surface = self._values[:, 0] * self._ground[:, 5] ** 2
        return np.column_stack([self.plan(), self._heights + 0.5 * surface])
