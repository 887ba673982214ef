"""A law of ground friction: Coulomb, and a drag in proportion to the speed."""

from typing import Literal, NamedTuple

import snowmpm
from snowmpm.compiler import ti
from snowmpm.ground import FrictionLaw
from snowmpm.ground.value import Coefficient


class Numbers(NamedTuple):
    mu: float
    drag: float


@snowmpm.register
class LinearDrag(FrictionLaw):
    """tau = mu sigma + k density speed."""

    PARAMETERS = Numbers
    law: Literal["linear_drag"] = "linear_drag"
    mu: Coefficient
    """coefficient of friction [-]"""
    drag: Coefficient
    """k [m/s]"""

    @classmethod
    def numbers(cls, values, gravity):
        return Numbers(values["mu"], values["drag"])

    @staticmethod
    @ti.func
    def stress(prm: ti.template(), density, sigma, speed, depth):
        return ti.Vector([prm.mu * sigma, prm.drag * density])
