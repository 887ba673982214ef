"""μ(I) and φ(I): grains whose friction grows with the shear rate, and which loosen the faster they are sheared."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .invariant_return import GENERAL, end_of
from .law import Positive, StateVariable
from .mu_i import MuI
from .precision import by_precision
from .return_tangent import cone_return, stiffest_over_elastic
from .tension_gap import GAP, trial_behind_gap
from .von_mises import PLASTIC_STRAIN

MOST = 25
"""Iterations for the plastic strain of a step; six are usual."""
LEAST_PRESSURE = 1e-9
"""Over the bulk modulus: what I is measured with in a step that begins without pressure [-]."""
COMPACTION = 0.5
"""Dilatancy is at least minus this share of μ_s: loose grains keep half of their friction."""
KEPT = 0.5
"""Share of the pressure that compaction leaves in a step: with less pressure I is larger, which ends compaction."""
ROOT_3 = 3.0**0.5

Fraction = Annotated[float, Field(gt=0.0, lt=1.0)]


class MuPhiIParameters(NamedTuple):
    """What the update of `MuPhiI` reads."""

    K: float  # bulk modulus [Pa]
    per_3G: float  # 1/(3G) [1/Pa]
    per_K: float  # 1/K [1/Pa]
    G: float  # shear modulus [Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]
    static_friction: float  # μ_s [-]
    friction_gain: float  # μ₂ − μ_s [-]
    inertial_number: float  # I₀ [-]
    grain_time: float  # d √ρ_s [s √Pa]
    densest: float  # φ_max [-]
    range: float  # φ_max − φ_min [-]
    rate: float  # K₃ [-]


@ti.func
def flowing(prm: ti.template(), x, p_trial, used, inertial_per_x, fraction):
    """A step in which plastic shear takes x [Pa] off q: p [Pa], μ(I) + β and φ at its end, plastic volume strain.
    used: pressure of I [Pa]; inertial_per_x: I/x."""
    gamma = ti.static(ROOT_3) * x * prm.per_3G
    inertial = inertial_per_x * x
    friction = prm.static_friction + prm.friction_gain * inertial / (inertial + prm.inertial_number)
    steady = prm.densest - prm.range * ti.min(inertial, 1.0)
    # φ (1 + K₃ (φ − φ_eq) Δγ) = φ_n, written without a difference of large numbers
    a = prm.rate * gamma
    half = 0.5 * (1.0 - a * steady)
    root = ti.sqrt(half * half + a * fraction)
    dense = ti.select(half > 0.0, fraction / ti.max(half + root, ti.static(by_precision(1e-30, 1e-200))),
                      (root - half) / ti.max(a, ti.static(by_precision(1e-30, 1e-200))))
    least = -ti.static(COMPACTION) * prm.static_friction
    dilatancy = prm.rate * (dense - steady)
    if dilatancy < least:
        dilatancy = least
    # The pressure that I is measured with follows linearly within the step, or coarse steps would swing about it
    follows = prm.K * gamma * prm.rate * prm.range * ti.min(inertial, 1.0) / (2.0 * used)
    volume = dilatancy * gamma / (1.0 + follows)
    if p_trial > 0.0:
        volume = ti.max(volume, -ti.static(1.0 - KEPT) * p_trial * prm.per_K)
    dense = fraction / (1.0 + volume)
    dilatancy = ti.max(prm.rate * (dense - steady), least)
    p = p_trial + prm.K * volume
    return ti.max(p, 0.0), friction + dilatancy, dense, volume


def mu_phi_i_update(form):
    """Update function (see `Law`) in a `Form`. state: plastic strain, gap, shear rate, solid fraction."""
    end = end_of(form)

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, deviator2, p_trial, factor, gap, valid = trial_behind_gap(form.trial, h, A, prm.K, state[1])
        p, state_new = p_trial, state
        dissipation, iterations, changed = 0.0, 0, factor < 1.0
        q_trial = 0.0
        if valid == 1:
            state_new[1], state_new[2] = gap, 0.0
            q_trial = factor * ti.sqrt(prm.six_G2 * deviator2)
        used = ti.max(p_trial, ti.static(LEAST_PRESSURE) * prm.K)
        at_rest = flowing(prm, 0.0 * p, p_trial, used, 0.0, state[3])
        if valid == 1 and factor > 0.0 and (p_trial < 0.0 or q_trial > ti.static(ROOT_3) * at_rest[1] * p_trial):
            tiny = ti.static(by_precision(1e-30, 1e-200))
            per_x = ti.static(ROOT_3) * prm.per_3G / ti.max(dt, tiny) * prm.grain_time / ti.sqrt(used)
            # q_tr − x = √3 (μ + β) p: above the surface at x = 0, on or below it where no q is left
            low, high = 0.0 * p, q_trial
            above, below = q_trial - ti.static(ROOT_3) * at_rest[1] * ti.max(p_trial, 0.0), 0.0 * p
            x, missed, side = 0.5 * q_trial, q_trial, 0
            last = flowing(prm, high, p_trial, used, per_x, state[3])
            below = -ti.static(ROOT_3) * last[1] * last[0]
            if below >= 0.0:
                x, missed = q_trial, 0.0
            else:
                # First without dilation: the quadratic of `mu_i`
                rest, limit = at_rest[1] * ti.static(ROOT_3) * used, ti.static(ROOT_3) * prm.friction_gain * used
                a = prm.inertial_number / per_x
                b = 0.5 * (q_trial - a - rest - limit)
                product = ti.max(a * (q_trial - rest), 0.0)
                root = ti.sqrt(b * b + product)
                x = ti.select(b > 0.0, b + root, product / ti.max(root - b, tiny))
            goal = ti.static(by_precision(2e-7, 4e-14)) * (q_trial + ti.abs(p_trial))
            while iterations < ti.static(MOST) and ti.abs(missed) > goal:
                if not (x > low and x < high):
                    x = 0.5 * (low + high)
                found = flowing(prm, x, p_trial, used, per_x, state[3])
                missed = q_trial - x - ti.static(ROOT_3) * found[1] * found[0]
                # Regula falsi; the value at an end that stays twice is scaled down (Anderson and Björck 1973)
                if missed > 0.0:
                    if side == 1:
                        share = 1.0 - missed / above
                        below *= ti.select(share > 0.0, share, 0.5)
                    low, above, side = x, missed, 1
                else:
                    if side == -1:
                        share = 1.0 - missed / below
                        above *= ti.select(share > 0.0, share, 0.5)
                    high, below, side = x, missed, -1
                iterations += 1
                if ti.abs(missed) > goal:
                    x = low + (high - low) * above / ti.max(above - below, tiny)
            iterations = ti.max(iterations, 1)
            found = flowing(prm, x, p_trial, used, per_x, state[3])
            p = found[0]
            q = ti.min(ti.static(ROOT_3) * found[1] * p, q_trial)
            shear, gamma = x * prm.per_3G, ti.static(ROOT_3) * x * prm.per_3G
            changed = True
            factor *= ti.select(q > 0.0, q / ti.max(q_trial, q), 0.0)
            state_new[0] = state[0] + shear
            state_new[1] = gap + ti.max(-(p_trial + prm.K * found[3]), 0.0) * prm.per_K
            state_new[2] = gamma / ti.max(dt, tiny) * ti.sqrt(p / used)
            state_new[3] = found[2]
            dissipation = ti.max(q * shear - p * found[3], 0.0)
        h_new, tau, valid = end(prm, changed, h_new, deviator, deviator2, p, factor, valid)
        return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, form.failed)

    return update


class MuPhiI(MuI):
    """Dense granular flow with friction μ(I) and solid fraction φ(I), on Hencky elasticity; cohesionless.

        τ = (μ(I) + β) p,   dε_v^p = β dγ^p,   β = tan ψ = K₃ (φ − φ_eq(I)),   φ_eq(I) = φ_max − (φ_max − φ_min) I

    with μ(I), I, τ and γ of `MuI`. Grains denser than φ_eq dilate and are stronger, looser ones compact and are
    weaker, until φ = φ_eq(I): in steady flow the law is μ(I) and φ(I) (Pouliquen, Cassar, Jop, Forterre & Nicolas 2006,
    doi:10.1088/1742-5468/2006/07/P07020, with φ_max = 0.6, φ_min = 0.5 for glass beads). The way there is the
    dilatancy of Roux & Radjai (1998) as in Pailha & Pouliquen (2009), doi:10.1017/S0022112009007460, who fit K₃ = 4.09
    to glass beads in a viscous liquid. K₃ and both fractions are quoted from memory, without equation numbers: neither
    paper was at hand.

    φ is `density` over `grain_density` at the start, and dφ = -φ dε_v^p after: what elasticity and open gaps change of
    the volume is not in it. The step is implicit in strain, friction, dilation and φ: one scalar equation, safeguarded
    regula falsi. I is measured with the pressure of the trial state, whose change by dilation is followed linearly;
    `shear_rate` is reported such that I is that of the step at the pressure of its end.

    Deviations: β is at least -μ_s/2, so that loose grains keep some strength; φ_eq does not fall below φ_min (I = 1).
    Compaction takes at most half of the pressure in a step.
    Validity: I up to about 0.5; φ near φ_max and φ_min.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        PLASTIC_STRAIN,
        GAP,
        StateVariable("shear_rate", "1/s", "γ̇, plastic, of the last step, at its I; 0 where it was elastic"),
        StateVariable("solid_fraction", "-", "φ: volume of the grains over that of the packing"),
    )
    OUTPUTS: ClassVar[dict[str, str]] = {"plastic_strain": "-", "gap": "-", "shear_rate": "1/s", "solid_fraction": "-"}

    kind: Literal["mu_phi_i"] = "mu_phi_i"  # type: ignore[assignment]
    densest_fraction: Fraction = 0.6
    """φ_max: solid fraction in slow flow [-]"""
    loosest_fraction: Fraction = 0.5
    """φ_min: solid fraction at I = 1 [-]"""
    dilatancy: Positive = 4.09
    """K₃: tangent of the dilation angle per excess of solid fraction [-]"""

    update = staticmethod(mu_phi_i_update(GENERAL))

    @model_validator(mode="after")
    def _packed(self):
        if self.loosest_fraction >= self.densest_fraction:
            raise ValueError("loosest_fraction must be below densest_fraction: grains would compact with the rate")
        if not self.loosest_fraction <= self.solid_fraction <= 0.74:
            raise ValueError(f"density over grain_density is a solid fraction of {self.solid_fraction:.3g}; must be"
                             f" from loosest_fraction ({self.loosest_fraction:g}) to 0.74")
        return self

    @property
    def solid_fraction(self) -> float:
        """φ at the start [-]."""
        return self.density / self.grain_density

    @property
    def tangent_over_elastic(self) -> float:
        """See `Law`: the stiffest of cones between the least and the largest dilatancy."""
        most = self.dilatancy * (max(self.solid_fraction, self.densest_fraction) - self.loosest_fraction)
        cones = [cone_return(ROOT_3 * (friction + beta), ROOT_3 * beta)
                 for friction in (self.static_friction, self.limit_friction)
                 for beta in (-COMPACTION * self.static_friction, 0.0, most)]
        return stiffest_over_elastic(self.bulk_modulus, self.shear_modulus, cones)

    def steady_fraction(self, inertial_number: Array) -> Array:
        """φ_eq(I) [-]. NumPy."""
        share = np.minimum(np.asarray(inertial_number, float), 1.0)
        return self.densest_fraction - (self.densest_fraction - self.loosest_fraction) * share

    def dilatancy_at(self, shear_rate: Array, p: Array, fraction: Array) -> Array:
        """β [-] at a shear rate [1/s], a pressure p > 0 [Pa] and a solid fraction. NumPy."""
        inertial = np.asarray(shear_rate) * self.grain_diameter * np.sqrt(self.grain_density / np.asarray(p, float))
        beta = self.dilatancy * (np.asarray(fraction) - self.steady_fraction(inertial))
        return np.maximum(beta, -COMPACTION * self.static_friction)

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """q − √3 (μ(I) + β) p [Pa] at the shear rate and solid fraction in the state; |p| + q in a gap. NumPy."""
        state, p = np.asarray(state), np.asarray(p, float)
        pressed = np.maximum(p, 1e-200)
        strength = self.friction(state[..., 2], pressed) + self.dilatancy_at(state[..., 2], pressed, state[..., 3])
        return np.where(state[..., 1] > 0.0, np.abs(p) + q, np.asarray(q) - ROOT_3 * strength * p)

    def parameters(self) -> MuPhiIParameters:  # type: ignore[override]
        K, G = self.bulk_modulus, self.shear_modulus
        return MuPhiIParameters(
            K=K,
            per_3G=1.0 / (3.0 * G),
            per_K=1.0 / K,
            G=G,
            six_G2=6.0 * G * G,
            static_friction=self.static_friction,
            friction_gain=self.limit_friction - self.static_friction,
            inertial_number=self.inertial_number,
            grain_time=self.grain_diameter * float(np.sqrt(self.grain_density)),
            densest=self.densest_fraction,
            range=self.densest_fraction - self.loosest_fraction,
            rate=self.dilatancy,
        )

    def initial_state(self) -> tuple[float, ...]:
        return 0.0, 0.0, 0.0, self.solid_fraction
