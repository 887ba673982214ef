"""Rigid walls of verification cases: planes as terrain, and boxes that stand or move."""

import numpy as np

from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion, Uniform
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape


class Plane:
    """Terrain below a plane through `point`, rising by `angle` [rad] towards +x."""

    def __init__(self, angle, point=(0.0, 0.0)):
        self.point = np.asarray(point, float)
        self.along, self.normal = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])

    def query(self, points):
        return (points - self.point) @ self.normal, np.broadcast_to(self.normal, points.shape)


def block(face, normal, half, contact, velocity=None, ramp=0.0, friction=0.0, name="block"):
    """A square block of half side `half` [m] whose face with outward `normal` (2,) goes through the point `face` in its
    middle; velocity [m/s], reached after `ramp` [s]."""
    normal = np.asarray(normal, float)
    axes = np.array([[normal[1], -normal[0]], normal])
    middle = np.asarray(face, float) - half * normal
    course = None if velocity is None else Uniform(np.asarray(velocity, float), 0.0, ramp=ramp)
    return Obstacle(name, SolidShape(BOX, middle, axes, np.array([half, half])), RigidMotion(middle, course), contact,
                    friction)
