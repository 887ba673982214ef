"""The rows of dummy particles: sorted into blocks, those of obstacles carried along."""

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.runtime import DTYPES
from snowmpm.particles.blocks import EDGE, BlockMap
from snowmpm.sph.candidates import Group
from snowmpm.sph.rows import RowTables

PIECE = 65_536
"""Dummies that are written at a time."""
PLACING = 72
"""Bytes that a coordinate of a dummy takes where it was seeded, or while it is sorted (measured)."""


class Walls(NamedTuple):
    """What kernels read of dummies and surfaces: `DummyRows.frames`, `surface_of` and `first_row`, `Boundary.table`."""

    frames: Array
    surface_of: Array
    first_dummy: int
    surfaces: Array


class Placed(NamedTuple):
    """Dummies of one surface: numbers on the solid (`Part.body`), their blocks, and its pose; row of the first one
    among all dummies, and how many they are."""

    body: Array
    blocks: Array
    pose: Array
    begin: int
    n: int


@dataclass
class Part:
    """Dummies of one surface: the first and the number of their rows among those of all dummies; their group, once they
    have been placed. Of those that never move, rows and group are then all there is: of a whole valley the rest would
    be gigabytes."""

    surface: int
    moving: bool
    begin: int
    count: int
    dummies: Any
    group: Any = None
    body: Any = None
    """positions (dim) [cells], normals (dim), depth [cells], volume [cells] of each, on the solid"""
    owner_block: Any = None
    """block of each (dim)"""


class DummyRows:
    """Rows from `first_row` on of the dummies of all surfaces, those that never move first.

    groups: `candidates.Group`s, one a surface; frames: vectors of normal (dim), depth [cells], velocity of the surface
    above (dim) [m/s], volume [cells]; surface_of (n,).
    """

    def __init__(self, dummies, surfaces, frame, period, first_row):
        self._surfaces, self._frame, self._period, self.first_row = surfaces, frame, period, first_row
        self.dim, self.count = frame.dim, len(dummies)
        moving = np.array([*(surface.moving for surface in surfaces), False])[dummies.surface]
        self.parts, begin = [], 0
        for chosen in (~moving, moving):
            for s in np.unique(dummies.surface[chosen]):
                own = dummies.chosen(chosen & (dummies.surface == s))
                self.parts.append(Part(int(s), surfaces[s].moving, begin, len(own), own))
                begin += len(own)
        self.moving = bool(moving.any())
        self._real = DTYPES[frame.precision][0]
        self.frames = ti.ndarray(ti.types.vector(2 * self.dim + 2, self._real), (max(1, self.count),))
        self._carry = carry_kernel(self.dim, self._real)
        of_parts = [part.surface for part in self.parts], [part.count for part in self.parts]
        self.surface_of = int_array(np.repeat(*of_parts) if self.parts else np.zeros(1))

    @property
    def groups(self):
        return [part.group for part in self.parts]

    @property
    def bytes(self):
        """Most memory of them beside their rows: here, and where they were seeded or while they are placed."""
        reals, real = 2 * self.dim + 2, 4 if self._frame.precision == "f32" else 8
        carried = sum(part.count for part in self.parts if part.moving)
        return self.count * (reals * real + 4 + PLACING * self.dim) + 16 * reals * carried

    def place(self, rows, time):
        """Sort them into the blocks where they are at `time` [s], and write their rows; those that never move once."""
        for part in self.parts:
            if part.moving or part.group is None:
                turn, shift = self._pose(part.surface, time)[:2]
                blocks, order, _ = BlockMap.from_cells(part.dummies.positions @ turn.T + shift, self.dim, self._period)
                part.group = Group(part.surface, blocks, self.first_row + part.begin)
                owner_block = np.repeat(blocks.coordinates.astype(np.int32), np.diff(blocks.start), axis=0)
                pieces = [slice(0, part.count)] if part.moving else _pieces(part.count)
                for piece in pieces:
                    own = part.dummies.chosen(order[piece])
                    part.body = real_array(np.column_stack([own.positions, own.normals, own.depth, own.volume]))
                    part.owner_block = int_array(owner_block[piece])
                    self._put(part, rows, time, piece.start)
                if not part.moving:
                    part.dummies = part.body = part.owner_block = None

    def carry(self, rows, time):
        """Bring the dummies of moving obstacles to where they are at `time` [s]."""
        for part in self.parts:
            if part.moving:
                self._put(part, rows, time)

    def _put(self, part, rows, time, first=0):
        """Write rows of a part, from its `first` on."""
        numbers = real_array(np.concatenate([np.ravel(one) for one in self._pose(part.surface, time)]))
        self._carry(Placed(part.body, part.owner_block, numbers, part.begin + first, part.body.shape[0]),
                    self._frame.dx, self.first_row, self.frames, rows.tables)

    def _pose(self, s, time):
        """Rotation, shift, centre [cells], velocity [m/s], angular velocity [rad/s] of a surface."""
        obstacle, frame = self._surfaces[s].obstacle, self._frame
        if obstacle is None:
            zero = np.zeros(self.dim)
            return np.eye(self.dim), zero, zero, zero, np.zeros(1 if self.dim == 2 else 3)
        pose = obstacle.motion.pose(time)
        turn, shift = obstacle.motion.placement(time, frame.origin)
        return turn, shift / frame.dx, (pose.centre - frame.origin) / frame.dx, pose.velocity, pose.omega

    def near(self, particles, reach):
        """Blocks of dummies that may have particles within `reach` [cells]: coordinates (n, dim), first row (n,),
        number of rows (n,)."""
        rings = int(np.ceil(reach / EDGE[self.dim]))
        axis = np.arange(-rings, rings + 1)
        steps = np.stack(np.meshgrid(*[axis] * self.dim, indexing="ij"), axis=-1).reshape(-1, self.dim)
        parts = [(np.zeros((0, self.dim), np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64))]
        for group in self.groups:
            met = np.zeros(len(group.blocks), bool)
            for step in steps:
                met |= particles.find(group.blocks.coordinates + step)[1]
            parts.append((group.blocks.coordinates[met], group.start[:-1][met], np.diff(group.start)[met]))
        return (np.concatenate(column) for column in zip(*parts, strict=True))


def _pieces(n):
    return [slice(begin, min(begin + PIECE, n)) for begin in range(0, n, PIECE)]


@functools.cache
def carry_kernel(dim, real):
    """Kernel that puts the dummies of one surface, rows from `begin` on, where its pose says."""
    edge = EDGE[dim]
    at_shift, at_centre, at_velocity, at_omega = dim * dim, dim * dim + dim, dim * dim + 2 * dim, dim * dim + 3 * dim

    @grouped_kernel(ti.f64)
    def carry(placed: Placed, dx: Real, first_row: int, frames: Array, rows: RowTables):
        for q in range(placed.n):
            k = placed.begin + q
            x, n, arm = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
            for a in ti.static(range(dim)):
                x[a] = placed.pose[at_shift + a]
                for b in ti.static(range(dim)):
                    x[a] += placed.pose[dim * a + b] * placed.body[q, b]
                    n[a] += placed.pose[dim * a + b] * placed.body[q, dim + b]
            v = ti.Vector([placed.pose[at_velocity + a] for a in ti.static(range(dim))])
            for a in ti.static(range(dim)):
                arm[a] = dx * (x[a] + placed.body[q, 2 * dim] * n[a] - placed.pose[at_centre + a])
            if ti.static(dim == 2):
                v += placed.pose[at_omega] * ti.Vector([-arm[1], arm[0]])
            else:
                v += ti.Vector([placed.pose[at_omega + a] for a in ti.static(range(3))]).cross(arm)
            for a in ti.static(range(dim)):
                local = ti.cast(x[a] - edge * placed.blocks[q, a], real)
                rows.source[first_row + k][a] = local
                rows.moved[first_row + k][a] = local
                frames[k][a], frames[k][dim + 1 + a] = ti.cast(n[a], real), ti.cast(v[a], real)
            frames[k][dim] = ti.cast(placed.body[q, 2 * dim], real)
            frames[k][2 * dim + 1] = ti.cast(placed.body[q, 2 * dim + 1], real)

    return carry
