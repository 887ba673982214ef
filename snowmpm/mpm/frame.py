"""Where the grid lies, and the surfaces that bound the snow in it: terrain, sides of the domain, obstacles."""

import numpy as np

from snowmpm.blocks import EDGE
from snowmpm.errors import InputError
from snowmpm.mpm.solid_field import SolidField
from snowmpm.mpm.surface import Plane, Surface
from snowmpm.mpm.walls import Walls


class Frame:
    """Where the grid lies: dim, precision, origin (dim,) [m, scene], dx [m]; lower, upper: the domain in cells."""

    def __init__(self, dim, precision, origin, dx, lower, upper):
        self.dim, self.precision, self.dx = dim, precision, dx
        self.origin = np.asarray(origin, float)
        self.lower, self.upper = ((np.asarray(bound, float) - self.origin) / dx for bound in (lower, upper))

    def terrain(self, terrain, contact, friction):
        """Surface of an object with `query(points) -> distance, normal` in scene coordinates."""

        def wall_distance(nodes):
            distance, normal = terrain.query(self.origin + self.dx * nodes)
            return distance / self.dx, normal

        return Surface(Walls(self.dim, self.precision, wall_distance), self.dim, contact, friction)

    def sides(self, names):
        """Surfaces of the sides that are not open; names (dim, 2)."""
        levels = np.stack([self.lower, self.upper], axis=1)
        return [Surface(Plane(axis, 1 - 2 * end, levels[axis, end]), self.dim, names[axis][end])
                for axis in range(self.dim) for end in range(2) if names[axis][end] not in ("open", "periodic")]

    def solid(self, obstacle):
        """Surface of a `solids.Obstacle`, where it is at time zero."""
        geometry = SolidField(obstacle, dim=self.dim, precision=self.precision, origin=self.origin, dx=self.dx)
        surface = Surface(geometry, self.dim, obstacle.contact, obstacle.friction, tracked=True,
                          moving=not obstacle.still)
        surface.follow(0.0, self.origin, self.dx)
        return surface

    def period(self, names):
        """Blocks after which each axis repeats, 0 where it does not, (dim,). Raises InputError when they do not fit."""
        period, edge = np.zeros(self.dim, np.int64), EDGE[self.dim]
        for axis, ends in enumerate(names):
            if "periodic" in ends:
                blocks = (self.upper[axis] - self.lower[axis]) / edge
                if abs(blocks - round(blocks)) > 1e-6 or round(blocks) < 1 or abs(self.lower[axis]) > 1e-9:
                    raise InputError("domain.boundary = periodic: the domain must be a whole number of"
                                     f" {edge * self.dx:g} m ({edge} cells) long, not {blocks * edge * self.dx:g} m")
                period[axis] = round(blocks)
        return period

    def limits(self, period):
        """(lower, upper) cells beyond which a particle has left; none along a periodic axis."""
        return np.where(period > 0, -np.inf, self.lower), np.where(period > 0, np.inf, self.upper)
