"""A rung of the ladder: one model on one grid, and how a scene is changed to stand on it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Rung:
    """name: as in the table of errors; blind: what it cannot see, in words. Of a model that needs no run, `answers`:
    () -> {question: value}; else `changes`: keys of the scene with their values, where `trials` says that the answer
    takes several runs (`snowmpm.strength`); unlike: whether the scene has what the model leaves out, so that its
    measured errors do not hold."""

    name: str
    blind: str
    changes: Mapping[str, Any] | None = None
    answers: Callable[[], Mapping[str, float]] | None = None
    trials: bool = False
    unlike: bool = False


CELLS = (0.5, 1, 2, 4, 8, 16, 32)
"""Cells over the depth of the snow of the rungs of methods that resolve it."""

IN_3D = "3-D "
"""Before the name of a rung in three dimensions, where there is one in plan or in profile too."""


def in_cells(method, cells):
    """Name of a rung of so many cells."""
    return f"{method}, {cells:g} cell{'s' if cells != 1 else ''}"


def spacing(length, cells):
    """Spacing [m] of so many cells over a length, of three digits."""
    return float(f"{length / cells:.3g}")


def nearest_cells(length, dx, choice=CELLS):
    """The number of cells of `choice` that is nearest to length / dx, in ratio."""
    return min(choice, key=lambda cells: max(cells * dx / length, length / (cells * dx)))
