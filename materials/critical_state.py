"""The Cam-Clay family: one yield ellipse and one return map, whose hardening variable ζ evolves in one of two ways."""

import functools
from typing import ClassVar, Literal

import numpy as np
import taichi as ti

from .critical_state_return import critical_state_return, ellipse_at, is_outside
from .hardening import Hardening, HardeningKind, HardeningRate, in_reach
from .invariant_return import GENERAL, STRAIGHT, stress_of_invariants
from .law import Law, NonNegative, Positive, StateVariable
from .precision import by_precision, larger
from .substepping import substeps
from .symmetric import contract

STEPS = (2, 2)
"""Newton steps in a straight line, float32 and float64."""


@functools.cache
def critical_state_update(return_map, form):
    """Update function (see `Law`) of a return map by name, "substepped" in the general `Form` only.

    prm: `CriticalStateLaw.parameters`; state: ζ, and for a weak layer whether it has collapsed.
    """

    steps = STEPS if form.straight else (0, 0)

    @ti.func
    def update(prm, h, state, A, dt):
        h_new, deviator, volume, deviator2, valid = form.trial(h, A)
        p_trial = -prm[0] * volume
        zeta, collapsed = state[0], 0.0
        if ti.static(state.n > 1):
            collapsed = ti.select(prm[7] > 0.0, state[1], 0.0)
        work, n_substeps = 0.0, 0
        if ti.static(return_map == "substepped"):
            w, radius, shear2, beta, _, _ = ellipse_at(prm, p_trial, deviator2, zeta, collapsed, False)
            if valid == 1 and is_outside(w, radius, shear2, beta):
                deviator, volume, zeta, work, n_substeps = substeps(prm, h_new, A, deviator, volume, zeta, collapsed)
                p_trial, deviator2 = -prm[0] * volume, contract(deviator, deviator)
        p, ratio, zeta_new, collapsed_new, iterations, yielded = critical_state_return(
            prm, p_trial, deviator2, zeta, collapsed, return_map == "frozen",
            ti.static(by_precision(*steps))
        )
        state_new = state
        dissipation = work
        if yielded + n_substeps > 0:
            state_new[0] = zeta_new
            if ti.static(state.n > 1):
                state_new[1] = ti.select(prm[7] > 0.0, collapsed_new, state[1])
            dissipation += p * (p_trial - p) * prm[8] + 2.0 * prm[1] * deviator2 * ratio * (1.0 - ratio)
            h_new, near = form.h(prm[8], deviator, deviator2, p, ratio)
            valid *= near
        if ti.static(form.straight):
            valid *= ti.select(in_reach(prm[2] * larger(zeta, zeta_new), prm[10]), 1, 0)
        tau = stress_of_invariants(prm[1], deviator, p, ratio)
        found = valid == 1 and iterations >= 0
        return h_new, tau, state_new, dissipation, ti.select(found, iterations + n_substeps, form.failed)

    return update


class CriticalStateLaw(Law):
    """Yield ellipse in (p, q) whose size is the preconsolidation pressure p₀ [Pa]:

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0
        p₀ = K sinh(ξ max(ζ, 0)),   initially ζ₀ = asinh(p₀/K) / ξ     (others: see `hardening.py`)

    ξ = 0 is perfect plasticity: p₀ keeps its value. β <= 1: no stronger in tension than in compression.

    return_map: "implicit", backward Euler with hardening, first order, admissible at the new p₀ for a step of any size;
    "frozen", the same with p₀ of the last step, which leaves the new surface by what p₀ changed; "substepped", the
    flow equations along the step by modified Euler with error control (`substepping.py`), second order.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "ζ = −ln det Fp, the plastic compaction that sets p0; <= 0 separated"),
    )
    OUTPUTS: ClassVar[dict[str, str]] = {"p0": "Pa", "damage": "-"}

    critical_slope: Positive  # M, q/p at critical state for β = 0 [-]
    hardening: HardeningRate  # ξ [-]
    p0: NonNegative  # initial p₀ [Pa]
    hardening_law: HardeningKind = "sinh"
    return_map: Literal["implicit", "frozen", "substepped"] = "implicit"
    substep_tolerance: Positive = 1e-4  # error of a substep, of p₀ [-]

    @property
    def update(self):
        return critical_state_update(self.return_map, GENERAL)

    @property
    def lanes(self):
        return None if self.return_map == "substepped" else critical_state_update(self.return_map, STRAIGHT)

    @property
    def hardening_part(self):
        """`Hardening` of these parameters."""
        return Hardening.of(self.hardening_law, self.bulk_modulus, self.hardening, self.p0)

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
        return self.hardening_part.start

    def p0_at(self, zeta):
        """p₀ [Pa] at the hardening variable ζ. NumPy."""
        return self.hardening_part.p0(zeta)

    def beta_at(self, state):
        """β that belongs to state (..., n_state). NumPy."""
        return self.beta

    def critical_hardening(self):
        """Largest ξ [-] up to which softening under strain control has one answer, at the initial p₀.

        Associated flow is unique while  K y_p² + 3G y_q² > y_p y_p₀ dp₀/dz  on the whole dilating side of the ellipse,
        dp₀/dz = ξ √(K² + p₀²) (sinh) or ξ p₀ (exponential); beyond, a step may jump to the separated state, and the
        energy that is dissipated depends on the step. A weak layer softens with α dz: its limit is this over α.
        Infinite without dilation.
        """
        K, G, p0, beta, slope2 = self.bulk_modulus, self.shear_modulus, self.p0, self.beta, self.critical_slope**2
        angle = np.pi * (1.0 - 0.5 * np.linspace(0.0, 1.0, 20001)[:-1] ** 2)  # from the apex, closest there
        w, radius = 0.5 * (1.0 + beta) * np.cos(angle), 0.5 * (1.0 + beta) * np.sin(angle)
        p, shear2 = w + 0.5 * (1.0 - beta), slope2 * radius**2 * (1.0 + 2.0 * beta)  # of p₀; (1 + 2β)² q²
        y_p, y_p0 = 2.0 * slope2 * w, -slope2 * ((1.0 - beta) * p + 2.0 * beta)
        elastic = K * y_p**2 + 12.0 * G * shear2
        falls = y_p * y_p0 > 0.0
        part = Hardening.of(self.hardening_law, K, 1.0, p0)
        slope = np.hypot(part.scale * np.sqrt(part.offset), p0)  # dp₀/dz over ξ
        limits = elastic[falls] / (y_p[falls] * y_p0[falls] * slope) if slope > 0.0 else ()
        return float(limits.min()) if len(limits) else np.inf

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
        """K, G, ξ, β, p_fixed, 3G/M², 6G²/M², α, 1/K, S, o, ζ at the end of the strength, tolerance of a substep."""
        K, G, slope2, part = self.bulk_modulus, self.shear_modulus, self.critical_slope**2, self.hardening_part
        surface = K, G, part.rate, self.beta, part.fixed, 3.0 * G / slope2, 6.0 * G * G / slope2, self.alpha, 1.0 / K
        return *surface, part.scale, part.offset, max(part.end, -1e20), self.substep_tolerance

    def initial_state(self):
        return (self.initial_zeta,)

    def severed_state(self):
        return (self.hardening_part.end,) if self.hardening > 0.0 else None
