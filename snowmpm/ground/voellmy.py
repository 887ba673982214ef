"""Voellmy friction: Coulomb friction and a drag with the square of the speed."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from snowmpm.compiler import ti

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Coefficient, Stress, optional


class VoellmyParameters(NamedTuple):
    """What `Voellmy.stress` reads."""

    mu: float  # friction coefficient [-]
    drag: float  # g/xi [-]
    tau0: float  # least shear stress [Pa]
    cohesion: float  # C [Pa]


class Voellmy(FrictionLaw):
    """Coulomb friction and a drag with the square of the speed.

        tau = tau0 + mu sigma + density g v²/xi + cohesive part (`cohesion.cohesive_stress`)

    Voellmy (1955), Über die Zerstörungskraft von Lawinen, Schweizerische Bauzeitung 73; as in RAMMS: Christen et al.
    (2010), doi:10.1016/j.coldregions.2010.04.005. With tau0 it is the VoellmyMinShear of AvaFrame.
    On a plane at the angle a, a sheet of depth h tends to v² = xi h (sin a - mu cos a). Others write the drag as
    density k v² with k = g/xi, as MoT-Voellmy does: k stands in place of xi.
    """

    EXAMPLES: ClassVar = {"mu": 0.25, "xi": 1500.0, "card": "voellmy_buser_frutiger"}

    PARAMETERS: ClassVar[Any] = VoellmyParameters

    law: Literal["voellmy"] = "voellmy"
    mu: Coefficient
    """dry friction coefficient [-]"""
    xi: optional(1.0, 1e12) = None
    """coefficient of turbulent friction [m/s2]"""
    k: optional(0.0, 10.0) = None
    """g/xi [-], in place of xi"""
    tau0: Stress = 0.0
    """least shear stress [Pa]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        dry = prm.tau0 + prm.mu * sigma + cohesive_stress(prm.cohesion, prm.mu, sigma)
        return ti.Vector([dry, density * prm.drag * speed])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> VoellmyParameters:
        drag = values["k"] if "k" in values else gravity / values["xi"]
        return VoellmyParameters(values["mu"], drag, values["tau0"], values["cohesion"])

    @model_validator(mode="after")
    def _one_drag(self):
        if (self.xi is None) == (self.k is None):
            key, allowed = "xi", "is missing: coefficient of turbulent friction [m/s2], or k = g/xi [-] in its place"
            if self.xi is not None:
                key, allowed = "k", "does not go with xi, of which it is g/xi: leave one of them out"
            raise PydanticCustomError("scene_check", "{allowed}",
                                      {"allowed": allowed, "key": key, "value": self[key]})
        return self
