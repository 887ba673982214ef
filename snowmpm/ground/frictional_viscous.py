"""Frictional-viscous ground: Coulomb friction under a flow that shears over its whole depth."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

from snowmpm.compiler import ti
from snowmpm.materials.precision import larger

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Coefficient, Stress, value


class FrictionalViscousParameters(NamedTuple):
    """What `FrictionalViscous.stress` reads."""

    mu: float  # friction coefficient [-]
    exponent: float  # m [-]
    coefficient: float  # ((1 + 2m)/m)^m eta [Pa s^m]
    tau0: float  # least shear stress [Pa]
    cohesion: float  # C [Pa]


class FrictionalViscous(FrictionLaw):
    """Coulomb friction and a power law of viscosity that shears the flow over its whole depth.

    With tau(z) - s(z) = eta (dv/dz)^m and a strength s that grows linearly with the depth:

        tau = tau0 + mu sigma + ((1 + 2m)/m)^m eta v^m / h^m + cohesive part (`cohesion.cohesive_stress`)

    v is the mean speed over the depth h. Pastor et al. (2020), Coupled depth integrated two phase SPH models for fast
    landslides, ALERT Doctoral School 2020, eqs. 61 to 63. m = 1 is a viscous fluid of tau = 3 eta v/h, m = 2 grains in
    collision: (25/4) eta v²/h². m < 1, where the rate would have no limit at rest, is refused.
    """

    EXAMPLES: ClassVar = {"card": "voellmy_buser_frutiger"}

    PARAMETERS: ClassVar[Any] = FrictionalViscousParameters

    law: Literal["frictional_viscous"] = "frictional_viscous"
    mu: Coefficient
    """friction coefficient [-]"""
    viscosity: value(0.0, 1e9)
    """eta [Pa s^m]"""
    exponent: value(1.0, 4.0) = 2.0
    """m [-]"""
    tau0: Stress = 0.0
    """least shear stress [Pa]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        dry = prm.tau0 + prm.mu * sigma + cohesive_stress(prm.cohesion, prm.mu, sigma)
        height = larger(depth, 1e-6)
        shear = larger(speed / height, 1e-20)  # 0 to the power 0 is 1 here, whatever a compiler makes of it
        return ti.Vector([dry, prm.coefficient * ti.pow(shear, prm.exponent - 1.0) / height])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> FrictionalViscousParameters:
        m = values["exponent"]
        return FrictionalViscousParameters(values["mu"], m, ((1.0 + 2.0 * m) / m) ** m * values["viscosity"],
                                           values["tau0"], values["cohesion"])
