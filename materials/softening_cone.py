"""A cone whose friction, cohesion and dilation fade with plastic shear: dense sand that loosens, clay that remoulds."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .cohesion_softening import strength_left, strength_share
from .cone import cone_slope, dilation_slope
from .drucker_prager import DruckerPrager, cone_update
from .invariant_return import GENERAL
from .law import Positive
from .precision import by_precision
from .return_tangent import cone_return, stiffest_over_elastic

HALVINGS = 60
"""Of the opening at the apex."""
MOST = 25
"""Iterations on the cone; about ten are usual."""
SAMPLES = np.linspace(0.0, 20.0, 2001)
"""Plastic strains over the shorter of the two scales, at which friction must exceed dilation."""


class SofteningConeParameters(NamedTuple):
    """What the update of `SofteningCone` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    per_3G: float  # 1/(3G) [1/Pa]
    per_K: float  # 1/K [1/Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]
    angle_left: float  # φ_r [rad]
    angle_loss: float  # φ_p − φ_r [rad]
    cohesion_left: float  # c_r [Pa]
    cohesion_loss: float  # c_p − c_r [Pa]
    per_strain: float  # 1/κ_c [-]
    dilation: float  # ψ₀ [rad]
    per_dilation_strain: float  # 1/κ_ψ [-]
    own: float  # share of its plastic strain that strength follows within a step: 1, or 0 where it is averaged
    side: float  # ±1: corners of compression or extension
    plane: float  # 1 in the matching of plane strain, else 0


@ti.func
def cone_at(prm: ti.template(), strain):
    """α, k [Pa] and α_ψ after the plastic shear strain κ (`cone.py`)."""
    share = strength_share(strain, prm.per_strain)[0]
    angle = prm.angle_left + prm.angle_loss * share
    cohesion = prm.cohesion_left + prm.cohesion_loss * share
    s, s_psi = ti.sin(angle), ti.sin(prm.dilation * ti.exp(-strain * prm.per_dilation_strain))
    slope, slope_psi = 6.0 / (3.0 - prm.side * s), 6.0 * s_psi / (3.0 - prm.side * s_psi)
    if prm.plane > 0.0:
        slope_psi = 3.0 * s_psi / ti.sqrt(3.0 + s_psi * s_psi)
        along = slope_psi / 9.0
        slope = 1.0 / (ti.sqrt(1.0 / 3.0 - 3.0 * along * along) + s * along)
    return slope * s, slope * cohesion * ti.cos(angle), slope_psi


@ti.func
def sheared(prm: ti.template(), p_trial, q_trial, strain, gamma):
    """Yield function [Pa] after the plastic shear strain γ of the step, with the strength at its end (where plastic
    strain is averaged, at its beginning)."""
    alpha, k, alpha_psi = cone_at(prm, strain + prm.own * gamma)
    return q_trial - 3.0 * prm.G * gamma - alpha * (p_trial + prm.K * alpha_psi * gamma) - k


@ti.func
def softening_cone_return(prm: ti.template(), p_trial, q_trial, strain, gap, straight: ti.template()):
    """Return map in (p, q), as `drucker_prager_return`."""
    p, q, kappa, opened, dissipation, iterations = p_trial, q_trial, strain, gap, 0.0, 0
    # Where strength falls by more than 3G per strain, round-off must not begin to yield what is on the surface
    if sheared(prm, p_trial, q_trial, strain, 0.0) > ti.static(by_precision(1e-6, 5e-10)) * (q_trial + ti.abs(p_trial)):
        shear = q_trial * prm.per_3G  # plastic shear strain that leaves no q
        start = strain + prm.own * shear
        alpha, k, alpha_psi = cone_at(prm, start)
        p_without = p_trial + prm.K * alpha_psi * shear
        if alpha * p_without + k < 0.0:
            # Still in tension when all shear has flowed: the apex, whose opening breaks bonds like shear does
            breaks = ti.select(prm.cohesion_loss > 0.0, 1.0, 0.0)
            low, high = 0.0, -p_without * prm.per_K
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                alpha, k, alpha_psi = cone_at(prm, start + prm.own * breaks * middle)
                if alpha * (p_without + prm.K * middle) + k < 0.0:
                    low = middle
                else:
                    high = middle
            kappa = strain + shear + breaks * high
            alpha, k, alpha_psi = cone_at(prm, start + prm.own * breaks * high)
            opened = gap + ti.select(k > 0.0, 0.0, high)  # without bonds what opens is a gap
            p, q = -k / ti.max(alpha, ti.static(by_precision(1e-30, 1e-200))), 0.0
            dissipation, iterations = ti.max(-p, 0.0) * (high + alpha_psi * shear), 1
        else:
            # Positive at 0, not so at `shear`: the root between, by the rule of Illinois, each fourth time by halves
            low, high, side, gamma = 0.0, shear, 0, shear
            above, below = sheared(prm, p_trial, q_trial, strain, 0.0), sheared(prm, p_trial, q_trial, strain, shear)
            near = ti.static(by_precision(1e-6, 1e-13)) * q_trial
            value = below
            while ti.abs(value) > near and iterations < MOST:
                iterations += 1
                gamma = ti.select(iterations % 4 == 0, 0.5 * (low + high), low + (high - low) * above / (above - below))
                value = sheared(prm, p_trial, q_trial, strain, gamma)
                if value > 0.0:
                    low, above = gamma, value
                    if side == 1:
                        below *= 0.5
                    side = 1
                else:
                    high, below = gamma, value
                    if side == -1:
                        above *= 0.5
                    side = -1
            iterations = ti.max(iterations, 1)
            kappa = strain + gamma
            alpha, k, alpha_psi = cone_at(prm, strain + prm.own * gamma)
            # On the surface to round-off, and not beyond the apex
            p = ti.max(p_trial + prm.K * alpha_psi * gamma, -k / ti.max(alpha, ti.static(by_precision(1e-30, 1e-200))))
            q = alpha * p + k
            dissipation = gamma * ti.max((alpha - alpha_psi) * p + k, 0.0)
    return p, q, kappa, opened, dissipation, iterations


class SofteningCone(DruckerPrager):
    """`DruckerPrager` whose friction, cohesion and dilation fade with the plastic shear strain κ.

        φ(κ) = φ_r + (φ_p − φ_r) s(κ),   c(κ) = c_r + (c_p − c_r) s(κ),   s = exp(−κ/κ_c)               [B 76-77]
        ψ(κ) = ψ₀ exp(−κ/κ_ψ)                                                                           [B 82]

    [B] Bui and Nguyen (2021), "Smoothed particle hydrodynamics (SPH) and its applications in geomechanics",
    doi:10.1016/j.compgeo.2021.104315, eqs. 74-82, after Zabala & Alonso (2011). κ counts √(2/3 e^p : e^p), e^p the
    deviator of the plastic strain. Keys: φ_p friction_angle, φ_r residual_friction_angle, c_p cohesion, c_r
    residual_cohesion, κ_c softening_strain (1/η of [B]), ψ₀ dilation_angle, κ_ψ dilation_strain (1/s_f), without which
    dilation stays. Dilation must not exceed friction at any κ.

    Erratum of [B], eqs. 81 and 87: from consistency the softening term of the plastic multiplier is −f_κ √(2/3 g:g)
    with f_κ = ∂f/∂κ; with the printed + it stiffens what softens. Here it follows from backward Euler:

        q_tr − 3G Δκ = α(κ) (p_tr + K α_ψ(κ) Δκ) + k(κ),   κ at the end of the step

    solved within a bracket; at the apex the opening counts in κ, and what opens without cohesion is a
    gap (tension_gap.py). s is cut off at a millionth, see cohesion_softening.py.
    Under strain control the answer is unique while strength falls by less than 3G per κ. A band of shear is as wide as
    the grid makes it, and so is the work that softening takes, but with `nonlocal_length`: then strength follows the
    plastic strain averaged over that length (`docs/softening.md`), and is that of the beginning within a
    step. A band across which the material slips by u has lost what κ = u/(√3 l) takes, l the length, on any grid.
    """

    EXAMPLES: ClassVar = {"dilation_strain": 0.1}

    FADES: ClassVar[int] = 0
    OF_COMPONENTS: ClassVar[tuple[str, ...]] = ("nonlocal_length",)

    kind: Literal["softening_cone"] = "softening_cone"  # type: ignore[assignment]
    residual_friction_angle: Annotated[float, Field(ge=0.0, lt=90.0)]
    """φ_r, which softening leaves [degrees]"""
    softening_strain: Positive
    """κ_c: plastic strain over which a share 1/e is left of what friction and cohesion lose [-]"""
    dilation_strain: Positive | None = None
    """κ_ψ: plastic strain over which dilation falls to a share 1/e [-]; it stays when missing"""
    nonlocal_length: Positive | None = None
    """l, over which plastic strain is averaged [m]; strength is local when missing"""

    update = staticmethod(cone_update(GENERAL, softening_cone_return))

    @model_validator(mode="after")
    def _fades(self):
        if self.residual_friction_angle > self.friction_angle:
            raise ValueError("residual_friction_angle must not exceed friction_angle")
        if self.residual_friction_angle == 0.0 and not self.residual_cohesion > 0.0:
            raise ValueError("residual_friction_angle 0 needs residual_cohesion")
        strain = SAMPLES * min(self.softening_strain, self.dilation_strain or np.inf)
        if (self.dilation_at(strain) > self.friction_at(strain) + 1e-9).any():
            raise ValueError("dilation_angle must not exceed friction at any strain: flow would create energy")
        return self

    def friction_at(self, strain: Array) -> Array:
        """φ [deg] after the plastic shear strain κ. NumPy."""
        loss = self.friction_angle - self.residual_friction_angle
        return self.residual_friction_angle + loss * strength_left(strain, self.softening_strain)

    def dilation_at(self, strain: Array) -> Array:
        """ψ [deg] after the plastic shear strain κ. NumPy."""
        return self.dilation_angle * np.exp(-np.asarray(strain) / (self.dilation_strain or np.inf))

    def alpha_at(self, strain: Array) -> Array:
        """α after the plastic shear strain κ. NumPy."""
        return np.asarray(cone_slope(self.friction_at(strain), self.cone, self.dilation_at(strain)))

    def k_at(self, strain: Array) -> Array:
        """k [Pa] after the plastic shear strain κ. NumPy."""
        angle = np.maximum(self.friction_at(strain), 1e-6)
        loss = (self.cohesion - self.residual_cohesion) * strength_left(strain, self.softening_strain)
        slope = cone_slope(angle, self.cone, self.dilation_at(strain))
        return np.asarray((self.residual_cohesion + loss) * slope / np.tan(np.radians(angle)))

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """y [Pa]; where a gap is open, no stress but zero is admissible: |p| + q. NumPy."""
        state = np.asarray(state)
        closed = np.asarray(q) - self.alpha_at(state[..., 0]) * np.asarray(p) - self.k_at(state[..., 0])
        return np.where(state[..., 1] > 0.0, np.abs(p) + q, closed)

    def outputs(self, state: Array) -> dict[str, Array]:
        """plastic_strain, gap, and damage: the share of what softening takes that is lost."""
        state = np.asarray(state)
        lost = 1.0 - strength_left(state[..., 0], self.softening_strain)
        return {"plastic_strain": state[..., 0], "gap": state[..., 1], "damage": lost}

    @property
    def tangent_over_elastic(self) -> float:
        """See `Law`; of the cones at the beginning and at the end, with the dilation of the beginning."""
        first, last = (cone_slope(angle, self.cone, self.dilation_angle)
                       for angle in (self.friction_angle, self.residual_friction_angle))  # fmt: skip
        dilation = float(dilation_slope(self.dilation_angle, self.cone))
        cones = [cone_return(float(first), dilation), cone_return(float(last), dilation), cone_return(float(last), 0.0)]
        return stiffest_over_elastic(self.bulk_modulus, self.shear_modulus, cones)

    def parameters(self) -> SofteningConeParameters:  # type: ignore[override]
        K, G = self.bulk_modulus, self.shear_modulus
        return SofteningConeParameters(
            K=K,
            G=G,
            per_3G=1.0 / (3.0 * G),
            per_K=1.0 / K,
            six_G2=6.0 * G * G,
            angle_left=float(np.radians(self.residual_friction_angle)),
            angle_loss=float(np.radians(self.friction_angle - self.residual_friction_angle)),
            cohesion_left=self.residual_cohesion,
            cohesion_loss=self.cohesion - self.residual_cohesion,
            per_strain=1.0 / self.softening_strain,
            dilation=float(np.radians(self.dilation_angle)),
            per_dilation_strain=0.0 if self.dilation_strain is None else 1.0 / self.dilation_strain,
            own=1.0 if self.nonlocal_length is None else 0.0,
            side=-1.0 if self.cone == "triaxial_extension" else 1.0,
            plane=1.0 if self.cone == "plane_strain" else 0.0,
        )
