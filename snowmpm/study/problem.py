"""A problem whose answer is known, as a study sees it."""

from collections.abc import Callable
from dataclasses import dataclass

from snowmpm.materials.law import Law

FINEST = ("program", "float64", "cubic", "3 per axis", "cubic, 3 per axis", "C = 0.2", "C = 0.4")
"""Variations that are taken to the last grid, where floors and their causes are seen."""
MAIN = ("program", "float64", "cubic", "shape", "cubic, shape", "PIC", "FLIP 0.99", "3 per axis", "C = 0.4", "SPH")
FOR_THE_STEP = ("program", "cubic", "FLIP 0.99", "C = 0.2", "C = 0.4", "C = 0.56")
KINDS = ("elastic", "granular", "impact", "damage")


@dataclass(frozen=True)
class Problem:
    """name: short, of files; title and what: for people, what is solved and what its error is; along: what `cells`
    counts; law: that sets the time step.

    error(scheme, cells, *, per_axis, **options): solves it and gives the relative error; options: which of those of a
    `Variation` it knows. order: at which the error falls with dx where it does, by the problem's own tests; None where
    none is claimed. cells: coarse to fine, of the full form; quick: of the short one, which leaves out a problem with
    none. usual: cells that a user would take; kind: of KINDS, what its error comes from.
    """

    name: str
    kind: str
    title: str
    what: str
    along: str
    law: Law
    error: Callable
    order: float | None
    cells: tuple
    quick: tuple
    usual: int
    options: frozenset = frozenset()
    sph: bool = False
    """whether SPH can solve it"""
    choices: tuple = ()
    """names of the variations that it is solved in, all for none: MAIN or FOR_THE_STEP where it takes long"""

    def grids(self, variation, quick):
        """Cells of the refinement of a variation."""
        if quick:
            return self.quick
        if variation.name in FINEST:
            return self.cells
        return tuple(cells for cells in self.cells if cells <= max(self.usual, self.cells[-2:][0]))

    def takes(self, variation):
        """Whether it can be solved in this variation."""
        if variation.scheme.get("method") == "sph" and not self.sph:
            return False
        return self.options >= variation.options.keys() and (not self.choices or variation.name in self.choices)
