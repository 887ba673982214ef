"""The Cam-Clay family: one yield ellipse and one return map, whose hardening variable ζ evolves in one of two ways."""

from typing import ClassVar

import numpy as np
import taichi as ti

from .elastic import elastic_trial
from .ellipse import YIELD_TOLERANCE, return_to_ellipse, sinh_positive
from .hencky import deviation_of_strain
from .law import Law, NonNegative, Positive, StateVariable
from .precision import by_precision
from .symmetric import plus_isotropic


@ti.func
def critical_state_return(prm, p_trial, deviator2, zeta, collapsed):
    """Return map in (p, q): p, factor on the deviator, ζ, collapsed, Newton iterations, and 1 if the state yields.

    prm: `CriticalStateLaw.parameters`; deviator2: e : e of the trial Hencky strain. With Δz the plastic compaction of
    the step, ζ changes by Δz (hardening), or by −α |Δz| while the bonds of a weak layer last (α > 0, collapsed = 0).
    """
    K, xi, p_fixed, alpha, per_K = prm[0], prm[2], prm[4], prm[7], prm[8]
    softens = alpha > 0.0 and collapsed == 0.0
    beta = ti.select(collapsed == 0.0, prm[3], 0.0)
    shear2 = prm[6] * deviator2
    sinh = sinh_positive(xi * zeta)
    p0 = p_fixed + K * sinh
    w = p_trial - 0.5 * (1.0 - beta) * p0
    radius = 0.5 * (1.0 + beta) * p0
    p, ratio, iterations, yielded = p_trial, 1.0, 0, 0
    zeta_new, collapsed_new = zeta, collapsed
    if w * w + (1.0 + 2.0 * beta) * shear2 > radius * radius * ti.static(1.0 + by_precision(*YIELD_TOLERANCE)):
        yielded = 1
        side = ti.select(w > 0.0, 1.0, -1.0)
        collapse = zeta / ti.max(alpha, ti.static(by_precision(1e-30, 1e-300)))  # |Δz| of complete softening
        # ζ = zeta0 + rate Δz; `gap` is the Δz at which a dilating ellipse has shrunk to a point
        zeta0, rate = zeta, ti.select(softens, -alpha * side, 1.0)
        gap = ti.select(softens, -collapse, ti.select(p_fixed > 0.0, ti.static(by_precision(-1e30, -1e300)), -zeta))
        if p_trial <= K * gap:
            # Dilates until p₀ = 0 and beyond: separated and stress-free
            p, ratio = 0.0, 0.0
            zeta0, rate = -gap, 1.0
            collapsed_new = ti.select(softens, 1.0, collapsed)
        else:
            # A compacting weak layer may use up its bonds within the step: it is then solved as collapsed, without
            # cohesion. Separated snow that is compacted first closes its gap, without stress.
            through = softens and w > 0.0 and p_trial >= K * collapse
            start = ti.select(through, collapse, ti.max(gap, 0.0))
            end = ti.select(w > 0.0, ti.select(softens, p_trial, w) * per_K, ti.max(w * per_K, gap))
            zeta0, rate = ti.select(through, -collapse, zeta), ti.select(through, 1.0, rate)
            sinh = ti.select(through, 0.0, sinh)
            beta = ti.select(through, 0.0, beta)
            collapsed_new = ti.select(through, 1.0, collapsed)
            shape = 1.0 + 2.0 * beta
            p, ratio, iterations = return_to_ellipse(
                p_trial, shape * shear2, K, shape * prm[5], xi, beta, p_fixed, zeta0, rate, sinh, side, start, end
            )
        zeta_new = zeta0 + rate * ((p_trial - p) * per_K)
    return p, ratio, zeta_new, collapsed_new, iterations, yielded


@ti.func
def critical_state_update(prm, h, state, A, dt):
    """See `Law`. prm: `CriticalStateLaw.parameters`; state: ζ, and for a weak layer whether it has collapsed."""
    h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
    p_trial = -prm[0] * volume
    collapsed = 0.0
    if ti.static(state.n > 1):
        collapsed = state[1]
    p, ratio, zeta, collapsed_new, iterations, yielded = critical_state_return(
        prm, p_trial, deviator2, state[0], ti.select(prm[7] > 0.0, collapsed, 0.0)
    )
    state_new = state
    dissipation = 0.0
    if yielded == 1:
        state_new[0] = zeta
        if ti.static(state.n > 1):
            state_new[1] = ti.select(prm[7] > 0.0, collapsed_new, collapsed)
        dissipation = p * (p_trial - p) * prm[8] + 2.0 * prm[1] * deviator2 * ratio * (1.0 - ratio)
        if ratio == 0.0:
            h_new.fill(0.0)  # separated: stress-free, the common case in a flow
        else:
            h_new = deviation_of_strain(deviator, -p * prm[8], deviator2, ratio)
    tau = plus_isotropic((2.0 * prm[1] * ratio) * deviator, -p)
    return h_new, tau, state_new, dissipation, ti.select(valid == 1, iterations, -1)


class CriticalStateLaw(Law):
    """Yield ellipse in (p, q) whose size is the preconsolidation pressure p₀ [Pa]:

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0
        p₀ = K sinh(ξ max(ζ, 0)),   initially ζ₀ = asinh(p₀/K) / ξ

    ξ = 0 is perfect plasticity: p₀ keeps its value. β <= 1: no stronger in tension than in compression.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "ζ = −ln det Fp, the plastic compaction that sets p0; <= 0 separated"),
    )
    OUTPUTS: ClassVar[dict[str, str]] = {"p0": "Pa", "damage": "-"}

    update = staticmethod(critical_state_update)

    critical_slope: Positive  # M, q/p at critical state for β = 0 [-]
    hardening: NonNegative  # ξ [-]
    p0: NonNegative  # initial p₀ [Pa]

    @property
    def beta(self):
        """β: tensile strength (apex of the ellipse at p = −β p₀) over compressive strength [-]."""
        return 0.0

    @property
    def alpha(self):
        """α: bonds lost per plastic volume change, 0 for a law that hardens from the start [-]."""
        return 0.0

    @property
    def initial_zeta(self):
        """ζ₀ [-]"""
        return float(np.arcsinh(self.p0 / self.bulk_modulus) / self.hardening) if self.hardening > 0.0 else 0.0

    def p0_at(self, zeta):
        """p₀ [Pa] at the hardening variable ζ. NumPy."""
        if self.hardening == 0.0:
            return np.full(np.shape(zeta), self.p0)
        return self.bulk_modulus * np.sinh(self.hardening * np.maximum(zeta, 0.0))

    def beta_at(self, state):
        """β that belongs to state (..., n_state). NumPy."""
        return self.beta

    def yield_of_invariants(self, p, q, state):
        """y(p, q) [Pa²] at state (..., n_state), <= 0 where admissible. NumPy."""
        state = np.asarray(state)
        p0, beta = self.p0_at(state[..., 0]), self.beta_at(state)
        return (1.0 + 2.0 * beta) * np.square(q) + self.critical_slope**2 * (p + beta * p0) * (p - p0)

    def outputs(self, state):
        """p0 [Pa] and damage, the share of the initial strength that is lost (1: no bonds left)."""
        p0 = self.p0_at(np.asarray(state)[..., 0])
        left = p0 / self.p0 if self.p0 > 0.0 else np.zeros_like(p0)
        return {"p0": p0, "damage": 1.0 - np.clip(left, 0.0, 1.0)}

    def parameters(self):
        """K, G, ξ, β, p₀ where it is fixed (ξ = 0) else 0, 3G/M², 6G²/M², α, 1/K."""
        K, G, slope2 = self.bulk_modulus, self.shear_modulus, self.critical_slope**2
        fixed = self.p0 if self.hardening == 0.0 else 0.0
        return K, G, self.hardening, self.beta, fixed, 3.0 * G / slope2, 6.0 * G * G / slope2, self.alpha, 1.0 / K

    def initial_state(self):
        return (self.initial_zeta,)

    def severed_state(self):
        return (0.0,) if self.hardening > 0.0 else None
