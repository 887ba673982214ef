"""The particles of a simulation in the order of the blocks that own them; what left is accounted for."""

from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.arrays import Rows, int_array, real_array
from snowmpm.compiler.parallel import chunk_bounds
from snowmpm.errors import InputError
from snowmpm.particles.arrays import BlockRows, ParticleArrays
from snowmpm.particles.blocks import EDGE, LEAD, BlockMap, fields_of, sort_kernels
from snowmpm.particles.contract import Particles
from snowmpm.particles.material_table import MaterialTable
from snowmpm.particles.plan_sums import plan_sums
from snowmpm.particles.probe import Probe
from snowmpm.particles.pushing import push_kernel
from snowmpm.particles.severing import Cut, sever_kernel
from snowmpm.particles.snapshot import Snapshot
from snowmpm.particles.store import IDENTITY, MATERIAL, Layout, ParticleStore

BLOCK_COST = 8
"""Cost of a block beside that of its particles, in particles: clearing its tile, and its share of cache misses."""

ROUND_OFF = 1e-3
"""Cells by which a particle may seem to be beyond its limit."""


class Sorting(NamedTuple):
    """drift_limit: `Stencil.drift_limit`; second_moment: D [m2] of the affine transfer, for the kinetic energy of those
    that leave; keep_block_of: whether the block of each particle is kept."""

    drift_limit: float
    second_moment: float = 0.0
    keep_block_of: bool = False


class SortedParticles(ParticleStore, Particles):
    """A particle store whose rows follow the blocks of `blocks` (`BlockMap`), and its materials.

    Lengths inside are cells of dx from `origin` (scene coordinates of grid node 0). start (blocks + 1,), coordinates
    (blocks, dim), shares (workers + 1,): the map and its cut into chunks of about equal work, for kernels; block_of
    (n,): the block of each particle, kept only when asked for. drift: the way [cells] of the particle that went
    furthest since the last sort. mass [kg] of all particles; removed: count, mass [kg], momentum [kg m/s] and energy
    [J] (kinetic, elastic and -m g.x, but for periodic axes) of those that are gone, and `taken`, the mass [kg] of those
    that did not leave the domain but were taken out. repeats (dim,): whether the domain is periodic along each axis.
    moved: block before and block now of every group of particles at the last sort or removal, two arrays; None when the
    blocks are those of the start or of a checkpoint.
    """

    def __init__(self, population, laws, frame, gravity, sorting, period=None, carried=None):
        """frame: `Frame`; sorting: `Sorting`; period: `BlockMap`'s; carried: columns of components, (name, numbers),
        zero where the population has none of that name, mass_column and still_column, as `Layout` takes them."""
        self.dim, self.dx, self.origin = frame.dim, frame.dx, frame.origin
        carried = carried or {"columns": (), "mass_column": "", "still_column": ""}
        dx, precision = frame.dx, frame.precision
        self.materials = MaterialTable(laws, precision)
        self._drift_limit, self._second_moment, self._keep_block_of = sorting
        self._period = np.zeros(self.dim, np.int64) if period is None else period
        self._limits = frame.limits(self._period)
        self._bounds = [real_array(limit) for limit in self._limits]
        self.repeats = self._period > 0
        self._gravity = np.where(self.repeats, 0.0, gravity)
        cells = (population.positions - self.origin) / dx
        blocks, order, local = BlockMap.from_cells(cells, self.dim, self._period, population.field)
        layout = Layout(self.dim, self.materials.state_size, not runtime.fine_grained(), tuple(carried["columns"]),
                        carried["mass_column"], carried["still_column"]).fitting(len(order), precision)
        self._refuse_more(layout, len(order))
        super().__init__(layout, len(order), precision)
        self.fill(self._columns(population, order, local), population.material[order], order)
        self.mass = self._mass_of(population)
        self.removed = {"count": 0, "mass": 0.0, "taken": 0.0, "carried": 0.0, "energy": 0.0,
                        "momentum": np.zeros(self.dim)}
        self.constants = {}
        self.sorts = 0
        self._count_moves, self._aim = sort_kernels(layout)
        self._counts, self._first_rows = Rows(), Rows()
        self._rebuild_for(blocks)

    @staticmethod
    def _refuse_more(layout, count):
        """InputError for more particles than there are numbers for."""
        if count > layout.most_particles:
            raise InputError(f"{count:,} particles: at most {layout.most_particles:,} of {layout.width} numbers "
                             "fit the 32-bit indices of Taichi's arrays; choose a larger solver.dx or fewer particles")

    def _columns(self, population, order, local):
        """Columns of the table {name: (n, size)} of a `Population`'s rows `order`; local: relative to their blocks."""
        columns = {"position": local, "velocity": population.velocities[order], "volume": population.volumes[order],
                   "volume_ratio": population.volume_ratio[order], "state": self.materials.state_of(population, order),
                   "affine": population.affine[order],
                   "elastic": population.elastic[order], "stress": population.stress[order]}
        columns |= {name: population.columns[name][order] for name, _ in self.layout.more if name in population.columns}
        return columns

    def _mass_of(self, population):
        """[kg]"""
        mass = float((population.volumes * self.materials.density[population.material]).sum())
        if name := self.layout.mass_column:
            mass += float((population.volumes * population.columns[name][:, 0]).sum())
        return mass

    def _rebuild_for(self, blocks, drift=0.0, moved=None):
        self.blocks, self.drift, self.moved = blocks, drift, moved
        self.start, self.coordinates = int_array(blocks.start), int_array(blocks.coordinates)
        self.chunk_bounds = int_array(chunk_bounds(np.diff(blocks.start) + BLOCK_COST))
        if self._keep_block_of:
            self.block_of = int_array(np.repeat(np.arange(len(blocks)), np.diff(blocks.start)))

    @property
    def arrays(self):
        """What kernels take of the particles and their materials."""
        return ParticleArrays(self.reals, self.slot_offset, self.material, self.materials.numbers,
                              self.materials.law_of)

    @property
    def block_rows(self):
        """What kernels take of them by blocks."""
        return BlockRows(self.reals, self.slot_offset, self.start, self.coordinates)

    def weightless(self):
        """Leave the potential energy out of what is removed: gravity changes, and its work is added up elsewhere."""
        self._gravity = np.zeros(self.dim)

    # ---- who is where -------------------------------------------------------------------------------------------

    @property
    def strayed(self):
        """Whether some particle may be out of reach of its block's tile, so that they must be sorted."""
        return self.drift >= self._drift_limit

    def sort(self, speed):
        """Bring every particle to its block; those outside the limits are removed and counted.

        speed: of the fastest one [m/s], which is sorted furthest ahead of itself (`LEAD`).
        """
        blocks = self.blocks
        counts = self._counts.filled(np.zeros((len(blocks), 3**self.dim), np.int32))
        lead = LEAD * self._drift_limit
        ahead = lead / max(speed, 1e-30)
        self._count_moves(self.block_rows, *self._bounds, ahead, lead, counts, self.target, self.chunk_bounds)
        counts = counts.to_numpy()[: len(blocks)]
        alive = int(counts.sum())
        if alive < self.count:
            cells = (self.positions() - self.origin) / self.dx
            self._tally_removed(~((cells >= self._limits[0]) & (cells < self._limits[1])).all(axis=1))
        used = counts > 0
        keys, block_of_move = np.unique(blocks.neighbours()[used], return_inverse=True)
        order = np.argsort(block_of_move, kind="stable")
        sizes = counts[used]
        first = np.empty(len(sizes), np.int64)
        first[order] = np.cumsum(sizes[order]) - sizes[order]
        target = np.zeros(counts.shape, np.int64)
        target[used] = first
        self._aim(self.block_rows, self._first_rows.filled(target), self.target, self.chunk_bounds)
        self.move(alive)
        self._rebuild_for(BlockMap(keys, np.bincount(block_of_move, sizes, len(keys)).astype(np.int64), self.dim,
                                   self._period), moved=(np.nonzero(used)[0], block_of_move))
        self.sorts += 1

    def place(self, cells, columns):
        """Move particles anywhere, and sort them: cells (n, dim) from the origin; columns {name: (n, size)} that change
        too. Those outside the limits are removed and counted."""
        table = self.table()
        block = np.repeat(self.blocks.coordinates, np.diff(self.blocks.start), axis=0)
        for name, values in {"position": cells - EDGE[self.dim] * block, **columns}.items():
            table[:, self.layout.columns(name)] = np.reshape(values, (len(table), self.layout.sizes[name]))
        self.overwrite(table)
        keep = ((cells >= self._limits[0]) & (cells < self._limits[1])).all(axis=1)
        if not keep.all():
            self._tally_removed(~keep)
        blocks, order, local = BlockMap.from_cells(cells[keep], self.dim, self._period)
        table, labels = table[keep][order], self.labels()[keep][order]
        table[:, self.layout.columns("position")] = local
        self.replace(table, labels)
        self._rebuild_for(blocks)
        self.sorts += 1

    def add(self, population, numbers):
        """Take in a `Population` with numbers (n,) that no particle has yet. Those outside the
        limits are removed and counted."""
        count, table, labels = self.count, self.table(), self.labels()
        total = count + len(numbers)
        self._refuse_more(self.layout, total)
        self.make_room(total)
        rows = np.arange(len(numbers))
        columns = self._columns(population, rows, np.zeros((len(rows), self.dim)))
        added = np.zeros((len(rows), self.layout.width), self.numpy_dtype)
        for name, values in columns.items():
            added[:, self.layout.columns(name)] = np.reshape(values, (len(rows), self.layout.sizes[name]))
        block = np.repeat(self.blocks.coordinates, np.diff(self.blocks.start), axis=0)
        cells = np.concatenate([EDGE[self.dim] * block + table[:, self.layout.columns("position")].astype(float),
                                (population.positions - self.origin) / self.dx])
        field = np.concatenate([np.repeat(fields_of(self.blocks.keys, self.dim), np.diff(self.blocks.start)),
                                population.field])
        blocks, order, local = BlockMap.from_cells(cells, self.dim, self._period, field)
        table = np.concatenate([table, added])[order]
        table[:, self.layout.columns("position")] = local
        new = np.column_stack([population.material, numbers]).astype(labels.dtype)
        self.replace(table, np.concatenate([labels, new])[order])
        self.mass += self._mass_of(population)
        self._rebuild_for(blocks)
        keep = ((cells[order] >= self._limits[0]) & (cells[order] < self._limits[1])).all(axis=1)
        if not keep.all():
            taken = self.removed["taken"]
            self.remove(~keep)
            self.removed["taken"] = taken
        self.sorts += 1

    def accelerate(self, gain):
        """Add `gain` (n, dim) [m/s] to the velocities, in the order of the rows."""
        table = self.table()
        table[:, self.layout.columns("velocity")] += np.asarray(gain, self.numpy_dtype)
        self.overwrite(table)

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        keep, before = ~np.asarray(gone, bool), self.removed["mass"]
        self._tally_removed(~keep)
        self.removed["taken"] += self.removed["mass"] - before
        table, labels = self.table()[keep], self.labels()[keep]
        owner_block = np.repeat(np.arange(len(self.blocks)), np.diff(self.blocks.start))[keep]
        counts = np.bincount(owner_block, minlength=len(self.blocks))
        filled = counts > 0
        self.replace(table, labels)
        self._rebuild_for(BlockMap(self.blocks.keys[filled], counts[filled], self.dim, self._period), self.drift,
                          (np.flatnonzero(filled), np.arange(filled.sum())))

    def sever(self, line, radius, numbers, state):
        """Cut the bonds of the particles numbers[0] <= number < numbers[1] within `radius` [m] of a line in plan
        (k, dim - 1) [m]: no stress, and the law's severed `state`; -> how many."""
        real, numpy_real = runtime.DTYPES[self.precision]
        self.changes += 1
        line = np.ascontiguousarray((line - self.origin[:-1]) / self.dx, numpy_real)
        with runtime.precision(self.precision):
            hit = np.zeros(1, np.int32)
            cut = Cut(radius / self.dx, numbers[0], numbers[1], np.array(state, numpy_real))
            sever_kernel(self.layout, real)(self.block_rows, self.identity, line, cut, hit, len(self.blocks))
        return int(hit[0])

    def push(self, numbers, gain):
        """Add `gain` (dim,) [m/s] to the velocity of the particles numbers[0] <= number < numbers[1]."""
        self.changes += 1
        real, numpy_real = runtime.DTYPES[self.precision]
        with runtime.precision(self.precision):
            push_kernel(self.layout, real)(self.reals, self.slot_offset, self.identity, np.asarray(gain, numpy_real),
                                           *numbers, self.count)

    def _tally_removed(self, gone):
        removed, mass = self.removed, self.masses()[gone]
        velocity, affine = self.column("velocity")[gone], self.column("affine")[gone]
        square = (velocity**2).sum(axis=1) + self._second_moment * (affine**2).sum(axis=1)
        elastic = self.materials.elastic_energy(*(values[gone] for values in (
            self.labels()[:, MATERIAL], self.column("stress"), self.column("state"), self.column("volume")[:, 0])))
        removed["count"] += int(gone.sum())
        removed["mass"] += float(mass.sum())
        if name := self.layout.mass_column:
            removed["carried"] += float(self.column("volume")[gone, 0] @ self.column(name)[gone, 0])
        removed["momentum"] += mass @ velocity
        removed["energy"] += float(mass @ (0.5 * square - self.positions()[gone] @ self._gravity)) + elastic
        self.mass -= float(mass.sum())

    # ---- reading ------------------------------------------------------------------------------------------------

    @property
    def still_column(self):
        """Column of the snow that is no part of the flow (`Layout.still_column`)."""
        return self.layout.still_column

    @property
    def sizes(self):
        """Numbers that a particle carries, {column: how many}."""
        return dict(self.layout.sizes)

    @property
    def number_bytes(self):
        """Bytes of a number."""
        return np.dtype(self.numpy_dtype).itemsize

    @property
    def n_blocks(self):
        """Blocks that hold particles."""
        return len(self.blocks)

    def snapshot(self):
        """`Snapshot` of all particles as they are now."""
        return Snapshot(self)

    def probe(self, chosen, total):
        """`Probe` of the particles with the numbers `chosen` (k,) of `total`."""
        return Probe(self, chosen, total)

    def sums_in_plan(self, lower, cell, shape):
        """Sums over plan cells (`particles.contract.Particles`)."""
        return plan_sums(self, lower, cell, shape)

    def column(self, name):
        """Copy of one column group of the table, float64, (n, size)."""
        return self.table()[:, self.layout.columns(name)].astype(np.float64)

    def positions(self, local=None, blocks=None):
        """Scene coordinates [m], (n, dim); local: their position columns when already at hand, blocks: the `BlockMap`
        that they belong to."""
        local = self.column("position") if local is None else local
        blocks = self.blocks if blocks is None else blocks
        owner_block = np.repeat(blocks.coordinates, np.diff(blocks.start), axis=0)
        cells = EDGE[self.dim] * owner_block + local
        if not np.any(self._period):
            return self.origin + self.dx * cells
        length = EDGE[self.dim] * self._period
        return self.origin + self.dx * np.where(length > 0, cells % np.maximum(length, 1), cells)

    def masses(self):
        """Masses [kg] (per metre of width in 2-D), (n,)."""
        return self.column("volume")[:, 0] * self.densities()

    def densities(self):
        """Mass per reference volume [kg/m3], that of the mass column included, (n,)."""
        own, name = self.materials.density[self.material.to_numpy()[: self.count]], self.layout.mass_column
        return own + self.column(name)[:, 0] if name else own

    @property
    def period(self):
        """Cells after which each axis repeats, 0 where it does not, (dim,)."""
        return EDGE[self.dim] * self._period

    def describe(self, row):
        """Name and place of the particle in a row, for a message."""
        place = np.array2string(self.positions()[row], precision=3)
        return f"particle {self.labels()[row, IDENTITY]}", f"near {place} m"

    # ---- checkpoint ---------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"reals": np.ascontiguousarray(self.table()), "labels": self.labels(), "keys": self.blocks.keys,
                "start": self.blocks.start, "columns": dict(self.layout.sizes), "excursion": self.drift,
                "sorts": self.sorts, "mass": self.mass,
                "removed": {**self.removed, "momentum": self.removed["momentum"].copy()}}

    def restore(self, state):
        """Take over a `state()`. Raises InputError when it does not fit."""
        reals = state["reals"]
        if reals.shape[1:] != (self.layout.width,) or reals.dtype != self.numpy_dtype:
            raise InputError("the particles of the checkpoint carry other columns: it is from another version")
        starts = state["start"]
        if not (len(reals) == len(state["labels"]) == starts[-1] and (np.diff(starts) > 0).all()):
            raise InputError("the particles of the checkpoint are not in the order of its blocks")
        labels, keys = state["labels"], state["keys"]
        if labels.shape != (len(reals), 2) or labels.dtype.kind not in "iu" or (labels < 0).any() or (
                labels[:, MATERIAL].max(initial=0) >= len(self.materials.laws)):
            raise InputError("the particles of the checkpoint are of materials that the scene does not have")
        # Kernels go by both without looking: what lies elsewhere would be written there. Particles that strayed in the
        # last step, which crosses a cell at most, are sorted before the next one
        base, limit = reals[:, self.layout.columns("position")] - 0.5, self._drift_limit + ROUND_OFF
        limit += 1.0 if state["excursion"] >= self._drift_limit else 0.0
        near = (base >= -limit) & (base <= EDGE[self.dim] + limit)
        if not near.all() or len(keys) != len(starts) - 1 or (np.diff(keys) <= 0).any() or starts[0] != 0:
            raise InputError("the particles of the checkpoint are not in its blocks")
        self._refuse_more(self.layout, len(reals))
        self.make_room(len(reals))  # rain and laid snow may have come since time zero
        self.replace(reals, labels)
        self._rebuild_for(BlockMap(keys, np.diff(starts), self.dim, self._period), state["excursion"])
        self.sorts, self.mass = state["sorts"], state["mass"]
        self.removed = {"taken": 0.0, "carried": 0.0, **state["removed"]}
