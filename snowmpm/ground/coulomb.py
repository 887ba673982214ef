"""Coulomb friction of the ground."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

from snowmpm.compiler import ti

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Coefficient, Stress


class CoulombParameters(NamedTuple):
    """What `Coulomb.stress` reads."""

    mu: float  # friction coefficient [-]
    tau0: float  # least shear stress [Pa]
    cohesion: float  # C [Pa]


class Coulomb(FrictionLaw):
    """Coulomb friction, in proportion to the normal stress.

        tau = tau0 + mu sigma + cohesive part (`cohesion.cohesive_stress`)

    It does not depend on the speed: on a slope steeper than atan(mu) a flow accelerates for ever.
    """

    EXAMPLES: ClassVar = {"card": "voellmy_buser_frutiger"}

    PARAMETERS: ClassVar[Any] = CoulombParameters

    law: Literal["coulomb"] = "coulomb"
    mu: Coefficient
    """friction coefficient [-]"""
    tau0: Stress = 0.0
    """least shear stress [Pa]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        return ti.Vector([prm.tau0 + prm.mu * sigma + cohesive_stress(prm.cohesion, prm.mu, sigma), 0.0])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> CoulombParameters:
        return CoulombParameters(values["mu"], values["tau0"], values["cohesion"])
