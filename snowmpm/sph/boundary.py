"""What bounds particles: terrain, sides of the domain and obstacles, as dummy particles or as mirrors.

Sides that slip freely ("slip", "symmetric") are mirrors: particles see their own images behind them, exactly. All other
surfaces have dummies (`sph.dummies`). Where two solids overlap the dummies of the later one are left out.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snowmpm.compiler.arrays import real_array
from snowmpm.sph.dummies import Dummies, seed_dummies
from snowmpm.sph.dummy_rows import DummyRows, Walls
from snowmpm.sph.surface_forces import tally_width
from snowmpm.stepping.contact_velocity import CODES

MIRRORS = ("slip", "symmetric")
MARGIN = 1.0
"""Cells beyond the support in which dummies are seeded around the domain."""


@dataclass
class Surface:
    """One surface: its contact, and what it gave the particles since the start: impulse (dim,) [N s], its moment about
    the frame's origin [N s cells], energy [J]; for an obstacle also the work done on it [J]."""

    contact: str
    friction: float = 0.0
    mirror: tuple | None = None
    obstacle: Any = None
    total: Any = None
    moment_on_solid: Any = None
    work_on_solid: float = 0.0
    query: Any = field(default=None, repr=False)

    @property
    def moving(self):
        return self.obstacle is not None and not self.obstacle.still


class Boundary:
    """Surfaces of a domain and their dummies, whose rows follow those of the particles."""

    def __init__(self, frame, reach, *, ground=None, sides=(), obstacles=(), period=None, first_row=0):
        """reach [cells]: support of the kernel; ground: terrain, its contact and friction; sides (dim, 2) names;
        obstacles: `solids.Obstacle`s."""
        self.frame, self.reach, self.period = frame, reach, period
        self.dim = dim = frame.dim
        self.surfaces = []
        if ground is not None:
            terrain, contact, friction = ground
            self.surfaces.append(Surface(contact, friction, query=_cells(frame, terrain.query)))
        for axis, ends in enumerate(sides):
            for end, name in enumerate(ends):
                if name in ("open", "periodic"):
                    continue
                level = (frame.lower, frame.upper)[end][axis]
                if name in MIRRORS:
                    self.surfaces.append(Surface(name, mirror=(axis, float(level))))
                else:
                    self.surfaces.append(Surface(name, query=_plane(axis, 1 - 2 * end, level)))
        for obstacle in obstacles:
            self.surfaces.append(Surface(obstacle.contact, obstacle.friction, obstacle=obstacle,
                                         query=_cells(frame, lambda x, o=obstacle: o.query_at(x, 0.0))))
        n_moment = 1 if dim == 2 else 3
        for surface in self.surfaces:
            surface.total = np.zeros(tally_width(dim))
            surface.moment_on_solid = np.zeros(n_moment)
        self.mirrors = [(s, *surface.mirror) for s, surface in enumerate(self.surfaces) if surface.mirror]
        table = [[CODES[s.contact], s.friction, float(s.mirror is not None)] for s in self.surfaces]
        self.table = real_array([*table, [0.0, 0.0, 0.0]])
        """Contact code, friction, whether a mirror, of each surface; last: loads."""
        self.dummies = DummyRows(self._seed(int(np.ceil(reach))), self.surfaces, frame, period, first_row)
        self.walls = Walls(self.dummies.frames, self.dummies.surface_of, self.dummies.first_row, self.table)
        """What kernels read of surfaces and dummies."""

    # ---- seeding ----------------------------------------------------------------------------------------------

    def _seed(self, layers):
        frame, parts = self.frame, []
        lower, upper = frame.lower - self.reach - MARGIN, frame.upper + self.reach + MARGIN
        lengths = np.zeros(self.dim)
        for axis in range(self.dim):
            if self.period is not None and self.period[axis] > 0:
                lower[axis], upper[axis] = frame.lower[axis], frame.upper[axis]
                lengths[axis] = upper[axis] - lower[axis]
        earlier: list[Any] = []
        for s, surface in enumerate(self.surfaces):
            if surface.query is None:
                continue
            low, high = lower, upper
            if surface.obstacle is not None:
                box = [(np.asarray(corner) - frame.origin) / frame.dx for corner in surface.obstacle.bounds_at(0.0)]
                low, high = box[0] - 1.0, box[1] + 1.0
                if not surface.moving:
                    low, high = np.maximum(low, lower), np.minimum(high, upper)
            found = seed_dummies(surface.query, low, high, layers, s, np.where(surface.obstacle is None, lengths, 0.0))
            keep = np.ones(len(found), bool)
            for _, axis, level in self.mirrors:
                inner = 1.0 if level < 0.5 * (frame.lower + frame.upper)[axis] else -1.0
                keep &= inner * (found.positions[:, axis] - level) > 0.0
            for axis in range(self.dim):
                if self.period is not None and self.period[axis] > 0:
                    keep &= (found.positions[:, axis] >= lower[axis]) & (found.positions[:, axis] < upper[axis])
            for query in earlier:
                if keep.any():
                    keep[keep] = query(found.positions[keep])[0] > 1e-6
            parts.append(found.chosen(keep))
            if not surface.moving:
                earlier.append(surface.query)
        return Dummies.joined(parts, self.dim)

    # ---- what they did ----------------------------------------------------------------------------------------

    def add(self, totals, time):
        """Sums of a step, (surfaces + 1, tally) [N s, N s cells, J]; -> impulse of loads."""
        dim, dx = self.dim, self.frame.dx
        for surface, row in zip(self.surfaces, totals, strict=False):
            surface.total += row
            if surface.obstacle is not None:
                pose = surface.obstacle.motion.pose(time)
                J, centre = row[:dim], (pose.centre - self.frame.origin) / dx
                arm = np.cross(centre, J) if dim == 3 else np.array([centre[0] * J[1] - centre[1] * J[0]])
                on_solid = -dx * (row[dim:-1] - arm)
                surface.moment_on_solid += on_solid
                surface.work_on_solid += float(-J @ pose.velocity + np.sum(np.asarray(pose.omega) * on_solid))
        return totals[-1, :dim]

    @property
    def obstacle_totals(self):
        dim = self.dim
        rows = [np.concatenate([-s.total[:dim], s.moment_on_solid, [s.work_on_solid]])
                for s in self.surfaces if s.obstacle is not None]
        return np.array(rows).reshape(len(rows), dim + (1 if dim == 2 else 3) + 1)

    def clear(self):
        """Totals start again."""
        for surface in self.surfaces:
            surface.total[:], surface.moment_on_solid[:], surface.work_on_solid = 0.0, 0.0, 0.0

    def state(self):
        """Totals, for a checkpoint."""
        return {"surfaces": np.array([s.total for s in self.surfaces]),
                "on_solids": np.array([[*s.moment_on_solid, s.work_on_solid] for s in self.surfaces])}

    def restore(self, state):
        """Take over what `state()` gave."""
        for surface, total, on_solid in zip(self.surfaces, state["surfaces"], state["on_solids"], strict=True):
            surface.total[:], surface.moment_on_solid[:] = total, on_solid[:-1]
            surface.work_on_solid = float(on_solid[-1])


def _cells(frame, query):
    """A query in scene coordinates as one in cells."""

    def in_cells(points):
        distance, normal = query(frame.origin + frame.dx * points)
        return distance / frame.dx, normal

    return in_cells


def _plane(axis, sign, level):
    def query(points):
        normal = np.zeros_like(points)
        normal[:, axis] = sign
        return sign * (points[:, axis] - level), normal

    return query

