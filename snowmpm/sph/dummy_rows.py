"""The rows of dummy particles: sorted into blocks, those of obstacles carried along."""

import functools

import numpy as np
import taichi as ti

from snowmpm.arrays import int_array, real_array
from snowmpm.blocks import EDGE, BlockMap
from snowmpm.launch import taichi_kernel
from snowmpm.runtime import DTYPES
from snowmpm.sph.candidates import Group


class DummyRows:
    """Rows from `first_row` on of the dummies of all surfaces, those that never move first.

    groups: `candidates.Group`s, one a surface; frames: vectors of normal (dim), depth [cells], velocity of the surface
    above (dim) [m/s], volume [cells]; surface_of (n,).
    """

    def __init__(self, dummies, surfaces, frame, period, first_row):
        self._surfaces, self._frame, self._period, self.first_row = surfaces, frame, period, first_row
        self.dim, self.count = frame.dim, len(dummies)
        moving = np.array([*(surface.moving for surface in surfaces), False])[dummies.surface]
        self._parts = [(int(s), dummies.chosen(chosen & (dummies.surface == s)))
                       for chosen in (~moving, moving) for s in np.unique(dummies.surface[chosen])]
        self.moving = bool(moving.any())
        n, real = max(1, self.count), DTYPES[frame.precision][0]
        self.frames = ti.ndarray(ti.types.vector(2 * self.dim + 2, real), (n,))
        self._body = ti.ndarray(ti.f64, (n, 2 * self.dim + 2))
        self._blocks = ti.ndarray(ti.i32, (n, self.dim))
        self._carry = carry_kernel(self.dim, real)
        self.groups, self.surface_of = [], int_array(np.zeros(1))

    @property
    def bytes(self):
        """Memory of them beside their rows: here, and where they were seeded."""
        width, real = 2 * self.dim + 2, 4 if self._frame.precision == "f32" else 8
        seeded = sum(getattr(part, name).nbytes for _, part in self._parts for name in vars(part))
        return self.frames.shape[0] * (width * (8 + real) + 4 * self.dim + 4) + seeded

    def place(self, rows, time):
        """Sort them into the blocks where they are at `time` [s], and write their rows."""
        body, home, surface, self.groups, row = [], [], [], [], 0
        for s, part in self._parts:
            turn, shift = self._pose(s, time)[:2]
            blocks, order, _ = BlockMap.from_cells(part.positions @ turn.T + shift, self.dim, self._period)
            part = part.chosen(order)
            body.append(np.column_stack([part.positions, part.normals, part.depth, part.volume]))
            home.append(np.repeat(blocks.coordinates, np.diff(blocks.start), axis=0))
            surface.append(np.full(len(part), s))
            self.groups.append(Group(s, blocks, self.first_row + row))
            row += len(part)
        if row:
            self._body.from_numpy(np.concatenate(body))
            self._blocks.from_numpy(np.concatenate(home).astype(np.int32))
            self.surface_of = int_array(np.concatenate(surface))
            self.carry(rows, time, still=True)

    def carry(self, rows, time, still=False):
        """Bring the dummies of moving obstacles, or all, to where they are at `time` [s]."""
        begin = 0
        for s, part in self._parts:
            if still or self._surfaces[s].moving:
                turn, shift, centre, velocity, omega = self._pose(s, time)
                numbers = real_array(np.concatenate([turn.ravel(), shift, centre, velocity, np.ravel(omega)]))
                self._carry(self._body, self._blocks, numbers, self._frame.dx, self.first_row, begin,
                            begin + len(part), self.frames, rows.source, rows.moved)
            begin += len(part)

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


@functools.cache
def carry_kernel(dim, real):
    """Kernel that puts dummies begin <= k < end of one surface where its pose says."""
    edge = EDGE[dim]
    at_shift, at_centre, at_velocity, at_omega = dim * dim, dim * dim + dim, dim * dim + 2 * dim, dim * dim + 3 * dim

    @taichi_kernel
    def carry(body: ti.types.ndarray(), blocks: ti.types.ndarray(), pose: ti.types.ndarray(), dx: ti.f64,
              first_row: int, begin: int, end: int, frames: ti.types.ndarray(), source: ti.types.ndarray(),
              moved: ti.types.ndarray()):
        for q in range(end - begin):
            k = begin + q
            x, n, arm = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
            for a in ti.static(range(dim)):
                x[a] = pose[at_shift + a]
                for b in ti.static(range(dim)):
                    x[a] += pose[dim * a + b] * body[k, b]
                    n[a] += pose[dim * a + b] * body[k, dim + b]
            v = ti.Vector([pose[at_velocity + a] for a in ti.static(range(dim))])
            for a in ti.static(range(dim)):
                arm[a] = dx * (x[a] + body[k, 2 * dim] * n[a] - pose[at_centre + a])
            if ti.static(dim == 2):
                v += pose[at_omega] * ti.Vector([-arm[1], arm[0]])
            else:
                v += ti.Vector([pose[at_omega + a] for a in ti.static(range(3))]).cross(arm)
            for a in ti.static(range(dim)):
                local = ti.cast(x[a] - edge * blocks[k, a], real)
                source[first_row + k][a] = local
                moved[first_row + k][a] = local
                frames[k][a], frames[k][dim + 1 + a] = ti.cast(n[a], real), ti.cast(v[a], real)
            frames[k][dim] = ti.cast(body[k, 2 * dim], real)
            frames[k][2 * dim + 1] = ti.cast(body[k, 2 * dim + 1], real)

    return carry
