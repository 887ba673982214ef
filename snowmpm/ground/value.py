"""A parameter of a friction law: one number, or a raster with a value for every place."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, Discriminator, Field, Tag

from snowmpm.keys import TABLE_CONFIG, Keyed

NUMBER, TABLE, NONE = "<number>", "<table>", "<none>"
"""Marks of the forms in the location of an error; no key of a scene can be equal to them."""


class RasterValue(Keyed, BaseModel):
    """A raster of values in place of a number."""

    model_config = TABLE_CONFIG

    file: Annotated[str, Field(strict=True, min_length=1, examples=["mu.tif"])]
    """.asc or .tif raster, relative to the scene file; a place has the value of the cell in which it lies"""


@dataclass(frozen=True)
class Limits:
    """Range of a parameter, both ends allowed."""

    least: float
    most: float

    def outside(self, values: Any) -> Any:
        """Where values lie outside; of a value that is not a number, true."""
        values = np.asarray(values, float)
        return ~((values >= self.least) & (values <= self.most))

    def __str__(self) -> str:
        return f"from {self.least:g} to {self.most:g}"


def _form(value: Any) -> str:
    return NONE if value is None else TABLE if isinstance(value, dict | RasterValue) else NUMBER


def value(least: float, most: float) -> Any:
    """Type of a parameter with these limits; they are also found as `Limits` in the metadata of the field."""
    number = Annotated[float, Field(strict=True, ge=least, le=most, allow_inf_nan=False)]
    return Annotated[
        Annotated[number, Tag(NUMBER)] | Annotated[RasterValue, Tag(TABLE)], Discriminator(_form), Limits(least, most)
    ]


def optional(least: float, most: float) -> Any:
    """As `value`, of a parameter that may be missing: None."""
    number = Annotated[float, Field(strict=True, ge=least, le=most, allow_inf_nan=False)]
    return Annotated[
        Annotated[number, Tag(NUMBER)] | Annotated[RasterValue, Tag(TABLE)] | Annotated[None, Tag(NONE)],
        Discriminator(_form), Limits(least, most)
    ]


Coefficient = value(0.0, 10.0)
"""Of Coulomb friction [-]; 10 is an angle of 84 degrees."""

Stress = value(0.0, 1e6)
"""[Pa]; snow in motion bears less than 1 MPa."""
