"""The columns of snow of a depth-averaged flow."""

import numpy as np
from scipy.ndimage import maximum_filter

from snowmpm.annotations import derived
from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.runtime import DTYPES
from snowmpm.depth.arrays import ColumnArrays
from snowmpm.depth.plan_sums import plan_sums
from snowmpm.depth.snapshot import REACH, ColumnSnapshot
from snowmpm.particles.contract import Particles
from snowmpm.particles.material_table import MaterialTable
from snowmpm.particles.snapshot_probe import SnapshotProbe

SIZES = {"position": 2, "velocity": 2, "volume": 1, "depth": 1, "climb": 1, "intake": 1}
"""Numbers of a column: offset from the node of its cell [cells], velocity in plan [m/s], volume [m3], thickness of the
snow where it is, normal to the ground [m], vertical speed of the last step [m/s], and the snow
cover that it would take up [kg/s]."""

OFFSETS = {"position": 0, "velocity": 2, "volume": 4, "depth": 5, "climb": 6, "intake": 7}

FEW = 20
"""Cells from which columns leave in a step, up to which all others are compared with each."""


class Columns(Particles):
    """Columns in rows that keep their order until some leave. cells (n, 2): cell in plan; reals (n, 8): `SIZES`;
    material, identity (n,): index of the material, number for life. starts (n,): when each may move [s], in rising
    order; flowing: how many may, the first rows. The others lie still: they press on their neighbours, and the ground
    holds them. guests: rows behind all others, of snow that another method holds: they press on the columns in the next
    step, and count in nothing. density (materials,): of snow with all that columns hold [kg/m3]; load:
    `column_load.ColumnLoad`, or None."""

    def __init__(self, population, laws, grid, bed, precision, load=None):
        self.grid, self.bed, self.precision = grid, bed, precision
        self.materials = MaterialTable(laws, precision)
        self.density, self.load, self.constants = self.materials.density, load, {}
        if load:
            self.materials.density, self.density = load.densities(self.density)
        self.count = len(population.volumes)
        self.repeats = np.append(grid.repeats, False)
        order = np.argsort(population.starts, kind="stable")
        self.starts = population.starts[order]
        self.flowing = int(np.searchsorted(self.starts, 0.0, side="right"))
        cell, offset = grid.cells(population.positions[order, :2])
        reals = np.zeros((self.count, sum(SIZES.values())))
        reals[:, :2], reals[:, 2:4] = offset, population.velocities[order, :2]
        reals[:, 4] = population.volumes[order]
        self.densities = real_array(self.density)
        self._fill(cell, reals, population.material[order], order)
        if load:
            load.fill(self, cell, population.material[order])
        if self.count:
            now = self.snapshot()
            reals[:, OFFSETS["climb"]], reals[:, OFFSETS["depth"]] = now.column("velocity")[:, 2], now.thickness()
            self.reals.from_numpy(reals.astype(DTYPES[precision][1]))
            self.changed()
        self.mass = float(self.masses().sum())
        self.removed = {"count": 0, "mass": 0.0, "taken": 0.0, "energy": 0.0, "entrained": 0.0,
                        "laid": 0.0, "momentum": np.zeros(3), "carried": 0.0}
        self.sorts = 0
        self.laid_in_plan = []
        """Functions of components: (lower, cell, shape) -> volume [m3] that became ground over plan cells, or None"""

    @property
    def arrays(self):
        """What kernels take of them."""
        return ColumnArrays(self.cells, self.reals, self.material, self.densities)

    def _fill(self, cells, reals, material, identity, guests=0):
        real, numpy_real = DTYPES[self.precision]
        self.count, self.guests, self._seen = len(reals) - guests, guests, None
        self.material, self.identity = int_array(material), int_array(identity)
        self.cells = ti.Vector.ndarray(2, ti.i32, max(1, len(reals)))
        self.reals = ti.Vector.ndarray(sum(SIZES.values()), real, max(1, len(reals)))
        if len(reals):
            self.cells.from_numpy(np.ascontiguousarray(cells, np.int32))
            self.reals.from_numpy(np.ascontiguousarray(reals, numpy_real))

    @derived
    def waiting(self):
        """Columns that may not move yet, the last ones."""
        return self.count - self.flowing

    @property
    def rows(self):
        """Columns and guests."""
        return self.count + self.guests

    def _rows_of(self, population):
        """Cells (n, 2), numbers (n, 8) and materials (n,) of a `Population`."""
        cell, offset = self.grid.cells(population.positions[:, :2])
        reals = np.zeros((len(cell), sum(SIZES.values())))
        reals[:, :2], reals[:, 2:4] = offset, population.velocities[:, :2]
        reals[:, OFFSETS["volume"]] = population.volumes
        return cell, reals, population.material

    def add(self, population, numbers):
        """Take in a `Population` with numbers (n,) that no column has yet, before those that wait."""
        cell, reals, material = self._rows_of(population)
        at, labels, own = self.flowing, self._labels(), (self.cells.to_numpy()[: self.count], self._table())
        begun = self.starts[at - 1] if at else 0.0
        self.starts = np.insert(self.starts, at, np.full(len(cell), begun))
        self.flowing += len(cell)
        columns = [np.concatenate([old[:at], new, old[at:]])
                   for old, new in zip((*own, *labels.T), (cell, reals, material, numbers), strict=True)]
        self._fill(*columns)
        now = self.snapshot()
        new = slice(at, at + len(cell))
        columns[1][new, OFFSETS["climb"]] = now.column("velocity")[new, 2]
        columns[1][new, OFFSETS["depth"]] = now.thickness()[new]
        self._fill(*columns)
        self.mass += float(population.volumes @ self.density[population.material])
        self.sorts += 1

    def invite(self, population):
        """Let a `Population` press on the columns as guests, in place of those before."""
        if not self.guests and not len(population.volumes):
            return
        own = self.cells.to_numpy()[: self.count], self._table(), *self._labels().T
        cell, reals, material = self._rows_of(population)
        cells, numbers, materials, identity = (np.concatenate(pair) for pair in zip(
            own, (cell, reals, material, np.full(len(cell), -1)), strict=True))
        self._fill(cells, numbers, materials, identity, guests=len(cell))

    def take(self, keep, gravity, taken=False, laid=False):
        """Keep the columns with keep (n,) true; the others count as removed, as `taken` those that did not leave, as
        `laid` those that have laid down all of their snow."""
        keep = np.asarray(keep, bool)
        gone = np.flatnonzero(~keep)
        near = self._around(gone)
        part, lost = ColumnSnapshot(self, near), np.isin(near, gone, assume_unique=True)
        self.starts, self.flowing = self.starts[keep], int(keep[: self.flowing].sum())
        masses = self.masses()
        mass, velocity, positions = masses[gone], part.column("velocity")[lost], part.positions()[lost]
        removed = self.removed
        if not laid:
            removed["count"] += len(gone)
        removed["laid" if laid else "mass"] += float(mass.sum())
        removed["taken"] += float(mass.sum()) if taken else 0.0
        removed["momentum"] = removed["momentum"] + mass @ velocity
        if self.load:
            if not laid:
                held = part.column(self.load.mass_column)[lost, 0]
                removed["carried"] += float(part.column("volume")[lost, 0] @ held)
            self.load.take(keep)
        removed["energy"] += float(mass @ (0.5 * (velocity**2).sum(axis=1) - positions @ gravity))
        # The potential is one of pairs: the snow that stays lies lower without its neighbours (see `positions`)
        removed["energy"] += -0.5 * gravity[2] * float(masses[near[~lost]] @ part.surface_of(lost)[~lost])
        self.mass -= float(mass.sum())
        labels = self._labels()[keep]
        self._fill(self.cells.to_numpy()[: self.count][keep], self._table()[keep], labels[:, 0], labels[:, 1])
        self.sorts += 1

    def _labels(self):
        """Index of the material and number of each (n, 2)."""
        return np.stack([self.material.to_numpy(), self.identity.to_numpy()], axis=1)[: self.count]

    def _around(self, gone):
        """Rows of the columns that the columns `gone` (k,) feel, in rising order."""
        if self.grid.repeats.any() or not 0 < 4 * len(gone) < self.count:
            return np.arange(self.count)
        cells = self.cells.to_numpy()[: self.count]
        places = np.unique(cells[gone], axis=0)
        if len(places) > FEW:
            window = np.zeros(np.ptp(cells, axis=0) + 1, bool)
            window[tuple((places - cells.min(axis=0)).T)] = True
            return np.flatnonzero(maximum_filter(window, 2 * REACH + 1)[tuple((cells - cells.min(axis=0)).T)])
        x, y = np.ascontiguousarray(cells.T)
        near = np.zeros(self.count, bool)
        for i, j in places:
            near |= (np.abs(x - i) <= REACH) & (np.abs(y - j) <= REACH)
        return np.flatnonzero(near)

    def release(self, time):
        """Let columns go whose start has come by `time` [s]; -> whether there were any."""
        before, slack = self.flowing, 1e-9 * max(1.0, time)
        if before < self.count and self.starts[before] <= time + slack:
            self.flowing = int(np.searchsorted(self.starts, time + slack, side="right"))
        return self.flowing > before

    def gain(self, mass, height, gravity):
        """Count snow cover that was taken up: its mass [kg], and its sum of mass times height [kg m]."""
        self.mass += mass
        self.removed["entrained"] += mass
        self.removed["energy"] += height * gravity[2]

    def lay(self, mass, momentum, energy):
        """Count snow that was laid down in a step, and taken from the columns: mass [kg], momentum (3,) [kg m/s] and
        energy [J]."""
        self.changed()
        self.mass -= mass
        self.removed["laid"] += mass
        self.removed["momentum"] = self.removed["momentum"] + momentum
        self.removed["energy"] += energy

    def _table(self):
        return self.reals.to_numpy()[: self.count]

    def masses(self):
        """Mass of each [kg]."""
        return self._table()[:, OFFSETS["volume"]].astype(float) * self.density[
            self.material.to_numpy()[: self.count]]

    def momentum(self):
        """Of all columns (3,) [kg m/s]."""
        return self.masses() @ self.column("velocity") if self.count else np.zeros(3)

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def sizes(self):
        """Numbers that a column carries."""
        return {**SIZES, **(self.load.sizes if self.load else {})}

    @property
    def number_bytes(self):
        """Bytes of a number."""
        return np.dtype(DTYPES[self.precision][1]).itemsize

    @property
    def bytes_per_particle(self):
        """Memory of a column."""
        return sum(SIZES.values()) * self.number_bytes + 16.0 + (self.load.bytes_per_column if self.load else 0.0)

    @property
    def n_blocks(self):
        """Tiles of the plan grid that hold columns."""
        cells = self.cells.to_numpy()[: self.count] // 8
        return len(np.unique(cells[:, 0].astype(np.int64) << 32 | cells[:, 1])) if self.count else 0

    def snapshot(self):
        """`ColumnSnapshot` of all columns as they are now; the same one until they change."""
        if self._seen is None:
            self._seen = ColumnSnapshot(self)
        return self._seen

    def changed(self):
        """To be called when kernels have moved the columns: what was read of them is of before."""
        self._seen = None

    def column(self, name):
        """Copy of one column of numbers (n, size), as `ColumnSnapshot.column` has it."""
        return self.snapshot().column(name)

    def positions(self):
        """Scene coordinates [m] (n, 3), at half the depth."""
        return self.snapshot().positions()

    def probe(self, chosen, total):
        """`SnapshotProbe` of the columns with the numbers `chosen` (k,) of `total`."""
        return SnapshotProbe(self, chosen)

    def sums_in_plan(self, lower, cell, shape):
        """Sums over plan cells (`particles.contract.Particles`), each column spread like the spline of its cell."""
        return plan_sums(self, lower, cell, shape, (0, self.flowing))

    def resting_in_plan(self, lower, cell, shape):
        """Volume of columns that wait, and of what was laid down (`particles.contract.Particles`)."""
        parts = [found for of in self.laid_in_plan if (found := of(lower, cell, shape)) is not None]
        laid = sum(parts[1:], parts[0]) if parts else None
        if self.flowing == self.count:
            return laid
        volume = np.zeros(shape) if laid is None else laid
        window, sums = plan_sums(self, lower, cell, shape, (self.flowing, self.count))
        volume[window] += sums[..., 0]
        return volume

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All columns, by name."""
        return {"cells": self.cells.to_numpy()[: self.count], "reals": self._table(),
                "labels": self.snapshot().labels, "removed": {**self.removed}, "mass": self.mass, "sorts": self.sorts,
                "starts": self.starts, "flowing": self.flowing}

    def restore(self, state):
        """Take over a `state()`."""
        self._fill(state["cells"], state["reals"], state["labels"][:, 0], state["labels"][:, 1])
        self.removed = {"carried": 0.0, **state["removed"], "momentum": np.array(state["removed"]["momentum"])}
        self.mass, self.sorts = state["mass"], state["sorts"]
        self.starts = np.array(state["starts"], float)
        self.flowing = int(state["flowing"])
