"""Loads on the snow besides gravity and contact: accelerations and pressures in space and time, damping."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

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


class Acceleration(_Timed):
    """A force in proportion to mass: wind drag, shaking, the pull of a magnet."""

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

    @model_validator(mode="after")
    def _has_a_value(self):
        if (self.value is None) == (self.file is None):
            raise refuse("needs value or file, and not both")
        if self.value is not None and dimension() not in (None, len(self.value)):
            raise refuse(f"must have {dimension()} entries, one an axis", "value", self.value)
        return self


class Pressure(_Timed):
    """The pressure of a fluid around the snow or in its pores."""

    kind: Literal["pressure"]
    acts_on: Literal["surface", "pores"] = "surface"
    """surface: on the free surface of the snow, as of a cell or a lake around it; pores: on each volume by the gradient
    alone, as of water that seeps through the snow; stresses are then effective stresses"""
    value: Value | None = None
    """[Pa]: a number or a formula of x, y, z and t; inside the snow any smooth continuation is right"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    pressure"""

    @model_validator(mode="after")
    def _has_a_value(self):
        if (self.value is None) == (self.file is None):
            raise refuse("needs value or file, and not both")
        return self


Force = Annotated[Acceleration | Pressure, Field(discriminator="kind")]


class Damping(_Timed):
    """A drag on every particle in proportion to its mass: dv/dt = ... - coefficient v."""

    coefficient: Positive
    """[1/s]: free motion decays to a third in 1.1 / coefficient seconds"""
    rest_speed: Positive | None = None
    """damping ends for good once the fastest particle, having been faster, falls below this speed [m/s]"""
