"""Friction of the ground under a flow: laws as data, each with its shear stress as a Taichi function.

A scene names a law in `[terrain.friction]`; `friction.GroundFriction` puts its numbers on the nodes of a grid.
"""

from typing import Annotated

from snowmpm.registry import GROUND_LAWS as LAWS

from .bingham import Bingham
from .coulomb import Coulomb
from .frictional_viscous import FrictionalViscous
from .law import FrictionLaw
from .mu_i import MuI
from .samos_at import SamosAt
from .value import RasterValue
from .voellmy import Voellmy

for law in (Coulomb, Voellmy, SamosAt, FrictionalViscous, Bingham, MuI):
    LAWS.add(law)

GroundLaw = Annotated[FrictionLaw, LAWS.member()]

__all__ = [
    "LAWS",
    "Bingham",
    "Coulomb",
    "FrictionLaw",
    "FrictionalViscous",
    "GroundLaw",
    "MuI",
    "RasterValue",
    "SamosAt",
    "Voellmy",
]
