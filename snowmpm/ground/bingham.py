"""Bingham flow: a plug on a layer that shears at its yield stress."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from snowmpm.compiler import ti
from snowmpm.materials.precision import larger, smaller

from .cohesion import cohesive_stress
from .law import FrictionLaw
from .value import Stress, value

SLOWEST = 1e-6
"""Speed [m/s] below which the rate keeps its value: it grows as v^(-1/2)."""

FLUID = 1e-12
"""Share of the viscous stress that a yield stress is not taken below: without any, xi = 0."""


class BinghamParameters(NamedTuple):
    """What `Bingham.stress` reads."""

    yield_stress: float  # tau_y [Pa]
    viscosity: float  # eta [Pa s]
    cohesion: float  # C [Pa]


@ti.func
def excess_share(a):
    """(1 - xi, xi) for a >= 0, xi the root of xi³ - (3 + a) xi + 2 = 0 between 0 and 1.

    With p = 3 + a and s = √(p/3) it is xi = 2 s sin(asin((3/p)^1.5) / 3), of the three real roots the middle one.
    Near a = 0, where xi = 1 - √(a/3), the sine and its difference from 1 would lose their digits. There the angle
    psi = (pi/2 - asin((3/p)^1.5)) / 3 is taken by its tangent, and

        1 - xi = √3 s sin psi + 2 s sin²(psi/2) - (s - 1)
    """
    ratio = a / (3.0 + a)
    s = ti.sqrt(1.0 + a / 3.0)
    left = 3.0 / (3.0 + a)  # 1 - ratio
    sine = left * ti.sqrt(left)
    # 1 - sine², without a difference of nearly equal numbers
    cosine = ti.sqrt(ratio * (3.0 - ratio * (3.0 - ratio)))
    psi = ti.atan2(cosine, sine) / 3.0
    half = ti.sin(0.5 * psi)
    slow = ti.static(3.0**0.5) * s * ti.sin(psi) + 2.0 * s * half * half - a / (3.0 * (1.0 + s))
    xi_fast = 2.0 * s * ti.sin(ti.atan2(sine, cosine) / 3.0)
    excess = ti.select(a < 1.0, slow, 1.0 - xi_fast)
    return ti.Vector([excess, ti.select(a < 1.0, 1.0 - slow, xi_fast)])


class Bingham(FrictionLaw):
    """A viscous fluid with a yield stress, in steady shear.

    tau = tau_y + eta dv/dz, with the speed averaged over the depth:

        v = (tau h / (6 eta)) (1 - xi)² (2 + xi),   xi = tau_y / tau

    Pastor et al. (2020), Coupled depth integrated two phase SPH models for fast landslides, ALERT Doctoral School 2020,
    eqs. 59 and 60. Solved for the stress it is the cubic xi³ - (3 + a) xi + 2 = 0 with a = 6 eta v / (h tau_y), here by
    its exact root (`excess_share`), not by a quadratic approximation, whose stress is off by up to 3 %. Without a yield
    stress tau = 3 eta v / h.
    tau_y is `yield_stress` and the cohesive part (`cohesion.cohesive_stress`, mu = 0).
    tau - tau_y grows as √v at first: below SLOWEST = 1e-6 m/s the rate keeps its value there, to be finite.
    """

    EXAMPLES: ClassVar = {"yield_stress": 200.0, "viscosity": 20.0, "card": "voellmy_buser_frutiger"}

    PARAMETERS: ClassVar[Any] = BinghamParameters

    law: Literal["bingham"] = "bingham"
    yield_stress: Stress
    """tau_y [Pa]"""
    viscosity: value(0.0, 1e9)
    """eta [Pa s]"""

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        """Dry part [Pa] and rate [Pa s/m], see `FrictionLaw`."""
        dry = prm.yield_stress + cohesive_stress(prm.cohesion, 0.0, sigma)
        moving = larger(speed, SLOWEST)
        viscous = 6.0 * prm.viscosity * moving / larger(depth, 1e-6)
        strength = larger(larger(dry, FLUID * viscous), 1e-20)
        share = excess_share(smaller(viscous / strength, 1.0 / FLUID))
        return ti.Vector([dry, strength * share[0] / (share[1] * moving)])

    @classmethod
    def numbers(cls, values: Mapping[str, Any], gravity: float) -> BinghamParameters:
        return BinghamParameters(values["yield_stress"], values["viscosity"], values["cohesion"])


def bingham_share(a):
    """xi = tau_y / tau for a = 6 eta v / (h tau_y) >= 0. Broadcasts; NumPy, in double precision."""
    p = 3.0 + np.asarray(a, float)
    return 2.0 * np.sqrt(p / 3.0) * np.sin(np.arcsin((3.0 / p) ** 1.5) / 3.0)
