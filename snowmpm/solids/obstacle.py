"""An obstacle of a scene: a rigid shape, its motion, and its contact with snow."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.solids.motion import RigidMotion
from snowmpm.solids.primitives import BALL
from snowmpm.solids.shape import SolidShape
from snowmpm.stepping.contact_velocity import CODES


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A rigid solid in contact with snow.

    contact: a name of `snowmpm.stepping.contact_velocity.CODES`; friction: Coulomb mu [-]; drag: c_d [-], for flows
    whose force follows from depth and speed. part: it goes on in others, as a segment of a structure does: its ends are
    no edges.
    """

    name: str
    shape: SolidShape
    motion: RigidMotion
    contact: str = "separate"
    friction: float = 0.0
    drag: float = 2.0
    part: bool = False

    @classmethod
    def of(cls, spec, dim, base_dir=".", key="obstacle", reach=np.inf, moved=None, ground=None):
        """Obstacle of a scene's obstacle table; files are relative to base_dir; reach [m]: of `SolidShape`;
        moved: `SolidShape` -> its motion, in place of that of the table; ground: `TerrainSurface` of the scene.

        InputError: a file or a shape that is wrong, with `key` in front.
        """
        shape = SolidShape.of(spec.shape, dim, base_dir, f"{key}.shape", reach, ground)
        if spec.get("on_ground"):
            if ground is None:
                raise InputError.at(f"{key}.on_ground", True, "needs a [terrain] to stand on")
            shape = shape.put_down(ground, key)
        try:
            motion = moved(shape) if moved else None
            motion = motion or RigidMotion.of(spec.motion, shape.origin, base_dir)
        except InputError as error:
            raise InputError(f"{key}: {error}") from None
        return cls(spec.name, shape, motion, spec.contact, spec.friction, spec.get("drag", cls.drag))

    @property
    def code(self):
        """Number of the contact among `snowmpm.stepping.contact_velocity.CODES`."""
        return CODES[self.contact]

    @property
    def still(self):
        """Whether it never moves."""
        return self.motion.still

    def query_at(self, points, time):
        """Signed distance (k,) [m], > 0 outside, and outward unit normals (k, dim) at points (k, dim) [m] of space
        (`SolidShape.query`)."""
        pose = self.motion.pose(time)
        at_start = self.motion.start_centre + (np.asarray(points, float) - pose.centre) @ pose.rotation
        distance, normal = self.shape.query(at_start)
        return distance, normal @ pose.rotation.T

    def velocity_at(self, points, time):
        """Velocity (k, dim) [m/s] of the solid at points (k, dim) [m] of space."""
        return self.motion.velocity_at(np.asarray(points, float), time)

    def speed_at(self, time):
        """A bound of the speed [m/s] of its points: |v| + |omega| R, R from the centre of rotation to the farthest
        corner of the shape's own box. A step must not carry it across more than a share of a cell."""
        pose = self.motion.pose(time)
        middle = self.shape.axes @ (self.shape.origin - self.motion.start_centre)
        farthest = np.linalg.norm(np.abs(middle) + self.shape.size)
        return float(np.linalg.norm(pose.velocity) + np.linalg.norm(pose.omega) * farthest)

    def frame(self, pose):
        """Middle (dim,) [m] and axes (dim, dim), unit rows, of the shape's own frame in space, at a `Pose`."""
        middle = pose.centre + pose.rotation @ (self.shape.origin - self.motion.start_centre)
        return middle, self.shape.axes @ pose.rotation.T

    def half_sides(self, axes):
        """Half sides (dim,) [m] of a box along the axes of space that holds the solid when its own axes are these."""
        return self.shape.size if self.shape.kind == BALL else np.abs(axes.T) @ self.shape.size

    def bounds_at(self, time):
        """Lower and upper corner (dim,) [m] of that box."""
        middle, axes = self.frame(self.motion.pose(time))
        half = self.half_sides(axes)
        return middle - half, middle + half


def inside_any(obstacles, points, time=0.0):
    """Which of the points (k, dim) [m] of space lie inside one of the obstacles at `time` [s], (k,)."""
    inside = np.zeros(len(points), bool)
    for obstacle in obstacles:
        lower, upper = obstacle.bounds_at(time)
        near = np.flatnonzero(((points >= lower) & (points <= upper)).all(axis=1))
        inside[near] |= obstacle.query_at(points[near], time)[0] < 0.0
    return inside
