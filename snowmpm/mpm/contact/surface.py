"""What snow meets: terrain, sides of the domain, obstacles, each with its way of contact and what it took."""

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.launch import own_launches
from snowmpm.mpm.contact.arrays import ContactNodes
from snowmpm.mpm.contact.contact_node import N_TOTALS
from snowmpm.mpm.contact.joined_contact import joined_kernel
from snowmpm.mpm.contact.joined_lines import JoinedLines
from snowmpm.mpm.contact.lines import Lines
from snowmpm.mpm.contact.wall_contact import Rubbing, Work, contact_kernel
from snowmpm.mpm.contact.walls import FREE, NEAR
from snowmpm.particles.blocks import EDGE
from snowmpm.stepping.contact_velocity import CODES, SLIP, STICK


class Plane:
    """Geometry of a side of the domain: x[axis] = level [cells], normal along `sign`, inwards."""

    stored = False
    array = None

    def __init__(self, axis, sign, level):
        self.axis, self.sign, self.level = axis, sign, level

    def slots(self, keys, coordinates):
        """0 for the node blocks (coordinates (n, dim)) near it, FREE for others."""
        edge = EDGE[coordinates.shape[1]]
        first = edge * coordinates[:, self.axis]
        nearest = np.minimum(self.sign * (first - self.level), self.sign * (first + edge - 1 - self.level))
        return np.where(nearest < NEAR, 0, FREE).astype(np.int32)

    def distance(self, points):
        """Signed distance [cells] at points (k, dim) [cells]."""
        return self.sign * (points[:, self.axis] - self.level)


class Surface:
    """A geometry (`Walls` or `Plane`), how snow touches it, and the totals of what it gave the snow.

    total: what it gave the snow since the start, `N_TOTALS` numbers: impulse (dim,) [N s], minus the energy that it
    took [J], moment of the impulse about the centre of rotation [N s cells], minus the work done on it [J]. motion:
    velocity [m/s], angular velocity [rad/s], centre of rotation [cells], three numbers each. tracked: moments and the
    solid's work are added up. edges: snow has to come around its edges (`lines`).
    """

    def __init__(self, geometry, dim, contact, friction=0.0, tracked=False, moving=False, edges=False):
        self.geometry, self.dim, self.tracked, self.moving, self._edges = geometry, dim, tracked, moving, edges
        self.code, self.basal = CODES[contact], None if np.isscalar(friction) else friction
        self.friction = 0.0 if self.basal else friction
        self.motion = real_array(np.zeros(9))
        self._joined = None
        self._everywhere = real_array(np.zeros((1, 1))), int_array([0, 0, 1, 1])
        self.total = np.zeros(N_TOTALS[dim])

    def slots(self, keys, coordinates):
        return self.geometry.slots(keys, coordinates)

    def bind(self, real, kernel, flip, serial, relieved=False):
        """Compile for a precision, a basis, a transfer, one thread or all of them; relieved: also for contact blocks of
        velocity fields that surfaces meet in turn (`contact_kernel`)."""
        self._lines = Lines(self.dim, real, kernel, self.geometry.stored, serial, self._edges)
        if self.moving:
            self.geometry.bind(serial)
        scheme = self.dim, real, kernel, flip, self.tracked, serial, self.basal is not None
        self._resolve = [own_launches(contact_kernel(*scheme, some)) for some in (False, True)[: 1 + relieved]]
        self._kernel, self._no_walls = kernel, ti.ndarray(ti.types.vector(4, real), (1,))
        if self.joinable:
            self._hold = own_launches(joined_kernel(self.dim, real, kernel, flip, self.tracked, self.code == STICK))

    @property
    def joinable(self):
        """Whether lines may be held together (`joined_contact`): those of a wall at rest that never lets go."""
        holds = self.code == STICK or (self.code == SLIP and self.friction == 0.0 and self.basal is None)
        return holds and self.geometry.stored and not self.moving

    @property
    def bytes(self):
        """Memory of the lines that it crosses."""
        return self._lines.bytes

    def prepare(self, grid, slots):
        """Find the lines of the grid that the surface crosses; slots: of the contact blocks."""
        geometry = self.geometry
        plane = (0, 1, 0.0) if geometry.stored else (geometry.axis, geometry.sign, geometry.level)
        self._slots, lines = slots, self._lines
        lines.find(grid.contact, slots, geometry.array if geometry.stored else self._no_walls, plane)
        if self.joinable and grid.joins:
            others = [other.geometry.distance for other in grid.surfaces if other is not self and not other.moving]
            self._joined, rows = JoinedLines.of(lines, grid.contact, others, self._kernel, grid.precision)
            lines.release(rows)

    def move_to(self, time, origin, dx):
        """Bring a solid that moves to where it is at `time` [s]; -> whether the grid has to prepare other blocks."""
        self.carry(time, origin, dx)
        return self.geometry.move_to(time)

    def carry(self, time, origin, dx):
        """Take the velocity that a solid has at `time` [s], and leave it where it is."""
        pose, motion = self.geometry.obstacle.motion.pose(time), np.zeros((3, 3))
        motion[0, : self.dim], motion[2, : self.dim] = pose.velocity, (pose.centre - origin) / dx
        motion[1, 3 - np.size(pose.omega) :] = pose.omega
        self.motion.from_numpy(motion.ravel())

    def speed_at(self, time):
        """Bound of the speed of a solid's points [m/s]."""
        return self.geometry.obstacle.speed_at(time)

    def given_to_solid(self, dx):
        """Impulse [N s], its moment [N s m] and work [J] that the snow gave the solid: dim + (1 or 3) + 1 numbers."""
        dim = self.dim
        return np.concatenate([-self.total[:dim], -dx * self.total[dim + 1 : -1], self.total[-1:]])

    def _coefficients(self, grid):
        """Coefficients of friction of nodes in plan, and which nodes these are; of fields that are met in turn what
        `contact_kernel` wants to know of the other one."""
        if grid.contact.layers:
            return grid.fields.relief, self._everywhere[1]
        return self._everywhere if self.basal is None else (self.basal.coefficients, int_array(self.basal.window))

    def locate(self, grid):
        """Find the lines anew that a surface crosses which has moved."""
        if self.moving:
            self.prepare(grid, self._slots)

    def apply_contact(self, grid, dx):
        """Bring it to bear on the nodes of the contact blocks of a `TileGrid`, where it was found last."""
        blocks, lines = grid.contact, self._lines.arrays
        at = ContactNodes(grid.nodes, grid.contact_offset, blocks.coordinates, self.motion)
        if self._joined:
            joined = self._joined
            self._hold(at, joined.ints, joined.numbers, joined.state, self.total, joined.n)
        resolve = self._resolve[bool(blocks.layers)]
        whole = (blocks.everyone, blocks.chunk_bounds, blocks.n)
        # The second field slips where the first one sticks or rubs, unless it goes with it
        stays = grid.fields is not None and grid.fields.held and (self.code == STICK or self.friction > 0.0)
        of_second = STICK if stays else SLIP if self.code == STICK else self.code
        ways = (self.code, self.friction), (of_second, 0.0)
        for (code, friction), (work, bounds, n) in zip(ways, blocks.layers or [whole], strict=False):
            if n:
                resolve(at, lines, Rubbing(code, friction, *self._coefficients(grid)), dx, blocks.part, self.total,
                        Work(n, bounds, work))
