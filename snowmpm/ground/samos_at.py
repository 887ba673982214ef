"""SamosAT friction, calibrated for Austrian hazard mapping."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

from snowmpm.compiler import ti
from snowmpm.materials.precision import larger

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Coefficient, Stress, value


class SamosAtParameters(NamedTuple):
    """What `SamosAt.stress` reads."""

    mu: float  # friction coefficient at high speed [-]
    Rs0: float  # fluidisation constant [-]
    per_kappa: float  # 1/kappa [-]
    R: float  # roughness length [m]
    B: float  # constant of the logarithmic profile [-]
    tau0: float  # least shear stress [Pa]
    cohesion: float  # C [Pa]


class SamosAt(FrictionLaw):
    """Coulomb friction that halves with the speed, and a drag with its square that falls with the depth.

        tau = tau0 + mu (1 + Rs0 / (Rs0 + Rs)) sigma + density v² / (ln(h/R)/kappa + B)²,   Rs = density v² / sigma

    and the cohesive part (`cohesion.cohesive_stress`). ln(h/R) is not less than 0. Sampl (2007), as in com1DFA of
    AvaFrame: Tonnel et al. (2023), doi:10.5194/gmd-16-7013-2023.

    The friction coefficient is 2 mu at rest and falls to mu with the speed, which WEAKENS the ground: the dry part is
    tau0 + 2 mu sigma, and `rate` is negative until the drag outweighs the fall. It is at least
    -mu √(density sigma / Rs0) / 2 [Pa s/m], so 1 + dt rate / (density h) > 0 for dt < 2 h √(density Rs0 / sigma) / mu:
    1.9 s for 1 m at mu = 0.155 on the flat.
    """

    EXAMPLES: ClassVar = {"card": "samos_at_medium"}

    PARAMETERS: ClassVar[Any] = SamosAtParameters
    WEAKENS: ClassVar[bool] = True

    law: Literal["samos_at"] = "samos_at"
    mu: Coefficient
    """friction coefficient at high speed [-]; twice that at rest"""
    Rs0: value(1e-3, 1e3) = 0.222
    """fluidisation constant [-]"""
    kappa: value(1e-2, 10.0) = 0.43
    """constant of the logarithmic velocity profile [-]"""
    R: value(1e-6, 10.0) = 0.05
    """roughness length [m]"""
    B: value(0.1, 100.0) = 4.13
    """constant of the logarithmic velocity profile [-]"""
    tau0: Stress = 0.0
    """least shear stress [Pa]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        dry = prm.tau0 + 2.0 * prm.mu * sigma + cohesive_stress(prm.cohesion, prm.mu, sigma)
        profile = prm.per_kappa * ti.log(larger(depth / prm.R, 1.0)) + prm.B
        # mu sigma Rs / (Rs0 + Rs) / v, written without Rs, which has no limit at sigma = 0
        fluidised = prm.mu * sigma / larger(prm.Rs0 * sigma + density * speed * speed, 1e-20)
        return ti.Vector([dry, density * speed * (1.0 / (profile * profile) - fluidised)])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> SamosAtParameters:
        return SamosAtParameters(values["mu"], values["Rs0"], 1.0 / values["kappa"], values["R"], values["B"],
                                 values["tau0"], values["cohesion"])
