"""An obstacle of a scene: a rigid shape, its motion, and how snow touches it."""

from dataclasses import dataclass

import numpy as np

from snowmpm.contact import CODES
from snowmpm.errors import InputError
from snowmpm.solids.motion import RigidMotion
from snowmpm.solids.primitives import BALL
from snowmpm.solids.shape import SolidShape


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A rigid solid that snow meets. contact: a name of `snowmpm.contact.CODES`; friction: Coulomb mu [-]."""

    name: str
    shape: SolidShape
    motion: RigidMotion
    contact: str = "separate"
    friction: float = 0.0

    @classmethod
    def of(cls, spec, dim, base_dir=".", key="obstacle"):
        """Obstacle of a scene's obstacle table; files are relative to base_dir. InputError: a file or a shape that is
        wrong, with `key` in front."""
        shape = SolidShape.of(spec.shape, dim, base_dir, f"{key}.shape")
        try:
            motion = RigidMotion.of(spec.motion, shape.origin, base_dir)
        except InputError as error:
            raise InputError(f"{key}: {error}") from None
        return cls(spec.name, shape, motion, spec.contact, spec.friction)

    @property
    def code(self):
        """Number of the contact among `snowmpm.contact.CODES`."""
        return CODES[self.contact]

    @property
    def still(self):
        """Whether it never moves."""
        return self.motion.still

    def query_at(self, points, time):
        """Signed distance (k,) [m], > 0 outside, and outward unit normals (k, dim) at points (k, dim) [m] of space."""
        pose = self.motion.pose(time)
        at_start = self.motion.start_centre + (np.asarray(points, float) - pose.centre) @ pose.rotation
        distance, normal = self.shape.query(at_start)
        return distance, normal @ pose.rotation.T

    def velocity_at(self, points, time):
        """Velocity (k, dim) [m/s] of the solid at points (k, dim) [m] of space."""
        return self.motion.velocity_at(np.asarray(points, float), time)

    def frame_at(self, time):
        """Middle (dim,) [m] and axes (dim, dim), unit rows, of the shape's own frame in space."""
        middle = self.motion.moved(self.shape.origin[None], time)[0]
        return middle, self.shape.axes @ self.motion.pose(time).rotation.T

    def bounds_at(self, time):
        """Lower and upper corner (dim,) [m] of a box along the axes of space that holds the solid."""
        middle, axes = self.frame_at(time)
        half = self.shape.size if self.shape.kind == BALL else np.abs(axes.T) @ self.shape.size
        return middle - half, middle + half
