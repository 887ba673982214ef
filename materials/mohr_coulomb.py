"""Mohr-Coulomb plasticity: friction, dilation and cohesion on the six faces of a pyramid, its edges and its apex."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .elastic import elastic_trial
from .invariant_return import h_of_invariants, stress_of_invariants
from .law import Law, NonNegative, StateVariable
from .return_tangent import pyramid_returns, stiffest_over_elastic
from .spectral import compose, eigen_of_deviator
from .tension_gap import GAP, trial_behind_gap
from .von_mises import PLASTIC_STRAIN

NEVER = 1e30  # tensile strength [Pa] that nothing reaches, within float32


class MohrCoulombParameters(NamedTuple):
    """What the update of `MohrCoulomb` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    sin_phi: float  # sin φ [-]
    sin_psi: float  # sin ψ [-]
    apex: float  # c cot φ, at most `NEVER` [Pa]
    strength: float  # 2 c cos φ [Pa]
    per_face: float  # 1/a [1/Pa]
    per_compression_edge: float  # 1/(a + b) where σ₂ = σ₃ [1/Pa]
    per_largest: float  # 1/(1 + sin ψ/3): multiplier that leaves no deviator, from the largest strain [-]
    per_smallest: float  # 1/(1 − sin ψ/3): the same from the smallest [-]
    dilation_pressure: float  # 2 λ sin ψ: λ tr of the plastic strain, per multiplier [Pa]
    per_extension_edge: float  # 1/(a + b) where σ₁ = σ₂ [1/Pa]
    per_K: float  # 1/K [1/Pa]
    inner_alpha: float  # α of the cone inscribed in the pyramid [-]
    inner_k: float  # k of that cone [Pa]
    six_G2: float  # 6G²: q² over e : e [Pa²]
    per_2G: float  # 1/(2G) [1/Pa]
    cohesionless: float  # 1 if nothing is cohesive, else 0


@ti.func
def mohr_coulomb_return(prm: ti.template(), strain, p_trial):
    """Return map in principal values, largest first. Stresses and strains are positive in tension.

    strain: deviatoric principal Hencky strains (3,) of the trial state; p_trial: its pressure [Pa], positive in
    compression.
    Returns principal Kirchhoff stresses (3,) [Pa]; dissipation [J per m3 of reference volume]; the volume strain at the
    apex beyond what flow dilates, 0 elsewhere; and 1 if the state yields, else 0.
    """
    G, sin_phi, sin_psi, apex = prm.G, prm.sin_phi, prm.sin_psi, prm.apex
    s = 2.0 * G * strain - p_trial
    work, opened, yielded = 0.0, 0.0, 0
    excess = (s[0] - s[2]) + (s[0] + s[2]) * sin_phi - prm.strength
    if excess > 0.0:
        yielded = 1
        # Multiplier that leaves no deviator, and the opening that is left over when its dilation has taken place
        without = ti.max(strain[0] * prm.per_largest, -strain[2] * prm.per_smallest)
        opened = -(p_trial + apex) * prm.per_K - 2.0 * sin_psi * without
        if opened > 0.0:
            s = ti.Vector([apex, apex, apex])
            work = apex * (2.0 * sin_psi * without + opened)
        else:
            opened = 0.0
            gamma = excess * prm.per_face
            volume = prm.dilation_pressure * gamma  # λ tr of the plastic strain γ (1 + sin ψ, 0, −(1 − sin ψ))
            face = s - volume
            face[0] -= 2.0 * G * gamma * (1.0 + sin_psi)
            face[2] += 2.0 * G * gamma * (1.0 - sin_psi)
            if face[1] > face[0] or face[1] < face[2]:
                # An edge: the middle face (1, 2) yields too (σ₂ = σ₃ at the end), or (2, 3) does (σ₁ = σ₂)
                right = (1.0 - sin_psi) * s[0] - 2.0 * s[1] + (1.0 + sin_psi) * s[2] > 0.0
                a, b = ti.select(right, s[0], s[1]), ti.select(right, s[1], s[2])
                other = (a - b) + (a + b) * sin_phi - prm.strength
                gamma = (excess + other) * ti.select(right, prm.per_compression_edge, prm.per_extension_edge)
                # The smallest stress; of two equal ones the mean, which does not change with how their faces share γ
                face[2] = ti.select(right, 0.5 * (s[1] + s[2]), s[2]) - prm.dilation_pressure * gamma
                face[2] += ti.select(right, 1.0, 2.0) * G * gamma * (1.0 - sin_psi)
                face[1] = ti.select(right, -NEVER, NEVER)
            # The largest stress from the smallest: on the surface to round-off, however far away the trial state is
            s[2] = ti.min(face[2], apex)
            s[0] = (s[2] * (1.0 - sin_phi) + prm.strength) / (1.0 + sin_phi)
            s[1] = ti.min(ti.max(face[1], s[2]), s[0])
            work = gamma * (prm.strength - (s[0] + s[2]) * (sin_phi - sin_psi))
    return s, work, opened, yielded


@ti.func
def mohr_coulomb_update(prm: ti.template(), h, state, A, dt):
    """See `Law`. state: plastic strain, gap."""
    h_new, deviator, deviator2, p, factor, gap, valid = trial_behind_gap(elastic_trial, h, A, prm.K, state[1])
    state_new = state
    state_new[1] = gap
    dissipation, iterations, changed = 0.0, 0, factor < 1.0
    # Within the cone inscribed in the pyramid nothing yields: no eigenvectors for most of a body at rest
    inner = ti.max(prm.inner_alpha * p + prm.inner_k, 0.0)
    if valid == 1 and factor > 0.0 and prm.six_G2 * factor * factor * deviator2 >= inner * inner:
        w, V = eigen_of_deviator(deviator, deviator2)
        w *= factor
        s, work, opened, yielded = mohr_coulomb_return(prm, w, p)
        if yielded == 1:
            changed = True
            iterations = 1
            dissipation = work
            p = -(s[0] + s[1] + s[2]) / 3.0
            after = (s + p) * prm.per_2G
            state_new[0] += ti.sqrt((w - after).norm_sqr() * ti.static(2.0 / 3.0))
            state_new[1] = gap + opened * prm.cohesionless
            deviator, deviator2, factor = compose(after, V, deviator), after.norm_sqr(), 1.0
    if changed:
        h_new = h_of_invariants(prm.per_K, deviator, deviator2, p, factor)
    tau = stress_of_invariants(prm.G, deviator, p, factor)
    return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, -1)


class MohrCoulomb(Law):
    """Mohr-Coulomb with non-associated flow, on Hencky elasticity in principal space.

        y(τ) = (σ₁ − σ₃) + (σ₁ + σ₃) sin φ − 2 c cos φ <= 0    principal Kirchhoff stresses, tension positive, σ₁ >= σ₃
        flow on a face: dε^p = dγ (1 + sin ψ, 0, −(1 − sin ψ))   ψ <= φ; on an edge that of its two faces together;
        at the apex σ₁ = σ₂ = σ₃ = c cot φ any dilation beyond that

    de Souza Neto, Perić & Owen, Computational Methods for Plasticity (2008), section 8.2, and chapter 14 for finite
    strain: Hencky strain and isotropy leave the principal axes of the trial state in place and the return that of small
    strain. With linear elasticity it is in closed form and exact for straight steps of any size:

        face   Δγ = y_tr / a,                a = 4G (1 + sin φ sin ψ / 3) + 4K sin φ sin ψ
        edge   Δγ_a + Δγ_b = (y_a + y_b) / (a + b),   b = 2G (1 ± sin φ ± sin ψ − sin φ sin ψ / 3) + 4K sin φ sin ψ,
               + where σ₂ = σ₃ (triaxial compression), − where σ₁ = σ₂
        apex   where that much flow as leaves no deviator dilates less than p_tr asks for

    In terms of Coulomb: |τ| = c + σ_n tan φ on the plane that is closest to it; σ₂ does not matter. Triaxial strength
    σ_axial = K_p σ_lateral + 2 c √K_p, K_p = (1 + sin φ)/(1 − sin φ). φ = 0 is Tresca's law of shear strength c.
    Separation as in `DruckerPrager`: without cohesion, what opens at the apex is a gap that must close before stress
    comes back; with cohesion the apex stress is kept. Dissipation Δγ (2 c cos φ − (σ₁ + σ₃)(sin φ − sin ψ)) >= 0.
    Deviation from the reference: the apex is told from the edges before either is computed, and the multipliers of an
    edge are never separated.
    Validity: dilation does not end at a critical density; for large shear take ψ = 0.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (PLASTIC_STRAIN, GAP)
    OUTPUTS: ClassVar[dict[str, str]] = {"plastic_strain": "-", "gap": "-"}

    kind: Literal["mohr_coulomb"] = "mohr_coulomb"
    friction_angle: Annotated[float, Field(ge=0.0, lt=90.0)]
    """φ; 0 is Tresca's law [degrees]"""
    dilation_angle: Annotated[float, Field(ge=0.0, lt=90.0)] = 0.0
    """ψ, at most the friction angle [degrees]"""
    cohesion: NonNegative = 0.0
    """c of Coulomb's line [Pa]"""

    update = staticmethod(mohr_coulomb_update)

    @model_validator(mode="after")
    def _consistent(self):
        if self.dilation_angle > self.friction_angle:
            raise ValueError("dilation_angle must not exceed friction_angle: flow would create energy")
        if self.friction_angle == 0.0 and self.cohesion == 0.0:
            raise ValueError("friction_angle 0 needs cohesion: there is no other strength")
        return self

    @property
    def tensile_apex(self) -> float:
        """c cot φ [Pa]: the isotropic tension that is carried; inf for φ = 0."""
        if self.cohesion == 0.0:
            return 0.0
        slope = float(np.tan(np.radians(self.friction_angle)))
        return self.cohesion / slope if slope > 0.0 else np.inf

    @property
    def tensile_strength(self) -> float:
        return self.tensile_apex

    @property
    def tangent_over_elastic(self) -> float:
        s, t = (float(np.sin(np.radians(angle))) for angle in (self.friction_angle, self.dilation_angle))
        return stiffest_over_elastic(self.bulk_modulus, self.shear_modulus, pyramid_returns(s, t))

    @property
    def friction_exceeds_dilation(self) -> bool:
        return self.dilation_angle < self.friction_angle

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """y [Pa]; where a gap is open, no stress but zero is admissible: |σ|. NumPy."""
        values = np.linalg.eigvalsh(np.asarray(stress, float))
        s, cos = np.sin(np.radians(self.friction_angle)), np.cos(np.radians(self.friction_angle))
        least, most = values[..., 0], values[..., 2]
        closed = (most - least) + (most + least) * s - 2.0 * self.cohesion * cos
        return np.where(np.asarray(state)[..., 1] > 0.0, np.abs(values).max(axis=-1), closed)

    def outputs(self, state: Array) -> dict[str, Array]:
        """plastic_strain and gap."""
        state = np.asarray(state)
        return {"plastic_strain": state[..., 0], "gap": state[..., 1]}

    def parameters(self) -> MohrCoulombParameters:
        K, G, c = self.bulk_modulus, self.shear_modulus, self.cohesion
        s, t = (float(np.sin(np.radians(angle))) for angle in (self.friction_angle, self.dilation_angle))
        cos = float(np.cos(np.radians(self.friction_angle)))
        both = 4.0 * K * s * t
        a = 4.0 * G * (1.0 + s * t / 3.0) + both
        right, left = (2.0 * G * (1.0 + side * (s + t) - s * t / 3.0) + both for side in (1.0, -1.0))
        inner = 3.0 / float(np.sqrt(3.0 + s * s))
        return MohrCoulombParameters(
            K=K,
            G=G,
            sin_phi=s,
            sin_psi=t,
            apex=min(self.tensile_apex, NEVER),
            strength=2.0 * c * cos,
            per_face=1.0 / a,
            per_compression_edge=1.0 / (a + right),
            per_largest=1.0 / (1.0 + t / 3.0),
            per_smallest=1.0 / (1.0 - t / 3.0),
            dilation_pressure=2.0 * (K - 2.0 / 3.0 * G) * t,
            per_extension_edge=1.0 / (a + left),
            per_K=1.0 / K,
            inner_alpha=inner * s,
            inner_k=inner * c * cos,
            six_G2=6.0 * G * G,
            per_2G=0.5 / G,
            cohesionless=0.0 if c > 0.0 else 1.0,
        )

    def initial_state(self) -> tuple[float, ...]:
        return 0.0, 0.0
