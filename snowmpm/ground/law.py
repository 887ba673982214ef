"""The contract of a friction law: what a method, a scene and a raster of its numbers may ask of it."""

from typing import TYPE_CHECKING, Any, ClassVar

from snowmpm.registry import GROUND_LAWS

from .parametrised import Parametrised
from .value import Stress


class FrictionLaw(Parametrised):
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

    REGISTRIES: ClassVar = (GROUND_LAWS,)
    TABLE: ClassVar[str] = "terrain.friction"
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
    """name of the friction card whose numbers they are"""
    began_with: str | None = None
    """name of the friction card that they began with, where some were changed"""
