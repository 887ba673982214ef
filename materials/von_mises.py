"""Von Mises plasticity: a limit to shear stress alone."""

from typing import ClassVar, Literal

import numpy as np
import taichi as ti

from .invariant_return import GENERAL, STRAIGHT, stress_of_invariants
from .law import Law, NonNegative, Positive, StateVariable

PLASTIC_STRAIN = StateVariable("plastic_strain", "-", "accumulated plastic shear strain ε_s = ∫ √(2/3 dε^p : dε^p)")


def von_mises_update(form):
    """Update function (see `Law`) in a `Form`. prm: `VonMises.parameters`; state: accumulated plastic strain."""

    @ti.func
    def update(prm, h, state, A, dt):
        h_new, deviator, volume, deviator2, valid = form.trial(h, A)
        p = -prm[0] * volume
        q_trial = ti.sqrt(prm[6] * deviator2)
        state_new = state
        ratio, dissipation, iterations = 1.0, 0.0, 0
        strength = prm[2] + prm[3] * state[0]
        if valid == 1 and q_trial > strength:
            gamma = (q_trial - strength) * prm[4]
            # From the strength, not from q_trial: the surface is met to round-off, however far away the trial state is
            q = strength + prm[3] * gamma
            ratio = q / q_trial
            state_new[0] = state[0] + gamma
            dissipation = q * gamma
            iterations = 1
            h_new, valid = form.h(prm[5], deviator, deviator2, p, ratio)
        tau = stress_of_invariants(prm[1], deviator, p, ratio)
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
    yield_stress: Positive  # σ_y [Pa]
    hardening_modulus: NonNegative = 0.0  # H [Pa]

    update = staticmethod(von_mises_update(GENERAL))
    lanes = staticmethod(von_mises_update(STRAIGHT))

    def yield_of_invariants(self, p, q, state):
        """y [Pa]; p only gives its shape. NumPy."""
        strength = self.yield_stress + self.hardening_modulus * np.asarray(state)[..., 0]
        return np.asarray(q) - strength + 0.0 * np.asarray(p)

    def outputs(self, state):
        """plastic_strain: accumulated plastic shear strain."""
        return {"plastic_strain": np.asarray(state)[..., 0]}

    def parameters(self):
        """K, G, σ_y, H, 1/(3G + H), 1/K, 6G²."""
        K, G, H = self.bulk_modulus, self.shear_modulus, self.hardening_modulus
        return K, G, self.yield_stress, H, 1.0 / (3.0 * G + H), 1.0 / K, 6.0 * G * G

    def initial_state(self):
        return (0.0,)
