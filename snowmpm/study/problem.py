"""A problem whose answer is known, as a study sees it."""

from collections.abc import Callable
from dataclasses import dataclass

from snowmpm.materials.law import Law


@dataclass(frozen=True)
class Problem:
    """name: short, of files; title and what: for people, what is solved and what its error is; along: what `cells`
    counts; law: that sets the time step.

    error(scheme, cells, *, per_axis, **options): solves it and gives the relative error; options: which of those of a
    `Variation` it knows. order: at which the error falls with dx where it does, by the problem's own tests; None where
    none is claimed. cells: coarse to fine, of the full form; quick: of the short one. usual: cells that a user would
    take.
    """

    name: str
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

    def takes(self, variation):
        """Whether it can be solved in this variation."""
        return self.options >= variation.options.keys()
