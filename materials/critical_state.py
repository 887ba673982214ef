"""The Cam-Clay family: one yield ellipse and one return map, whose hardening variable ζ evolves in one of two ways."""

import functools
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from snowmpm.compiler import ti

from .arrays import Array
from .critical_state_return import (
    critical_state_return,
    ellipse_at,
    internal_variables,
    is_outside,
    return_problem,
)
from .elastic import elastic_trial, small_elastic_trial
from .ellipse import first_iterate, straight_point, straight_step
from .hardening import Hardening, HardeningKind, HardeningRate, in_reach
from .hencky import deviation_of_small_strain
from .invariant_return import h_of_invariants, stress_of_invariants
from .law import REDO, Law, NonNegative, Positive, StateVariable
from .packs import StagedUpdate, joined, part
from .substepping import substeps
from .symmetric import contract


class CriticalStateParameters(NamedTuple):
    """What the functions of the Cam-Clay family read."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]
    xi: float  # hardening rate ξ [-]
    beta: float  # β of intact bonds [-]
    p_fixed: float  # part of p₀ that does not harden [Pa]
    shear_stiffness: float  # 3G/M² [Pa]
    shear_square: float  # 6G²/M²: (q/M)² over e : e [Pa²]
    alpha: float  # bonds lost per plastic volume change, 0 where nothing softens [-]
    per_K: float  # 1/K [1/Pa]
    scale: float  # S of `hardening.py` [Pa]
    offset: float  # o of `hardening.py` [-]
    end: float  # ζ at which the strength is gone; a number, however far [-]
    tolerance: float  # error of a substep, of p₀ [-]
    per_alpha: float  # 1/α, 0 where nothing softens [-]


@functools.cache
def critical_state_update(return_map):
    """Update function (see `Law`) of a return map by name. state: ζ, and for a weak layer whether it has collapsed."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
        p_trial = -prm.K * volume
        zeta, collapsed = state[0], collapsed_of(prm, state)
        work, n_substeps = 0.0, 0
        if ti.static(return_map == "substepped"):
            w, radius, shear2, beta, _, _ = ellipse_at(prm, p_trial, deviator2, zeta, collapsed, "")
            if valid == 1 and is_outside(w, radius, shear2, beta):
                deviator, volume, zeta, work, n_substeps = substeps(prm, h_new, A, deviator, volume, zeta, collapsed)
                p_trial, deviator2 = -prm.K * volume, contract(deviator, deviator)
        p, ratio, zeta_new, collapsed_new, iterations, yielded = critical_state_return(
            prm, p_trial, deviator2, zeta, collapsed, return_map == "frozen"
        )
        state_new = state
        if yielded + n_substeps > 0:
            state_new = state_of(prm, state, zeta_new, collapsed_new)
            work += plastic_work(prm, p_trial, p, deviator2, ratio)
            h_new = h_of_invariants(prm.per_K, deviator, deviator2, p, ratio)
        tau = stress_of_invariants(prm.G, deviator, p, ratio)
        found = valid == 1 and iterations >= 0
        return h_new, tau, state_new, work, ti.select(found, iterations + n_substeps, -1)

    return update


@ti.func
def collapsed_of(prm: ti.template(), state):
    """1 where the bonds of a weak layer are gone, else 0."""
    collapsed = 0.0
    if ti.static(state.n > 1):
        collapsed = ti.select(prm.alpha > 0.0, state[1], 0.0)
    return collapsed


@ti.func
def state_of(prm: ti.template(), state, zeta, collapsed):
    """`state` with its new variables."""
    state_new = state
    state_new[0] = zeta
    if ti.static(state.n > 1):
        state_new[1] = ti.select(prm.alpha > 0.0, collapsed, state[1])
    return state_new


@ti.func
def plastic_work(prm: ti.template(), p_trial, p, deviator2, ratio):
    """τ : Δε_plastic of a return from p_trial and e to p and ratio e."""
    return p * (p_trial - p) * prm.per_K + 2.0 * prm.G * deviator2 * ratio * (1.0 - ratio)


@functools.cache
def critical_state_vector_update(return_map, hardening, weak):
    """`StagedUpdate` of that update for states that are near enough: "implicit" or "frozen", of one kind of hardening;
    weak: whether α may be more than 0.

    Held are, from the places below on: the iterate of `straight_step`, the trial state: 1 if it could be found in a
    straight line, p, e : e; what `return_problem` found, but v, the last five numbers of it only where they are not
    those of every particle; h, e.
    """
    frozen = return_map == "frozen"
    special = frozen or weak
    numbers = PROBLEM + (10 if special else 5)

    @ti.func
    def begin(prm: ti.template(), h, state, A, dt):
        h_trial, deviator, volume, deviator2, possible = small_elastic_trial(h, A)
        valid = ti.select(possible == 1 and in_reach(prm.xi * state[0], prm.offset), 1.0, 0.0)
        p_trial = -prm.K * volume
        collapsed = collapsed_of(prm, state) if ti.static(weak) else 0.0
        yielded, separated, zeta0, rate, collapsed, beta, p_fixed, value, side, start, end = return_problem(
            prm, p_trial, deviator2, state[0], collapsed, frozen, hardening, weak
        )
        going = valid * ti.cast(yielded * (1 - separated), float)
        trial = ti.Vector([valid, p_trial, deviator2])
        problem = ti.Vector(
            [
                ti.cast(yielded, float), ti.cast(separated, float), side, start, end, zeta0, rate, collapsed, beta,
                p_fixed,
            ]
        )  # fmt: skip
        found = joined(joined(trial, part(problem, 0, ti.static(numbers - PROBLEM))), joined(h_trial, deviator))
        return joined(first_iterate(going, start, value, prm.offset), found)

    @ti.func
    def special_of(prm: ti.template(), state, held):
        """ζ₀, dζ/dΔz, `collapsed` after the step, β, p_fixed."""
        found = ti.Vector([state[0], 1.0, 0.0, prm.beta, prm.p_fixed])
        if ti.static(special):
            found = part(held, PROBLEM + 5, 5)
        return found

    @ti.func
    def equation(prm: ti.template(), rate, beta, held):
        """What `straight_step` and `straight_point` are to solve: p_trial, e², K, κ, dt/dΔz, S."""
        shape, growth, scale = 1.0 + 2.0 * beta, prm.xi * rate, prm.scale
        if ti.static(frozen):
            growth, scale = 0.0, 0.0
        e2, kappa = shape * prm.shear_square * held[TRIAL + 2], shape * prm.shear_stiffness
        return held[TRIAL + 1], e2, prm.K, kappa, growth, scale

    @ti.func
    def step(prm: ti.template(), state, held):
        _, rate, _, beta, p_fixed = special_of(prm, state, held)
        p_trial, e2, bulk, kappa, growth, scale = equation(prm, rate, beta, held)
        return straight_step(
            p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, held[PROBLEM + 2], held[PROBLEM + 3],
            held[PROBLEM + 4], part(held, ITERATE, TRIAL)
        )  # fmt: skip

    @ti.func
    def end(prm: ti.template(), state, held, yields: ti.template()):
        entries = ti.static((held.n - numbers) // 2)
        h_new, deviator = part(held, numbers, entries), part(held, ti.static(held.n - entries), entries)
        valid, p_trial, deviator2 = held[TRIAL] > 0.0, held[TRIAL + 1], held[TRIAL + 2]
        p, ratio, work, state_new, iterations = p_trial, 1.0, 0.0, state, 0
        if ti.static(yields):
            yielded, separated = held[PROBLEM] > 0.0, held[PROBLEM + 1] > 0.0
            zeta0, rate, collapsed_new, beta, p_fixed = special_of(prm, state, held)
            _, e2, bulk, kappa, growth, scale = equation(prm, rate, beta, held)
            iterate = part(held, ITERATE, TRIAL)
            p, ratio = straight_point(p_trial, e2, bulk, kappa, growth, beta, p_fixed, scale, iterate)
            p, ratio = ti.select(separated, 0.0, p), ti.select(separated, 0.0, ratio)
            collapsed = collapsed_of(prm, state) if ti.static(weak) else 0.0
            zeta, collapsed = internal_variables(prm, p_trial, p, zeta0, rate, collapsed, collapsed_new, frozen)
            p, ratio = ti.select(yielded, p, p_trial), ti.select(yielded, ratio, 1.0)
            h_plastic, near = deviation_of_small_strain(deviator, -p * prm.per_K, deviator2, ratio)
            h_new = ti.select(yielded, h_plastic, h_new)
            state_new = ti.select(yielded, state_of(prm, state, zeta, collapsed), state)
            work = ti.select(yielded, plastic_work(prm, p_trial, p, deviator2, ratio), 0.0)
            converged = held[ITERATE] == 0.0 and held[ITERATE + 5] >= 0.0
            valid = valid and (not yielded or (converged and near and in_reach(prm.xi * zeta, prm.offset)))
            iterations = ti.cast(held[ITERATE + 5], ti.i32)
        tau = stress_of_invariants(prm.G, deviator, p, ratio)
        return h_new, tau, state_new, work, ti.select(valid, iterations, REDO)

    return StagedUpdate(
        begin, first=ITERATE, step=((step, ITERATE),), end=end, going=ITERATE, changed=PROBLEM, numbers=numbers
    )


ITERATE, TRIAL, PROBLEM = 0, 6, 9
"""Where what is held of a lane begins, see `critical_state_vector_update`."""


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

    critical_slope: Positive
    """M: q/p in the critical state without cohesion [-]"""
    hardening: HardeningRate
    """rate ξ of hardening, of `p0` with plastic compaction [-]"""
    p0: NonNegative
    """isotropic yield pressure at the start [Pa]"""
    hardening_law: HardeningKind = "sinh"
    """sinh: of snow, parts without bonds at zero compaction; exponential: the classical law of clays"""
    return_map: Literal["implicit", "frozen", "substepped"] = "implicit"
    """implicit: backward Euler; frozen: on the yield surface of the step's start, for comparison; substepped: explicit
    substeps with control of their error"""
    substep_tolerance: Positive = 1e-4
    """substepped: error of a substep, of p0 [-]"""

    @property
    def update(self) -> Any:
        return critical_state_update(self.return_map)

    @property
    def vector_update(self) -> Any:
        if self.return_map == "substepped":
            return None
        kind = "sinh" if self.hardening_part.offset else "exponential"
        return critical_state_vector_update(self.return_map, kind, self.alpha > 0.0)

    @property
    def hardening_part(self) -> Hardening:
        """`Hardening` of these parameters."""
        return Hardening.of(self.hardening_law, self.bulk_modulus, self.hardening, self.p0)

    @property
    def beta(self) -> float:
        """β: tensile strength (apex of the ellipse at p = −β p₀) over compressive strength [-]."""
        return 0.0

    @property
    def alpha(self) -> float:
        """α: bonds lost per plastic volume change, 0 for a law that hardens from the start [-]."""
        return 0.0

    @property
    def associated(self) -> bool:
        return self.return_map == "implicit"

    @property
    def tensile_strength(self) -> float:
        return self.beta * self.p0

    @property
    def integration(self) -> str:
        return self.return_map

    @property
    def initial_zeta(self) -> float:
        """ζ₀ [-]"""
        return self.hardening_part.start

    def p0_at(self, zeta: Array) -> Array:
        """p₀ [Pa] at the hardening variable ζ. NumPy."""
        return self.hardening_part.p0(zeta)

    def beta_at(self, state: Array) -> float | Array:
        """β that belongs to state (..., n_state). NumPy."""
        return self.beta

    def critical_hardening(self) -> float:
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
        limits = elastic[falls] / (y_p[falls] * y_p0[falls] * slope) if slope > 0.0 else np.zeros(0)
        return float(limits.min()) if len(limits) else np.inf

    def yield_of_invariants(self, p: Array, q: Array, state: Array) -> Array:
        """y(p, q) [Pa²] at state (..., n_state), <= 0 where admissible. NumPy."""
        state = np.asarray(state)
        p0, beta = self.p0_at(state[..., 0]), self.beta_at(state)
        return (1.0 + 2.0 * beta) * np.square(q) + self.critical_slope**2 * (p + beta * p0) * (p - p0)

    def outputs(self, state: Array) -> dict[str, Array]:
        """p0 [Pa] and damage, the share of the initial strength that is lost (1: no bonds left)."""
        p0 = self.p0_at(np.asarray(state)[..., 0])
        left = p0 / self.p0 if self.p0 > 0.0 else np.zeros_like(p0)
        return {"p0": p0, "damage": 1.0 - np.clip(left, 0.0, 1.0)}

    def parameters(self) -> CriticalStateParameters:
        K, G, slope2, part = self.bulk_modulus, self.shear_modulus, self.critical_slope**2, self.hardening_part
        return CriticalStateParameters(
            K=K,
            G=G,
            xi=part.rate,
            beta=self.beta,
            p_fixed=part.fixed,
            shear_stiffness=3.0 * G / slope2,
            shear_square=6.0 * G * G / slope2,
            alpha=self.alpha,
            per_K=1.0 / K,
            scale=part.scale,
            offset=part.offset,
            end=max(part.end, -1e20),
            tolerance=self.substep_tolerance,
            per_alpha=1.0 / max(self.alpha, 1e-30) if self.alpha > 0.0 else 0.0,
        )

    def initial_state(self) -> tuple[float, ...]:
        return (self.initial_zeta,)

    def severed_state(self) -> tuple[float, ...] | None:
        return (self.hardening_part.end,) if self.hardening > 0.0 else None
