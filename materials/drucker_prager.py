"""Drucker-Prager plasticity: friction, dilation and cohesion on a circular cone, with separation at its apex."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .cohesion_softening import softening_multiplier, strain_of_loss, strength_left, strength_share
from .cone import Cone, cone_slope, dilation_slope
from .invariant_return import GENERAL, STRAIGHT, stress_of_invariants
from .law import Law, NonNegative, Positive, StateVariable
from .return_tangent import cone_return, stiffest_over_elastic
from .tension_gap import GAP, trial_behind_gap
from .von_mises import PLASTIC_STRAIN

NEVER = 1e30  # a plastic strain that no material reaches, within float32


class DruckerPragerParameters(NamedTuple):
    """What the update of `DruckerPrager` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    return_stiffness: float  # 3G + K α α_ψ: fall of the yield function per plastic shear strain [Pa]
    alpha: float  # slope of the cone [-]
    alpha_psi: float  # slope of dilation [-]
    per_3G: float  # 1/(3G) [1/Pa]
    k_left: float  # k that softening leaves [Pa]
    k_loss: float  # k that softening takes [Pa]
    per_strain: float  # 1/κ_c, 0 without softening [-]
    strain_of_loss: float  # κ at which no cohesion is left; `NEVER` where some stays [-]
    per_K: float  # 1/K [1/Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]
    p_per_k: float  # −1/α: p at the apex over k [-]


@ti.func
def _strength(prm: ti.template(), strain, straight: ti.template()):
    """k(κ) [Pa]; no exponential where nothing softens, and none in a straight line."""
    k = prm.k_left
    if ti.static(not straight):  # noqa: SIM102 (one is compile time)
        if prm.k_loss > 0.0:
            k += prm.k_loss * strength_share(strain, prm.per_strain)[0]
    return k


@ti.func
def drucker_prager_return(prm: ti.template(), p_trial, q_trial, strain, gap, straight: ti.template()):
    """Return map in (p, q): p, q, plastic strain κ, gap, dissipation, iterations (0: elastic).

    The trial state lies behind the gap that was there (see tension_gap.py).
    straight: in a straight line, −1 iterations where the strength softens.
    """
    K, alpha, alpha_psi = prm.K, prm.alpha, prm.alpha_psi
    k_left, k_loss, per_strain = prm.k_left, prm.k_loss, prm.per_strain
    p, q, kappa, opened, dissipation, iterations = p_trial, q_trial, strain, gap, 0.0, 0
    # The strength that softening leaves tells most states, inside as well as in compression, without an exponential
    drive = q_trial - alpha * p_trial - k_left
    yields = drive > 0.0
    if yields and k_loss > 0.0:
        yields = drive > _strength(prm, strain, straight) - k_left
    if yields:
        shear = q_trial * prm.per_3G  # plastic shear strain that leaves no q
        p_without = p_trial + K * alpha_psi * shear
        torn = alpha * p_without + k_left < 0.0
        if torn and k_loss > 0.0:
            torn = alpha * p_without + _strength(prm, strain + shear, straight) < 0.0
        if torn:
            # Still in tension when all shear has flowed: the apex. Opening beyond dilation breaks bonds like shear does
            opening = -p_without - k_left / alpha
            more, iterations = softening_multiplier(opening, K, k_loss / alpha, strain + shear, per_strain, straight)
            bonds = ti.max(prm.strain_of_loss - strain - shear, 0.0)  # what of it still breaks some; the rest is a gap
            opened = gap + ti.max(more - bonds, 0.0)
            kappa = strain + shear + ti.select(k_loss > 0.0, ti.min(more, bonds), 0.0)
            k = _strength(prm, kappa, straight)
            p = ti.select(more > bonds, 0.0, -k / alpha)
            q = 0.0
            dissipation = -p * (alpha_psi * shear + more)
        else:
            gamma, iterations = softening_multiplier(drive, prm.return_stiffness, k_loss, strain, per_strain, straight)
            kappa = strain + gamma
            k = _strength(prm, kappa, straight)
            # p not below the apex and q from the surface: admissible to round-off, however far away the trial state is
            p = ti.max(p_trial + K * alpha_psi * gamma, prm.p_per_k * k)
            q = alpha * p + k
            dissipation = gamma * ((alpha - alpha_psi) * p + k)
    return p, q, kappa, opened, dissipation, iterations


def cone_update(form, returned):
    """Update function (see `Law`) of a cone in a `Form`, by a return map such as `drucker_prager_return`. state:
    plastic strain, gap."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, deviator2, p, factor, gap, valid = trial_behind_gap(form.trial, h, A, prm.K, state[1])
        state_new = state
        state_new[1] = gap
        dissipation, iterations, changed = 0.0, 0, factor < 1.0
        if valid == 1 and factor > 0.0:
            q_trial = factor * ti.sqrt(prm.six_G2 * deviator2)
            p_new, q, kappa, opened, work, count = returned(
                prm, p, q_trial, state[0], gap, form.straight
            )
            if count != 0:
                changed = True
                p = p_new
                factor *= ti.select(q > 0.0, q / q_trial, 0.0)
                state_new[0], state_new[1] = kappa, opened
                dissipation, iterations = work, count
        if changed:
            h_new, near = form.h(prm.per_K, deviator, deviator2, p, factor)
            valid *= near
        tau = stress_of_invariants(prm.G, deviator, p, factor)
        return h_new, tau, state_new, dissipation, ti.select(valid == 1 and iterations >= 0, iterations, form.failed)

    return update


def drucker_prager_update(form):
    """`cone_update` of `DruckerPrager`."""
    return cone_update(form, drucker_prager_return)


class DruckerPrager(Law):
    """Drucker-Prager cone with non-associated flow, cohesion and an apex, on Hencky elasticity.

        y(p, q) = q − α p − k <= 0,    k = α c cot φ
        flow: dε_v^p = α_ψ dε_s^p (dilation), α_ψ from the dilation angle ψ <= φ; at the apex p = −c cot φ, q = 0 any
        dilation beyond that

    Fávero Neto & Borja (2018), doi:10.1007/s11440-018-0700-3, eqs. 30-32; de Souza Neto, Perić & Owen, Computational
    Methods for Plasticity (2008), section 8.3. Angles in degrees; α, α_ψ follow from them by the cone's matching
    (`cone.py`), and `alpha`, `k`, `tensile_apex` report what the law works with: quote α, not only φ. k is such that
    the apex lies at the Coulomb line's c cot φ for every cone. φ = 0 is von Mises' law of σ_y = k.

    Backward Euler in closed form, exact for straight steps of any size: with κ the plastic shear strain ε_s,

        cone   Δκ = (q_tr − α p_tr − k) / (3G + K α α_ψ),  q = q_tr − 3G Δκ,  p = p_tr + K α_ψ Δκ
        apex   where the cone would leave q < 0

    Softening (optional, `softening_strain` κ_c): k follows c(κ) of cohesion_softening.py, down to `residual_cohesion`;
    one concave equation for Δκ, Newton from its outer side. At the apex the opening beyond dilation counts in κ too, so
    tension breaks bonds. Under strain control the softening is single-valued while k₀ − k_r < κ_c (3G + K α α_ψ).

    Separation: without cohesion (c = 0, or all of it lost) the apex is at p = 0 and what opens there is a gap that must
    close before stress comes back (tension_gap.py). With cohesion left the apex stress is kept, perfectly plastic, and
    its opening is plastic flow like any other: it is not undone by compression, since the bonds held. Both dissipate
    nothing negative: on the cone Δκ ((α − α_ψ) p + k) >= 0 for 0 <= ψ <= φ; at the apex c cot φ times the dilation;
    in a gap nothing.
    Deviation: dilation does not end at a critical density; for large shear take ψ = 0.
    Validity: a circle fits the hexagon of Mohr-Coulomb at one kind of corner: the triaxial compression cone of φ = 37°
    is 60° strong in plane strain.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (PLASTIC_STRAIN, GAP)
    OUTPUTS: ClassVar[dict[str, str]] = {"plastic_strain": "-", "gap": "-", "damage": "-"}

    BONDS: ClassVar[int] = 0
    kind: Literal["drucker_prager"] = "drucker_prager"
    friction_angle: Annotated[float, Field(ge=0.0, lt=90.0)]
    """φ [degrees]"""
    dilation_angle: Annotated[float, Field(ge=0.0, lt=90.0)] = 0.0
    """ψ, at most the friction angle [degrees]"""
    cohesion: NonNegative = 0.0
    """c of Coulomb's line [Pa]"""
    cone: Cone = "triaxial_compression"
    """where the cone touches Mohr-Coulomb's pyramid; plane_strain: the same limit load in plane strain"""
    softening_strain: Positive | None = None
    """κ_c: plastic strain that leaves a share 1/e of the cohesion above the residual one [-]; it stays when missing"""
    residual_cohesion: NonNegative = 0.0
    """c_r, which softening leaves [Pa]"""

    update = staticmethod(drucker_prager_update(GENERAL))
    vector_update = staticmethod(drucker_prager_update(STRAIGHT))

    @model_validator(mode="after")
    def _consistent(self):
        if self.dilation_angle > self.friction_angle:
            raise ValueError("dilation_angle must not exceed friction_angle: flow would create energy")
        if self.residual_cohesion > self.cohesion:
            raise ValueError("residual_cohesion must not exceed cohesion")
        if self.friction_angle == 0.0 and not self._least_cohesion > 0.0:
            raise ValueError("friction_angle 0 needs cohesion, and some that softening leaves")
        return self

    @property
    def alpha(self) -> float:
        """α = q / (p + c cot φ) at yield [-]."""
        return float(cone_slope(self.friction_angle, self.cone, self.dilation_angle))

    @property
    def alpha_psi(self) -> float:
        """α_ψ: plastic dilation over plastic shear strain [-]."""
        return float(dilation_slope(self.dilation_angle, self.cone))

    @property
    def k(self) -> float:
        """k: q at yield for p = 0 and intact bonds [Pa]."""
        return self.cohesion * self._k_per_cohesion

    @property
    def tensile_apex(self) -> float:
        """c cot φ [Pa]: the isotropic tension that intact bonds carry; inf for φ = 0."""
        if self.cohesion == 0.0:
            return 0.0
        return self.k / self.alpha if self.alpha > 0.0 else np.inf

    @property
    def tensile_strength(self) -> float:
        return self.tensile_apex

    @property
    def tangent_over_elastic(self) -> float:
        """See `Law`; without the part of softening, which acts over the strain `softening_strain` only."""
        return stiffest_over_elastic(self.bulk_modulus, self.shear_modulus, [cone_return(self.alpha, self.alpha_psi)])

    @property
    def friction_exceeds_dilation(self) -> bool:
        return self.dilation_angle < self.friction_angle

    @property
    def _k_per_cohesion(self):
        """α cot φ, which has a limit at φ = 0."""
        angle = max(self.friction_angle, 1e-6)
        return float(cone_slope(angle, self.cone, self.dilation_angle) / np.tan(np.radians(angle)))

    @property
    def _least_cohesion(self):
        return self.cohesion if self.softening_strain is None else self.residual_cohesion

    def k_at(self, strain: Array) -> Array:
        """k [Pa] after the plastic strain κ. NumPy."""
        if self.softening_strain is None:
            return np.full(np.shape(strain), self.k)
        left = self._least_cohesion * self._k_per_cohesion
        return left + (self.k - left) * strength_left(strain, self.softening_strain)

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """y [Pa]; where a gap is open, no stress but zero is admissible: |p| + q. NumPy."""
        state = np.asarray(state)
        closed = np.asarray(q) - self.alpha * np.asarray(p) - self.k_at(state[..., 0])
        return np.where(state[..., 1] > 0.0, np.abs(p) + q, closed)

    def outputs(self, state: Array) -> dict[str, Array]:
        """plastic_strain, gap, and damage: the share of the cohesion that is lost."""
        state = np.asarray(state)
        lost = 1.0 - self.k_at(state[..., 0]) / self.k if self.k > 0.0 else np.zeros(state.shape[:-1])
        return {"plastic_strain": state[..., 0], "gap": state[..., 1], "damage": lost}

    def parameters(self) -> DruckerPragerParameters:
        K, G, alpha, softens = self.bulk_modulus, self.shear_modulus, self.alpha, self.softening_strain is not None
        left = self._least_cohesion * self._k_per_cohesion
        broken = NEVER if self._least_cohesion > 0.0 else 0.0
        if softens and broken == 0.0 and self.cohesion > 0.0:
            broken = strain_of_loss(self.softening_strain)
        return DruckerPragerParameters(
            K=K,
            G=G,
            return_stiffness=3.0 * G + K * alpha * self.alpha_psi,
            alpha=alpha,
            alpha_psi=self.alpha_psi,
            per_3G=1.0 / (3.0 * G),
            k_left=left,
            k_loss=self.k - left,
            per_strain=0.0 if self.softening_strain is None else 1.0 / self.softening_strain,
            strain_of_loss=broken,
            per_K=1.0 / K,
            six_G2=6.0 * G * G,
            p_per_k=-1.0 / alpha if alpha > 0.0 else -NEVER,
        )

    def initial_state(self) -> tuple[float, ...]:
        return 0.0, 0.0

    @property
    def bonds_last_below(self) -> float:
        return -np.inf if self.softening_strain is None else strain_of_loss(self.softening_strain)

    @property
    def bond_energy(self) -> float:
        return (self.cohesion - self.residual_cohesion) * (self.softening_strain or 0.0)

    def severed_state(self) -> tuple[float, ...] | None:
        if self.softening_strain is None:
            return None
        return strain_of_loss(self.softening_strain), 0.0
