"""μ(I) rheology: Drucker-Prager friction that grows with the shear rate, for dense granular flow."""

from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .invariant_return import GENERAL, STRAIGHT, end_of
from .law import Law, Positive, StateVariable
from .precision import by_precision
from .return_tangent import cone_return, stiffest_over_elastic
from .tension_gap import GAP, trial_behind_gap
from .von_mises import PLASTIC_STRAIN


class MuIParameters(NamedTuple):
    """What the update of `MuI` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]
    static_slope: float  # √3 μ_s: q/p at rest [-]
    limit_slope: float  # √3 μ₂: q/p in the limit of fast shear [-]
    rate_scale: float  # √3 G I₀/(d √ρ_s): a over dt √p [√Pa/s]
    per_3G: float  # 1/(3G) [1/Pa]
    per_K: float  # 1/K [1/Pa]


def mu_i_update(form):
    """Update function (see `Law`) in a `Form`. state: plastic strain, gap, shear rate."""
    end = end_of(form)

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, deviator2, p_trial, factor, gap, valid = trial_behind_gap(form.trial, h, A, prm.K, state[1])
        p = p_trial
        state_new = state
        dissipation, iterations, changed = 0.0, 0, factor < 1.0
        if valid == 1:
            p = ti.max(p_trial, 0.0)
            state_new[1], state_new[2] = gap, 0.0
        if valid == 1 and factor > 0.0:
            q_trial = factor * ti.sqrt(prm.six_G2 * deviator2)
            at_rest, limit = prm.static_slope * p, prm.limit_slope * p
            if p_trial < 0.0 or q_trial > at_rest:
                # q² − (q_tr + q₂ + a) q + (q₂ q_tr + q₁ a) = 0 with q₁, q₂ the strengths at rest and in the limit and
                # a = √3 G dt γ̇ at I = I₀; the smaller root, written without a difference of large numbers
                a = prm.rate_scale * dt * ti.sqrt(p)
                product = limit * q_trial + at_rest * a
                half = 0.5 * (q_trial + limit + a)
                # half² − product as a sum of squares and products that are not negative where q_trial > at_rest
                spread = 0.5 * (q_trial - limit)
                root = ti.sqrt(spread * spread + 0.25 * a * a + a * (0.5 * (q_trial + limit) - at_rest))
                q = product / ti.max(half + root, ti.static(by_precision(1e-30, 1e-200)))
                q = ti.min(ti.max(q, at_rest), q_trial)
                shear = (q_trial - q) * prm.per_3G
                changed = True
                iterations = 1
                factor *= ti.select(q > 0.0, q / ti.max(q_trial, q), 0.0)
                state_new[0] = state[0] + shear
                state_new[1] = gap + ti.max(-p_trial, 0.0) * prm.per_K
                state_new[2] = ti.static(3.0**0.5) * shear / ti.max(dt, ti.static(by_precision(1e-30, 1e-200)))
                dissipation = q * shear
        h_new, tau, valid = end(prm, changed, h_new, deviator, deviator2, p, factor, valid)
        return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, form.failed)

    return update


class MuI(Law):
    """Dense granular flow with friction μ(I), on Hencky elasticity; cohesionless, without dilation.

        |τ| = μ(I) p,   μ(I) = μ_s + (μ₂ − μ_s) / (1 + I₀/I),   I = γ̇ d √(ρ_s/p)

    Jop, Forterre & Pouliquen (2006), doi:10.1038/nature04801, eqs. 2-3. There |τ| = √(s:s/2) and γ̇ = √(2 D:D), which
    in simple shear are the shear stress and the shear rate. In the invariants used here

        |τ| = q/√3,  γ̇ = √3 dε_s/dt,   so   q <= √3 μ(I) p:  the cone of slope √3 μ, which is α = √3 sin φ
                                          of a plane strain cone with sin φ = μ  (not tan φ = μ)

    At rest the law is elastic up to q = √3 μ_s p; beyond, the plastic shear rate of the step Δε_s/dt is the one that
    I holds: backward Euler, with q = q_tr − 3G Δε_s a quadratic whose smaller root is between the strengths at rest
    and in the limit, for any step (Dunatunga & Kamrin 2015, doi:10.1017/jfm.2015.383; here with Kirchhoff stress and
    Hencky strain). dt -> ∞ gives μ_s, dt -> 0 gives μ₂. p does not change in shear; p < 0 is no stress, and what opens
    is a gap that must close first (tension_gap.py).
    d: grain diameter, ρ_s: density of the grains themselves (`density` is that of the packing).

    Deviations: p in I is the Kirchhoff pressure, J times the Cauchy one; grains at any gap are stress-free, where the
    reference asks for the density to be below a critical one: the same for material that was packed at p = 0.
    Validity: I up to about 0.5; steady flow. The volume fraction does not follow I.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        PLASTIC_STRAIN,
        GAP,
        StateVariable("shear_rate", "1/s", "γ̇ = √3 Δε_s/dt, plastic, of the last step; 0 where it was elastic"),
    )
    OUTPUTS: ClassVar[dict[str, str]] = {"plastic_strain": "-", "gap": "-", "shear_rate": "1/s"}

    kind: Literal["mu_i"] = "mu_i"
    static_friction: Positive
    """μ_s: coefficient of friction at rest [-]"""
    limit_friction: Positive
    """μ₂: coefficient of friction in the limit of fast shear [-]"""
    inertial_number: Positive = 0.279
    """I₀, at which half of the rise from μ_s to μ₂ is reached [-]"""
    grain_diameter: Positive
    """d [m]"""
    grain_density: Positive
    """ρ_s, of the grains themselves [kg/m3]"""

    RATE_DEPENDENT: ClassVar[bool] = True

    update = staticmethod(mu_i_update(GENERAL))
    vector_update = staticmethod(mu_i_update(STRAIGHT))

    @model_validator(mode="after")
    def _consistent(self):
        if self.limit_friction < self.static_friction:
            raise ValueError("limit_friction must not be below static_friction: friction would fall with the rate")
        return self

    @property
    def friction_exceeds_dilation(self) -> bool:
        return True

    @property
    def tangent_over_elastic(self) -> float:
        """See `Law`: that of a cone of slope √3 μ₂, which no rate exceeds."""
        slope = float(np.sqrt(3.0)) * self.limit_friction
        return stiffest_over_elastic(self.bulk_modulus, self.shear_modulus, [cone_return(slope, 0.0)])

    def friction(self, shear_rate: Array, p: Array) -> Array:
        """μ(I) at a shear rate γ̇ [1/s] and a pressure p > 0 [Pa]. NumPy."""
        rate = self.inertial_number / self.grain_diameter * np.sqrt(np.asarray(p, float) / self.grain_density)
        share = np.asarray(shear_rate) / (np.asarray(shear_rate) + rate)  # 1 / (1 + I₀/I)
        return self.static_friction + (self.limit_friction - self.static_friction) * share

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """q − √3 μ(I) p [Pa] at the shear rate in the state, which at rest bounds the elastic range.

        Where a gap is open, no stress but zero is admissible: |p| + q. NumPy.
        """
        state, p = np.asarray(state), np.asarray(p, float)
        pressed = np.maximum(p, 1e-200)  # I = 0 at p = 0, if nothing moves
        closed = np.asarray(q) - np.sqrt(3.0) * self.friction(state[..., 2], pressed) * p
        return np.where(state[..., 1] > 0.0, np.abs(p) + q, closed)

    def outputs(self, state: Array) -> dict[str, Array]:
        """plastic_strain, gap, and shear_rate."""
        return {name: np.asarray(state)[..., i] for i, name in enumerate(self.OUTPUTS)}

    def parameters(self) -> MuIParameters:
        K, G = self.bulk_modulus, self.shear_modulus
        root = float(np.sqrt(3.0))
        rate = self.inertial_number / (self.grain_diameter * float(np.sqrt(self.grain_density)))
        return MuIParameters(
            K=K,
            G=G,
            six_G2=6.0 * G * G,
            static_slope=root * self.static_friction,
            limit_slope=root * self.limit_friction,
            rate_scale=root * G * rate,
            per_3G=1.0 / (3.0 * G),
            per_K=1.0 / K,
        )

    def initial_state(self) -> tuple[float, ...]:
        return 0.0, 0.0, 0.0
