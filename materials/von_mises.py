"""Von Mises plasticity: a limit to shear stress alone."""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from snowmpm.compiler import ti

from .arrays import Array
from .invariant_return import GENERAL, STRAIGHT, stress_of_invariants
from .law import Law, NonNegative, Positive, StateVariable

PLASTIC_STRAIN = StateVariable("plastic_strain", "-", "accumulated plastic shear strain ε_s = ∫ √(2/3 dε^p : dε^p)")


class VonMisesParameters(NamedTuple):
    """What the update of `VonMises` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    yield_stress: float  # σ_y [Pa]
    H: float  # hardening modulus [Pa]
    per_return: float  # 1/(3G + H) [1/Pa]
    per_K: float  # 1/K [1/Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]


def von_mises_update(form):
    """Update function (see `Law`) in a `Form`. state: accumulated plastic strain."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, volume, deviator2, valid = form.trial(h, A)
        p = -prm.K * volume
        q_trial = ti.sqrt(prm.six_G2 * deviator2)
        state_new = state
        ratio, dissipation, iterations = 1.0, 0.0, 0
        strength = prm.yield_stress + prm.H * state[0]
        if valid == 1 and q_trial > strength:
            gamma = (q_trial - strength) * prm.per_return
            # From the strength, not from q_trial: the surface is met to round-off, however far away the trial state is
            q = strength + prm.H * gamma
            ratio = q / q_trial
            state_new[0] = state[0] + gamma
            dissipation = q * gamma
            iterations = 1
            h_new, valid = form.h(prm.per_K, deviator, deviator2, p, ratio)
        tau = stress_of_invariants(prm.G, deviator, p, ratio)
        return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, form.failed)

    return update


class VonMises(Law):
    """Von Mises yield with associated flow and linear isotropic hardening, on Hencky elasticity.

        y(q, ε_s) = q − (σ_y + H ε_s) <= 0

    de Souza Neto, Perić & Owen, Computational Methods for Plasticity (2008), section 7.3: the radial return is its own
    closed form, Δε_s = (q_tr − σ_y − H ε_s) / (3G + H), exact for a straight step of any size; p does not change and
    plastic flow keeps the volume. Hencky strain carries the return of small strain over to finite strain (ch. 14).
    σ_y [Pa] is the strength in simple tension or compression; in pure shear it is σ_y/√3. Undrained clay of shear
    strength c_u: σ_y = 2 c_u in triaxial compression, √3 c_u in plane strain.
    Validity: material of no friction, in tension as in compression: there is no tensile limit and nothing separates.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (PLASTIC_STRAIN,)
    OUTPUTS: ClassVar[dict[str, str]] = {"plastic_strain": "-"}

    kind: Literal["von_mises"] = "von_mises"
    yield_stress: Positive
    """σ_y, at the start [Pa]"""
    hardening_modulus: NonNegative = 0.0
    """H: rise of the yield stress with plastic strain [Pa]"""

    update = staticmethod(von_mises_update(GENERAL))
    vector_update = staticmethod(von_mises_update(STRAIGHT))

    @property
    def associated(self) -> bool:
        return True

    @property
    def tensile_strength(self) -> float:
        return np.inf

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """y [Pa]; p only gives its shape. NumPy."""
        strength = self.yield_stress + self.hardening_modulus * np.asarray(state)[..., 0]
        return np.asarray(q) - strength + 0.0 * np.asarray(p)

    def outputs(self, state: Array) -> dict[str, Array]:
        """plastic_strain: accumulated plastic shear strain."""
        return {"plastic_strain": np.asarray(state)[..., 0]}

    def parameters(self) -> VonMisesParameters:
        K, G, H = self.bulk_modulus, self.shear_modulus, self.hardening_modulus
        return VonMisesParameters(
            K=K, G=G, yield_stress=self.yield_stress, H=H, per_return=1.0 / (3.0 * G + H), per_K=1.0 / K,
            six_G2=6.0 * G * G,
        )  # fmt: skip

    def initial_state(self) -> tuple[float, ...]:
        return (0.0,)
