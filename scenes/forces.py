"""Loads on the snow besides gravity and contact: accelerations and pressures in space and time, damping."""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.registry import FORCES
from snowmpm.scenes.formula import Formula
from snowmpm.scenes.regions import Region
from snowmpm.scenes.shapes import check_corners
from snowmpm.scenes.space import NUMBER, TEXT, FileName, Vector, by_type, dimension
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, check_period, refuse

Value = Annotated[Annotated[Number, NUMBER] | Annotated[Formula, TEXT], by_type(NUMBER, TEXT)]


class _Timed(Spec):
    start: NonNegative = 0.0
    """[s]; of a table: when its time is 0"""
    stop: Positive | None = None
    """[s]; never when missing"""

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        check_period(self.start, self.stop)
        return self


class Force(_Timed):
    """Base of all tables of forces. A table adds its `kind` and, unless a component acts for it, ACTS."""

    REGISTRIES: ClassVar = (FORCES,)
    NEEDS: ClassVar = "forces"
    """what a method must be capable of (`snowmpm.methods.Capabilities`), "" of the force of a component"""
    ACTS: ClassVar[Any] = None
    """what it does in a run: "module:name" of a callable, or the callable itself, that is given the table, the
    dimension, the folder of relative files, the table's key, a function text -> formula, the numbers of the particles
    of its body, or None, and the reference system of the terrain, or None, and returns a `forcing.fields.Field`"""

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


@FORCES.add
class Acceleration(Valued):
    """A force in proportion to mass: wind drag, shaking, the pull of a magnet."""

    ACTS: ClassVar = "snowmpm.forcing.fields:Acceleration"
    UNIT: ClassVar = "m/s2"
    kind: Literal["acceleration"]
    value: Annotated[tuple[Value, ...], Field(min_length=2, max_length=3)] | None = None
    """[m/s2]: a number or a formula of x, y, z, t and the velocity vx, vy, vz of the snow, one an axis"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    ax, ay, az"""
    body: str | None = None
    """name of the body that it acts on; all when missing"""
    within: Space | None = None
    """where it acts: a block; everywhere when missing"""
    region: Region | None = None
    """where it acts, in plan; everywhere when missing"""

    def places(self):
        return [*([f"on {self.body}"] if self.body else []), *(["in within"] if self.within else []),
                *(["in region"] if self.region else [])]


@FORCES.add
class Pressure(Valued):
    """The pressure of a fluid around the snow or in its pores."""

    ACTS: ClassVar = "snowmpm.forcing.fields:Pressure"
    kind: Literal["pressure"]
    acts_on: Literal["surface", "pores"] = "surface"
    """surface: on the free surface of the snow, as of a cell or a lake around it; pores: on each volume by the gradient
    alone, as of water that seeps through the snow; stresses are then effective stresses"""
    value: Value | None = None
    """[Pa]: a number or a formula of x, y, z and t; inside the snow any smooth continuation is right"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    pressure"""

    def places(self):
        return ["around the snow" if self.acts_on == "surface" else "in its pores"]


AnyForce = Annotated[Force, FORCES.member()]


class Damping(_Timed):
    """A drag on every particle in proportion to its mass: dv/dt = ... - coefficient v."""

    coefficient: Positive
    """[1/s]: free motion decays to a third in 1.1 / coefficient seconds"""
    rest_speed: Positive | None = None
    """damping ends for good once the fastest particle, having been faster, falls below this speed [m/s]"""
