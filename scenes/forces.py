"""Loads on the snow besides gravity and contact: what all tables of them share."""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import model_validator

from snowmpm.registry import FORCES
from snowmpm.scenes.formula import Formula
from snowmpm.scenes.shapes import check_corners
from snowmpm.scenes.space import NUMBER, TEXT, Vector, by_type, dimension
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, check_period, refuse

Value = Annotated[Annotated[Number, NUMBER] | Annotated[Formula, TEXT], by_type(NUMBER, TEXT)]


class Timed(Spec):
    """What acts from a time to another."""

    start: NonNegative = 0.0
    """[s]; of a table: when its time is 0"""
    stop: Positive | None = None
    """[s]; never when missing"""

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        check_period(self.start, self.stop)
        return self

    @property
    def when(self) -> str:
        """When it acts, in words; "" for always."""
        if self.stop is not None:
            return f", from {self.start:g} to {self.stop:g} s"
        return f", from {self.start:g} s on" if self.start else ""


class Force(Timed):
    """Base of all tables of forces. A table adds its `kind` and, unless a component of its own acts for it, ACTS."""

    REGISTRIES: ClassVar = (FORCES,)
    ACTS: ClassVar[Any] = None
    """what it does in a run: "module:name" of a callable, or the callable itself, that is given the table, the
    dimension, the folder of relative files, the table's key, a function text -> formula, the numbers of the particles
    of its body, or None, and the reference system of the terrain, or None, and returns a `prescribed.field.Field` with
    `acceleration(x, v, time)` [m/s2], or `pressure(x, time)` [Pa], `gradient(x, time, dx)` and `on_surface`"""

    if TYPE_CHECKING:  # of every force, its own

        @property
        def kind(self) -> str: ...

    def told(self) -> str:
        """What acts and where, in a line of `snowmpm check`."""
        return self.kind


class Valued(Force):
    """A force that a number, a formula or a table gives."""

    UNIT: ClassVar = "Pa"

    @model_validator(mode="after")
    def _has_a_value(self):
        if (self.value is None) == (self.file is None):
            raise refuse("needs value or file, and not both")
        if isinstance(self.value, tuple) and dimension() not in (None, len(self.value)):
            raise refuse(f"must have {dimension()} entries, one an axis", "value", self.value)
        return self

    def told(self):
        value = self.value if self.file is None else f"from {self.file}"
        value = ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        return " ".join([f"{value} {self.UNIT}", *self.places()])

    def places(self):
        """Where it acts, in words."""
        return []


class Space(Spec):
    """A block along the axes of the scene."""

    min: Vector
    """lower corner [m]"""
    max: Vector
    """upper corner [m]"""

    @model_validator(mode="after")
    def _corners(self):
        check_corners(self.min, self.max)
        return self


AnyForce = Annotated[Force, FORCES.member()]
