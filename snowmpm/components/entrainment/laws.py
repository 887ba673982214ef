"""Snow cover that a flow takes up: laws of the mass per area and time, each with its Taichi function.

    intake(prm, density, tau, speed, depth) -> ti.Vector([mass rate [kg/m2/s], borne])

with tau the shear stress of friction [Pa], speed [m/s] and depth [m] of the flow (density [kg/m3]), and `borne` the
part of tau by which friction acts while the cover lasts. Snow at rest that is taken up brakes the flow by its momentum
besides.
"""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from snowmpm.compiler import ti
from snowmpm.ground.parametrised import Parametrised
from snowmpm.ground.value import value

LEAST_SPEED = 1e-3
"""[m/s], below which nothing is taken up."""


class EntrainmentParameters(NamedTuple):
    """Numbers of a snow cover and its law."""

    thickness: float  # of the cover, normal to the ground [m]
    density: float  # of the cover [kg/m3]
    number: float  # of the law


class Entrainment(Parametrised):
    """What all laws have."""

    TABLE: ClassVar[str] = "terrain.entrainment"
    PARAMETERS: ClassVar[Any] = EntrainmentParameters
    NUMBER: ClassVar[str]
    """name of the law's own parameter"""

    thickness: value(0.0, 100.0)
    """of the snow cover that can be taken up, normal to the ground [m]"""
    density: value(10.0, 917.0) = 200.0
    """of the snow cover [kg/m3]"""

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> EntrainmentParameters:
        return EntrainmentParameters(values["thickness"], values["density"], values[cls.NUMBER])


class Rate(Entrainment):
    """The volume of a flow grows as exp(E s) along its way s:   dm/dt = rho E h v

    Hungr (1995), doi:10.1139/t95-063; McDougall and Hungr (2005), doi:10.1139/t05-064.
    """

    NUMBER: ClassVar[str] = "growth_rate"

    law: Literal["rate"] = "rate"
    growth_rate: value(0.0, 1.0)
    """E [1/m]"""

    @staticmethod
    @ti.func
    def intake(prm: ti.template(), density, tau, speed, depth):
        """See the module."""
        return ti.Vector([density * prm.number * depth * speed, 1.0 + 0.0 * tau])


class ErosionEnergy(Entrainment):
    """Friction does the work that breaks the cover up:   dm/dt = tau v / e

    Sampl and Zwinger (2004), doi:10.3189/172756404781814780, with e = 5000 J/kg in AvaFrame's com1DFA.
    """

    NUMBER: ClassVar[str] = "energy"

    law: Literal["erosion_energy"] = "erosion_energy"
    energy: value(1.0, 1e9) = 5000.0
    """e [J/kg]"""

    @staticmethod
    @ti.func
    def intake(prm: ti.template(), density, tau, speed, depth):
        """See the module."""
        return ti.Vector([tau * speed / prm.number, 1.0 + 0.0 * tau])


class Strength(Entrainment):
    """The cover bears its strength tau_c; what friction exceeds it by sets snow in motion:

        dm/dt = max(0, tau - tau_c) / v,   and the flow feels tau_c and the momentum of what it takes up

    The jump of momentum at the bed: Fraccarollo and Capart (2002), doi:10.1017/S0022112002008455.
    """

    EXAMPLES: ClassVar = {"strength": 1000.0}

    NUMBER: ClassVar[str] = "strength"

    law: Literal["strength"] = "strength"
    strength: value(0.0, 1e6)
    """tau_c, shear strength of the cover [Pa]"""

    @staticmethod
    @ti.func
    def intake(prm: ti.template(), density, tau, speed, depth):
        """See the module."""
        excess = ti.max(0.0, tau - prm.number)
        rate, borne = 0.0 * tau, 1.0 + 0.0 * tau
        if speed > LEAST_SPEED:
            rate, borne = excess / speed, (tau - excess) / ti.max(tau, 1e-30)
        return ti.Vector([rate, borne])


EntrainmentLaw = Annotated[Rate | ErosionEnergy | Strength, Field(discriminator="law")]
