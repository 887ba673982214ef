"""The cell sort: particles grouped by blocks of cells, and only blocks that hold some are stored.

A block is `EDGE[dim]` cells wide. A particle's owner is the block of its base node, floor(x - 1/2); its position is
kept relative to that block, so it may drift as far out of its owner as its stencil allows (`Stencil.drift_limit`: a
cell of the quadratic one, half a cell of the cubic one) before the particles must be sorted again. A sort gives fast
particles the owner that they will reach next (LEAD), which makes the next sort come half as soon. It moves a particle
at most one block, so it is a counting sort over (old block, step to a neighbour) pairs: stable, without atomics, the
same for any number of threads.
"""

import functools
import itertools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.particles.arrays import BlockRows
from snowmpm.particles.store import accessors

EDGE = {2: 8, 3: 4}
"""Cells per block edge: large enough that a block's grid tile is cheap beside its particles, small enough for a
layer a few cells thick."""

LEAD = 0.9
"""Share of its drift limit that the fastest particle is sorted ahead of itself, slower ones in proportion; 1 would
leave no drift back."""

_RADIX = 1 << 20

MOST_FIELDS = 8
"""Velocity fields at most: what is left of a 64-bit key."""


def keys_of(coordinates, field=0):
    """Sortable 64-bit key of integer block coordinates (n, dim); lexicographic, last axis fastest; field: the velocity
    field (n,) of the block, which comes first: blocks of two fields have nothing to do with each other."""
    key = np.zeros(len(coordinates), np.int64) + field
    for column in np.asarray(coordinates, np.int64).T:
        key = key * _RADIX + (column + _RADIX // 2)
    return key


def coordinates_of(keys, dim):
    """Inverse of `keys_of`."""
    columns = []
    for _ in range(dim):
        columns.append(keys % _RADIX - _RADIX // 2)
        keys = keys // _RADIX
    return np.stack(columns[::-1], axis=1)


def fields_of(keys, dim):
    """Velocity field of each key."""
    return keys // _RADIX**dim


def places_of(keys, dim):
    """Keys without their field: the same for blocks at the same place."""
    return keys % _RADIX**dim


def _within_period(coordinates, period):
    """Block coordinates (n, dim) within the period of those axes that have one."""
    if period is None:
        return coordinates
    return np.where(period > 0, coordinates % np.maximum(period, 1), coordinates)


def neighbour_steps(dim):
    """The 3^dim steps to a block's neighbours and itself, first axis slowest, (3^dim, dim)."""
    return np.array(list(itertools.product((-1, 0, 1), repeat=dim)))


def owner_block(cells, edge):
    """Block of the base node of positions in cells (n, dim), and positions relative to it."""
    block = np.floor_divide(np.floor(cells - 0.5).astype(np.int64), edge)
    return block, cells - edge * block


class BlockMap:
    """Occupied blocks in key order: `keys` (n,), `coordinates` (n, dim), first particle of each `start` (n + 1,).

    period: (dim,) number of blocks after which they repeat along each axis, 0 where they do not; None for none.
    """

    def __init__(self, keys, counts, dim, period=None):
        self.dim = dim
        self.period = None if period is None or not np.any(period) else np.asarray(period, np.int64)
        self.keys = keys
        self.coordinates = coordinates_of(keys, dim)
        self.start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)

    def __len__(self):
        return len(self.keys)

    def keys_of(self, coordinates, field):
        """Keys of block coordinates (n, dim), taken into the period where the domain is periodic, of fields (n,)."""
        return keys_of(_within_period(coordinates, self.period), field)

    @classmethod
    def from_cells(cls, cells, dim, period=None, field=0):
        """Group positions [cells] (n, dim) of velocity fields (n,): -> map, order of the particles, positions relative
        to their blocks."""
        block, local = owner_block(cells, EDGE[dim])
        keys = keys_of(_within_period(block, period), field)
        order = np.argsort(keys, kind="stable")
        unique, counts = np.unique(keys, return_counts=True)
        return cls(unique, counts, dim, period), order, local[order]

    def find(self, coordinates):
        """Number of the block at each of the coordinates (n, dim), of velocity field 0, and whether there is one."""
        keys = self.keys_of(coordinates, 0)
        number = np.minimum(np.searchsorted(self.keys, keys), max(0, len(self.keys) - 1))
        return number, (self.keys[number] == keys) if len(self.keys) else np.zeros(len(keys), bool)

    def keys_beside(self, keys, axis, step):
        """Keys of the blocks `step` along an axis from those of `keys` (n,)."""
        if self.period is None or not self.period[axis]:
            return keys + step * _RADIX ** (self.dim - 1 - axis)
        coordinates = coordinates_of(keys, self.dim)
        coordinates[:, axis] += step
        return self.keys_of(coordinates, fields_of(keys, self.dim))

    def neighbours(self):
        """Keys of the 3^dim blocks around each occupied block, (n, 3^dim)."""
        return self._around().T

    def _around(self):
        """Keys of the blocks one step away, a row for each of `neighbour_steps`, (3^dim, n)."""
        if self.period is None:
            # A sorted run for each step
            return self._key_steps()[:, None] + self.keys
        around = self.coordinates + neighbour_steps(self.dim)[:, None]
        field = np.tile(fields_of(self.keys, self.dim), len(around))
        return self.keys_of(around.reshape(-1, self.dim), field).reshape(len(around), -1)

    def _key_steps(self):
        """What a step to a neighbour adds to a key, which is linear in the coordinates, (3^dim,)."""
        return keys_of(neighbour_steps(self.dim)) - keys_of(np.zeros((1, self.dim)))

    def node_blocks(self):
        """Blocks that hold nodes of the occupied blocks' particles: -> keys (m,), start (m + 1,), tiles (k, 2).

        Rows start[n] <= i < start[n + 1] of `tiles`: an occupied block around node block n, and the step to it, 3 bits
        an axis, of which one is set: for one back, none, one ahead; see `step_along`.
        """
        # A stable sort merges the sorted runs, three times faster than sorting them
        around = self._around().ravel()
        order = np.argsort(around, kind="stable")
        ordered = around[order]
        first = np.ones(len(ordered), bool)
        first[1:] = ordered[1:] != ordered[:-1]
        step, tile = np.divmod(order, max(1, len(self)))
        # Seen from the node block, the step back to the occupied block is the opposite one
        back = 1 - neighbour_steps(self.dim)
        packed = (1 << back + 3 * np.arange(self.dim)).sum(axis=1)
        start = np.append(np.flatnonzero(first), len(ordered))
        return ordered[first], start.astype(np.int32), np.stack([tile, packed[step]], axis=1).astype(np.int32)


@ti.func
def step_along(packed, axis: ti.template()):
    """-1, 0 or 1: the step along an axis, from the bits of `BlockMap.node_blocks`."""
    return ((packed >> ti.static(3 * axis) & 7) >> 1) - 1


@functools.cache
def sort_kernels(layout):
    """`count_moves(...)` and `aim(...)` of the counting sort for a particle layout."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at_position, at_velocity = accessors(layout), layout.offsets["position"], layout.offsets["velocity"]

    @ti.func
    def step_to(x, v, ahead, lead, block, coordinates: ti.template(), lower: ti.template(), upper: ti.template()):
        """Index of the step from a block to the owner of local position x; -1 outside [lower, upper) cells.

        ahead: time [cells / (m/s)] by which a particle is sorted ahead of itself; lead: at most so many cells.
        """
        code, inside = 0, 1
        for a in ti.static(range(dim)):
            drift = ti.max(-ti.cast(lead, float), ti.min(ti.cast(lead, float), ti.cast(ahead, float) * v[a]))
            base = ti.floor(x[a] + drift - 0.5, ti.i32)
            # min/max: a particle that outran its bound would otherwise address another block's table row
            code = code * 3 + ti.max(0, ti.min(2, ti.floor(ti.cast(base, float) / edge, ti.i32) + 1))
            cell = ti.cast(edge * coordinates[block, a], ti.f64) + ti.cast(x[a], ti.f64)
            if not (cell >= lower[a] and cell < upper[a]):
                inside = 0
        return ti.select(inside == 1, code, -1)

    @grouped_kernel(ti.f64)
    def count_moves(rows: BlockRows, lower: Array, upper: Array, ahead: Real, lead: Real, counts: Array,
                    target: Array, chunk_bounds: Array):
        """How many particles of a block take which step; leaves the step of each in `target`."""
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(first, last):
                    for s in range(3**dim):
                        counts[b, s] = 0
                    for p in range(rows.start[b], rows.start[b + 1]):
                        x = access.load(rows.reals, places, p, at_position, dim)
                        v = access.load(rows.reals, places, p, at_velocity, dim)
                        s = step_to(x, v, ahead, lead, b, rows.coordinates, lower, upper)
                        target[p] = s
                        if s >= 0:
                            counts[b, s] += 1

    @grouped_kernel(ti.f64)
    def aim(rows: BlockRows, next_row: Array, target: Array, chunk_bounds: Array):
        """Turn the steps in `target` into rows, from `next_row` on, and positions into those from the new owner."""
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                first, last = chunk(i, chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(first, last):
                    for p in range(rows.start[b], rows.start[b + 1]):
                        code = target[p]
                        if code >= 0:
                            target[p] = next_row[b, code]
                            next_row[b, code] += 1
                            if code != ti.static(3**dim // 2):
                                x = access.load(rows.reals, places, p, at_position, dim)
                                for a in ti.static(range(dim - 1, -1, -1)):
                                    x[a] -= edge * (code % 3 - 1)
                                    code = code // 3
                                access.store(rows.reals, places, p, at_position, x)

    return count_moves, aim
