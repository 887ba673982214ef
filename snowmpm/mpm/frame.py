"""The surfaces that bound the snow on the grid: terrain, sides of the domain, obstacles."""

import numpy as np

from snowmpm.mpm.contact.solid_field import SolidField
from snowmpm.mpm.contact.surface import Plane, Surface
from snowmpm.mpm.contact.walls import Walls
from snowmpm.particles.coordinates import Frame


class GridFrame(Frame):
    """Where the grid lies, and what it knows of the surfaces in it."""

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
                          moving=not obstacle.still, edges=not obstacle.part)
        surface.move_to(0.0, self.origin, self.dx)
        return surface
