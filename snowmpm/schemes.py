"""The numerical schemes of MPM as data: transfers, bases and gradients, by the names that scenes use.

The scene schema, the critical steps, the costs, the borders of stability and the cautions take their keys from here. A
test asks each of them for a row of every name.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Transfer:
    """How velocity goes from particles to the grid and back.

    affine: particles hand an affine velocity C on to the grid; flip: particles keep a share of their own velocity and
    add what the grid's velocity gained.
    """

    name: str
    affine: bool
    flip: bool


@dataclass(frozen=True)
class Basis:
    """A B-spline. width: nodes along an axis of its support."""

    name: str
    width: int


TRANSFERS = {transfer.name: transfer for transfer in (
    Transfer("apic", affine=True, flip=False),
    Transfer("pic", affine=False, flip=False),
    Transfer("flip", affine=False, flip=True),
    Transfer("aflip", affine=True, flip=True),
)}

BASES = {basis.name: basis for basis in (Basis("quadratic", 3), Basis("cubic", 4))}

GRADIENTS = ("affine", "shape")
"""How a velocity gradient is taken: by moving least squares, or by the gradients of the shape functions."""
