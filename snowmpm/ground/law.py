"""The contract of a friction law: what a method, a scene and a raster of its numbers may ask of it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, model_validator

from .value import Limits, RasterValue, Stress

STANDARD_GRAVITY = 9.81
"""[m/s2]"""


class FrictionLaw(BaseModel):
    """Shear stress of the ground on a flow; frozen data, checked on construction, unknown keys refused.

    A law adds its own parameters, its name `law`, PARAMETERS, `numbers`, and one Taichi function:

        stress(prm, density, sigma, speed, depth) -> ti.Vector([dry, rate])

    prm      the law's numbers by name: PARAMETERS, a NamedTuple class, of the entries of a vector in that order
             (`materials.parameters.named`); the argument must be `ti.template()`
    density  of the flow [kg/m3]
    sigma    effective normal stress on the ground >= 0 [Pa]
    speed    of the flow relative to the ground, averaged over the depth, >= 0 [m/s]
    depth    of the flow, normal to the ground, > 0 [m]
    dry      the part that stands at rest, which must be exceeded before anything moves >= 0 [Pa]
    rate     (tau - dry) / speed at this speed, finite at rest [Pa s/m]

    The shear stress is tau = dry + rate speed >= 0, against the motion. `dry` does not depend on the speed. So a step

        v = max(0, |v*| - dt dry / (density depth)) / (1 + dt rate / (density depth))

    with v* the velocity after all other forces stops the flow, never reverses it, and lets it rest. With `rate` at the
    speed before the step it is of second order for tau = dry + k v², and its steady speed is exact.
    `rate` is negative only where a law weakens with speed (WEAKENS).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    PARAMETERS: ClassVar[Any]
    """NamedTuple class of the numbers that `stress` reads"""
    WEAKENS: ClassVar[bool] = False
    """whether the shear stress may fall with the speed"""

    if TYPE_CHECKING:  # of every law, its own

        @property
        def law(self) -> str: ...

        @property
        def stress(self) -> Any: ...

    cohesion: Stress = 0.0
    """cohesion C of the flowing snow [Pa]: adds (1 - mu) C (1 - exp(-sigma / C)); 0 to 100 dry, 100 to 300 wet"""
    card: str | None = None
    """name of the friction card that the numbers began with, kept as their provenance"""

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
        """Parameter -> its number or `RasterValue`."""
        return {name: getattr(self, name) for name in self.limits()}

    @property
    def rasters(self) -> dict[str, RasterValue]:
        """Parameters that are rasters."""
        return {name: value for name, value in self.values.items() if isinstance(value, RasterValue)}

    def parameters(self, gravity: float = STANDARD_GRAVITY) -> Any:
        """PARAMETERS of a law whose parameters are all numbers. gravity [m/s2]: magnitude. ValueError beside rasters,
        whose numbers `GroundFriction.on_nodes` gives."""
        if self.rasters:
            raise ValueError(f"{', '.join(self.rasters)}: a raster has no one number")
        return self.numbers(self.values, gravity)

    @model_validator(mode="after")
    def _consistent(self):
        if not self.rasters and (reason := self.contradiction(self.values)):
            raise ValueError(reason)
        return self
