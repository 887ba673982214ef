"""The numerical schemes of MPM as data: transfers, bases and gradients, by the names that scenes use.

The scene schema, the critical steps, the costs, the borders of stability and the cautions take their keys from here. A
test asks each of them for a row of every name.
"""

import itertools
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
    """A basis of the grid: a B-spline, or the linear hat averaged over a box (GIMP; Bardenhagen & Kober 2004,
    doi:10.3970/cmes.2004.005.477).

    width: nodes along an axis of its support; box: width of the box [cells], None for a spline. Over a box of a whole
    cell the hat is the quadratic spline.
    """

    name: str
    width: int
    box: float | None = None

    @property
    def even(self) -> bool:
        """Whether its second moment is the same wherever a particle lies, which moving least squares and an affine
        velocity need."""
        return self.box is None


TRANSFERS = {transfer.name: transfer for transfer in (
    Transfer("apic", affine=True, flip=False),
    Transfer("pic", affine=False, flip=False),
    Transfer("flip", affine=False, flip=True),
    Transfer("aflip", affine=True, flip=True),
)}

BASES = {basis.name: basis for basis in (Basis("quadratic", 3), Basis("cubic", 4), Basis("gimp", 3, box=0.5),
                                         Basis("linear", 3, box=0.0625))}
"""The last two are for comparison. The box of gimp is a particle of two along an axis of a cell, and stays as it is;
that of linear rounds off the corners of the hat. A hat with corners has no stable step: a grain that passes a node on
which nothing else hangs is infinitely stiff."""

GRADIENTS = ("affine", "shape")
"""How a velocity gradient is taken: by moving least squares, or by the gradients of the shape functions."""


def misfit(kernel: str, gradient: str, transfer: str) -> tuple[str, str, tuple[str, ...]] | None:
    """(key, its value, values that are allowed) of the first choice that a basis does not go with; None if all do."""
    if BASES[kernel].even:
        return None
    if gradient != "shape":
        return "gradient", gradient, ("shape",)
    if TRANSFERS[transfer].affine:
        return "transfer", transfer, tuple(name for name, moving in TRANSFERS.items() if not moving.affine)
    return None


SCHEMES = tuple(scheme for scheme in itertools.product(BASES, GRADIENTS, TRANSFERS) if misfit(*scheme) is None)
"""(kernel, gradient, transfer) of all that go together."""
