"""Gravity that changes with time: centrifuge, tilting table, shaking ground."""

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from snowmpm.scenes.space import LIST, NUMBER, FileName, Vector, by_type
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, refuse

Strength = Annotated[Annotated[Number, NUMBER] | Annotated[Vector, LIST], by_type(NUMBER, LIST)]
Angle = Annotated[Number, Field(ge=-180.0, le=180.0)]


class Gravity(Spec):
    """Acceleration of gravity over time: ramped up by `ramp`, given at `times`, or read from `file`."""

    EXAMPLES: ClassVar = {"values": [0.0, 9.81], "tilts": [0.0, 40.0], "file": "shaking.csv"}

    value: Strength = 9.81
    """acceleration [m/s2], downward, or a vector: the full value after a ramp, and the default where a table gives
    none"""
    start: NonNegative = 0.0
    """when the ramp begins, or time 0 of the table [s]"""
    ramp: Positive | None = None
    """time in which gravity rises smoothly from 0 to `value` [s]"""
    times: Annotated[tuple[NonNegative, ...], Field(min_length=2)] | None = None
    """growing times [s] of `values` or `tilts`; linear between, constant before and after"""
    values: Annotated[tuple[Strength, ...], Field(min_length=2)] | None = None
    """acceleration at each time [m/s2], downward numbers or vectors; `value` when missing"""
    tilts: Annotated[tuple[Angle, ...], Field(min_length=2)] | None = None
    """angle at each time by which the scene is tilted, so that gravity leans towards +x [degrees]"""
    file: FileName | None = None
    """table (.csv): time [s] and components x, y, z [m/s2] of gravity; for shaking ground, gravity minus the
    ground's acceleration"""

    @model_validator(mode="after")
    def _is_one_course(self):
        ways = [key for key in ("ramp", "times", "file") if self[key] is not None]
        if len(ways) != 1:
            raise refuse("needs one of ramp, times and file" + (f", not {' and '.join(ways)}" if ways else ""))
        if (self.times is None) != (self.values is None and self.tilts is None):
            raise refuse("times go with values, tilts or both")
        for key in ("values", "tilts"):
            given = self[key]
            if given is not None and len(given) != len(self.times):
                raise refuse(f"must have as many entries as times, {len(self.times)}", key, given)
        if self.times is not None and any(b <= a for a, b in zip(self.times, self.times[1:], strict=False)):
            raise refuse("must grow from entry to entry", "times", self.times)
        if self.values is not None and len({isinstance(value, tuple) for value in self.values}) > 1:
            raise refuse("must be all numbers or all vectors", "values", self.values)
        return self
