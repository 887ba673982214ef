"""Rigid obstacles: shapes, prescribed motion, distance in NumPy and in kernels, record of their loads."""

from snowmpm.solids.motion import Pose, RigidMotion
from snowmpm.solids.obstacle import Obstacle, inside_any
from snowmpm.solids.shape import SolidShape

__all__ = ["Obstacle", "Pose", "RigidMotion", "SolidShape", "inside_any"]
