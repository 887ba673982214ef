"""A shape of bodies: the lower half of a rectangle, below the diagonal that falls with x (2-D)."""

from typing import ClassVar, Literal

import numpy as np

import snowmpm
from snowmpm.scenes.shapes import Shape
from snowmpm.scenes.space import Vector
from snowmpm.seeding import shapes


def filled(spec, dim, base_dir, key):
    """`seeding.shapes.Shape` of the table."""
    lower, size = np.asarray(spec.min), np.asarray(spec.max) - np.asarray(spec.min)
    return shapes.Shape(lower, np.eye(2), size, 0.5 * float(np.prod(size)),
                        lambda points: ((points - lower) / size).sum(axis=1) < 1.0)


@snowmpm.register
class Wedge(Shape):
    """The lower half of a rectangle, below the diagonal that falls with x (2-D)."""

    DIMENSION: ClassVar = 2
    FILLS: ClassVar = staticmethod(filled)
    kind: Literal["wedge"] = "wedge"
    min: Vector
    """lower corner of the rectangle [m]"""
    max: Vector
    """upper corner [m]"""
