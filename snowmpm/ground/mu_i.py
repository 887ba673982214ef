"""μ(I) friction of the ground under dense granular flow."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.materials.precision import larger

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Coefficient, Stress, value


class MuIParameters(NamedTuple):
    """What `MuI.stress` reads."""

    mu_s: float  # friction coefficient at rest [-]
    gain: float  # mu_2 - mu_s [-]
    speed_scale: float  # 2 I_0 / (5 d √density_s): speed at I = I_0 over h √sigma [1/(s √Pa)]
    tau0: float  # least shear stress [Pa]
    cohesion: float  # C [Pa]


class MuI(FrictionLaw):
    """Friction of dense granular flow, which grows with the shear rate, averaged over the depth.

        tau = tau0 + (mu_s + (mu_2 - mu_s) / (1 + I_0/I)) sigma + cohesive part (`cohesion.cohesive_stress`, mu_s)
        I = (5/2)(v/h) d √(density_s / sigma)

    Jop, Forterre and Pouliquen (2006), doi:10.1038/nature04801, eqs. 2 and 3. The shear rate at the ground is that of a
    Bagnold profile, (5/2) v/h for the mean speed v. d and density_s are of the grains. μ rises from mu_s at rest
    to mu_2: a steady uniform flow exists between these two slopes only.
    """

    PARAMETERS: ClassVar[Any] = MuIParameters

    law: Literal["mu_i"] = "mu_i"
    mu_s: Coefficient
    """friction coefficient at rest [-]"""
    mu_2: Coefficient
    """friction coefficient in the limit of fast shear [-], not less than mu_s"""
    I_0: value(1e-4, 100.0) = 0.279
    """inertial number at which the friction is half-way [-]"""
    grain_diameter: value(1e-6, 10.0)
    """d [m]"""
    grain_density: value(1.0, 2e4)
    """density of the grains themselves [kg/m3]"""
    tau0: Stress = 0.0
    """least shear stress [Pa]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        dry = prm.tau0 + prm.mu_s * sigma + cohesive_stress(prm.cohesion, prm.mu_s, sigma)
        half_way = prm.speed_scale * depth * ti.sqrt(sigma)
        return ti.Vector([dry, prm.gain * sigma / larger(speed + half_way, 1e-20)])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> MuIParameters:
        scale = 0.4 * values["I_0"] / (values["grain_diameter"] * np.sqrt(values["grain_density"]))
        return MuIParameters(values["mu_s"], values["mu_2"] - values["mu_s"], scale, values["tau0"],
                             values["cohesion"])

    @classmethod
    def contradiction(cls, values: Mapping[str, Any]) -> str | None:
        if np.any(np.asarray(values["mu_2"]) < np.asarray(values["mu_s"])):
            return "mu_2 must not be below mu_s: friction would fall with the speed"
        return None
