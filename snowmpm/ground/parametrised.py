"""Data with parameters that are numbers or rasters: what friction and entrainment of the ground have in common."""

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import BaseModel, model_validator

from snowmpm.keys import TABLE_CONFIG, Keyed

from .value import Limits, RasterValue

STANDARD_GRAVITY = 9.81
"""[m/s2]"""


class Parametrised(Keyed, BaseModel):
    """Frozen data, checked on construction, unknown keys refused. A subclass adds its parameters, PARAMETERS and
    `numbers`."""

    model_config = TABLE_CONFIG

    PARAMETERS: ClassVar[Any]
    """NamedTuple class of the numbers that its Taichi function reads"""
    TABLE: ClassVar[str]
    """key of its table in a scene"""

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> tuple[Any, ...]:
        """PARAMETERS of parameter values by name, numbers or arrays. gravity [m/s2]: magnitude."""
        raise NotImplementedError

    @classmethod
    def contradiction(cls, values: Mapping[str, Any]) -> str | None:
        """Why parameter values, each within its limits, do not go together; None if they do."""
        return None

    @classmethod
    def limits(cls) -> dict[str, Limits]:
        """Parameter -> its limits, in the order of declaration."""
        found = {name: [entry for entry in info.metadata if isinstance(entry, Limits)]
                 for name, info in cls.model_fields.items()}
        return {name: entries[0] for name, entries in found.items() if entries}

    @property
    def values(self) -> dict[str, Any]:
        """Parameter -> its number or `RasterValue`; those that are missing left out."""
        return {name: value for name in self.limits() if (value := self[name]) is not None}

    @property
    def rasters(self) -> dict[str, RasterValue]:
        """Parameters that are rasters."""
        return {name: value for name, value in self.values.items() if isinstance(value, RasterValue)}

    def parameters(self, gravity: float = STANDARD_GRAVITY) -> Any:
        """PARAMETERS of data whose parameters are all numbers. gravity [m/s2]: magnitude. ValueError beside rasters,
        whose numbers `friction.on_nodes` gives."""
        if self.rasters:
            raise ValueError(f"{', '.join(self.rasters)}: a raster has no one number")
        return self.numbers(self.values, gravity)

    @model_validator(mode="after")
    def _consistent(self):
        if not self.rasters and (reason := self.contradiction(self.values)):
            raise ValueError(reason)
        return self
