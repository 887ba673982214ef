"""Wet snow: a frictional law whose cohesion falls with the liquid water that the pores hold."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from snowmpm.compiler import ti

from .arrays import Array
from .drucker_prager import DruckerPrager, DruckerPragerParameters, drucker_prager_update
from .invariant_return import GENERAL
from .law import StateVariable
from .tension_gap import GAP
from .von_mises import PLASTIC_STRAIN

LIQUID_WATER = StateVariable("liquid_water", "-", "volume of liquid water over that of the snow; the water in the pores"
                             " sets it, where there is some")


class WetSnowParameters(NamedTuple):
    """What the update of `WetSnow` reads: `DruckerPragerParameters` and `per_water`."""

    K: float
    G: float
    return_stiffness: float
    alpha: float
    alpha_psi: float
    per_3G: float
    k_left: float
    k_loss: float
    per_strain: float
    strain_of_loss: float
    per_K: float
    six_G2: float
    p_per_k: float
    per_water: float  # a: decay of the cohesion per volume share of water [-]


def _soaked(prm, share):
    """The numbers of the dry law with this share of its cohesion."""
    numbers = prm._asdict()
    numbers.pop("per_water")
    return DruckerPragerParameters(**{**numbers, "k_left": prm.k_left * share, "k_loss": prm.k_loss * share})


def wet_snow_update(form):
    """Update function (see `Law`) in a `Form`. state: plastic strain, gap, liquid water."""
    dry = drucker_prager_update(form)

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        share = ti.exp(-prm.per_water * ti.max(state[2], 0.0))
        soaked = ti.static(_soaked(prm, share))
        return dry(soaked, h, state, A, dt)

    return update


class WetSnow(DruckerPrager):
    """`DruckerPrager` whose cohesion falls with the liquid water content θ, a volume share:

        c(θ, κ) = c(κ) exp(−a θ)

    The form is that of hardness and shear frame tests, whose logarithm falls linearly with the water content: Izumi &
    Akitaya (1985), doi:10.3189/1985AoG6-1-267-268; Yamanoi & Endo (2002), Seppyo 64, 443-451, with a = 23.5 of shear
    frames (card `yamanoi_melt_forms`). Friction stays. Water also acts by its pressure and its weight, which the water
    in the pores adds (`snowmpm.water`).
    Deviation: the cohesion comes back when the snow drains, but what softening took of it does not. Stiffness does not
    change with the water: no published form of it was found.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (PLASTIC_STRAIN, GAP, LIQUID_WATER)
    kind: Literal["wet_snow"] = "wet_snow"  # type: ignore[assignment]
    water_weakening: Annotated[float, Field(ge=0.0, le=1000.0)]
    """a of the fall of cohesion with water; 23.5 halves it at a content of 3 % [-]"""
    liquid_water: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """θ, volume fraction of water in a scene without water in the pores [-]"""

    update = staticmethod(wet_snow_update(GENERAL))

    def initial_state(self) -> tuple[float, ...]:
        return (0.0, 0.0, self.liquid_water)

    def severed_state(self) -> tuple[float, ...] | None:
        severed = super().severed_state()
        return None if severed is None else (*severed, self.liquid_water)

    @property
    def tensile_strength(self) -> float:
        return self.tensile_apex * float(self.strength_share(np.array(self.liquid_water)))

    def strength_share(self, liquid_water: Array) -> Array:
        """exp(−a θ): what water leaves of the cohesion. NumPy."""
        return np.exp(-self.water_weakening * np.maximum(liquid_water, 0.0))

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """y [Pa]; where a gap is open, no stress but zero is admissible: |p| + q. NumPy."""
        state = np.asarray(state)
        k = self.k_at(state[..., 0]) * self.strength_share(state[..., 2])
        closed = np.asarray(q) - self.alpha * np.asarray(p) - k
        return np.where(state[..., 1] > 0.0, np.abs(p) + q, closed)

    def parameters(self) -> WetSnowParameters:  # type: ignore[override]
        return WetSnowParameters(**super().parameters()._asdict(), per_water=self.water_weakening)
