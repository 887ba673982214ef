"""Grains from rest to fast flow: friction that knows its density, and beside it the stress of collisions."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, PrivateAttr

from snowmpm.compiler import ti

from .arrays import Array
from .critical_state_hypoplastic import (
    CriticalStateHypoplastic,
    CriticalStateRateParameters,
    critical_state_modulus,
    critical_state_rate,
)
from .law import NonNegative, StateVariable
from .precision import by_precision
from .rate_integration import advance, outcome, rate_stiffness, stretching_of, turned
from .symmetric import COMPONENTS, both_products, contract, determinant, invariants, plus_isotropic, trace, unpack

COLLISIONAL, STRETCHING = 3, 9
"""Where the two tensors begin in the state, after what all rate laws have."""
HALVINGS = 20
"""Of the share of the collisional stress, where it would pull."""


class SolidToGasParameters(NamedTuple):
    """What the functions of `SolidToGas` read: first those of `CriticalStateRateParameters`."""

    apex: float
    log_floor: float
    void_ratio: float
    tolerance: float
    c1: float
    c2: float
    c3: float
    c4: float
    critical_limit: float
    critical_drop: float
    per_pressure: float
    density_effect: float
    per_effect_pressure: float
    least_void_ratio: float
    least_factor: float
    collision_time: float  # |A| [s]
    constant_share: float  # m₁ [-]
    square_share: float  # m₂ [s²]
    per_root_density: float  # 1/(√ρ₀ dx) [√(m/kg)], 0 without a grid


frictional_stiffness = rate_stiffness(critical_state_modulus)


@ti.func
def tensor_of(state, first: ti.template(), n: ti.template()):
    """The n entries of a tensor in the state."""
    return ti.Vector([state[first + k] for k in ti.static(range(n))])


@ti.func
def collided(prm: ti.template(), friction, before, old, new):
    """T_v at the end of a step, from T_v `before`, while the stretching goes from `old` to `new` under the frictional
    stress `friction` (Heun, second order): all in the frame at the end of the step."""
    change = new - old
    square = 0.5 * (contract(old, old) + contract(new, new))
    eta = -prm.collision_time * ti.sqrt(prm.constant_share + prm.square_share * square)
    first = eta * both_products(friction + before, change)
    return before + eta * both_products(friction + before + 0.5 * first, change)


@ti.func
def presses(stress):
    """Whether no principal stress is tensile."""
    total = -trace(stress)
    return total > 0.0 and total * total >= contract(stress, stress) and determinant(stress) <= 0.0


@ti.func
def pressing_share(friction, collisional):
    """Share of T_v with which grains press on each other along all axes, for no grain pulls: 1 nearly always; 0 where
    the frictional part separated, since what collides must touch."""
    share = 1.0
    if not presses(friction):
        share = 0.0
    elif not presses(friction + collisional):
        # Stresses that press are a convex set, in which friction lies
        pulls, share = 1.0, 0.0
        for _ in range(HALVINGS):
            middle = 0.5 * (share + pulls)
            if presses(friction + middle * collisional):
                share = middle
            else:
                pulls = middle
    return share


@ti.func
def solid_to_gas_update(prm: ti.template(), h, state, A, dt):
    """`Law.update` of `SolidToGas`."""
    tiny = ti.static(by_precision(1e-30, 1e-200))
    deviator, volume, deviator2, valid, B = stretching_of(A)
    collisional, old = tensor_of(state, COLLISIONAL, ti.static(h.n)), tensor_of(state, STRETCHING, ti.static(h.n))
    friction = h - collisional
    friction_new, state_new, dissipation, steps = advance(
        critical_state_rate, prm, friction, state, deviator, volume, deviator2, B
    )
    strain = plus_isotropic(deviator, volume * ti.static(1.0 / 3.0))
    before, old = turned(collisional, B), turned(old, B)
    new = ti.select(dt > 0.0, strain / ti.max(dt, tiny), old)
    after = collided(prm, 0.5 * (turned(friction, B) + friction_new), before, old, new)
    after *= pressing_share(friction_new, after)
    J = (1.0 + state[0]) / (1.0 + prm.void_ratio)
    dissipation += 0.5 * J * contract(before + after, strain)
    for k in ti.static(range(h.n)):
        state_new[COLLISIONAL + k] = after[k]
        state_new[STRETCHING + k] = new[k]
    return outcome(prm, h, state, friction_new + after, state_new, dissipation, steps, valid)


@ti.func
def solid_to_gas_stiffness(prm: ti.template(), tau, state):
    """ρ₀ c² of waves that collisions damp, see `SolidToGas`."""
    J = (1.0 + state[0]) / (1.0 + prm.void_ratio)
    collisional = tensor_of(state, COLLISIONAL, ti.static(tau.n))
    stretching = tensor_of(state, STRETCHING, ti.static(tau.n))
    modulus = frictional_stiffness(prm, tau - J * collisional, state)
    p = -trace(tau) / 3.0
    deviator = plus_isotropic(tau, p)
    largest = ti.abs(p) + ti.sqrt(ti.static(2.0 / 3.0) * contract(deviator, deviator))
    square = contract(stretching, stretching)
    viscosity = 2.0 * prm.collision_time * ti.sqrt(prm.constant_share + prm.square_share * square) * largest
    damping = viscosity * prm.per_root_density / ti.sqrt(modulus)
    return modulus * (ti.sqrt(1.0 + damping * damping) + damping) ** 2


class SolidToGas(CriticalStateHypoplastic):
    """Grains at rest, in slow and in fast flow: two stresses, of friction and of collisions.

        T = T_i + T_v,   T_i° = W-23 of T_i alone: `CriticalStateHypoplastic`                                [W 8-9]
        T_v° = η (T D° + D° T),   η = A √(m₁ + m₂ |D|²),   |D| = √(D : D)                                   [W 30-33]

    [W] Wu, Wang, Alipour, "Constitutive modelling for fast granular flow", ALERT Doctoral School 2020, eqs. 8-37. T is
    the Cauchy stress, tension positive, and momentum follows from T alone; °: Jaumann's rate; D: stretching. The
    collisional stress grows with the rate, as D while m₂ |D|² << m₁ and as |D|² beyond (Bagnold). There is one equation
    for all regimes: in faster shear under the same pressure collisions carry more of it, the frictional part unloads
    along its critical state, e grows, and so does the ratio of shear to normal stress.

    Names: collision_time |A| [s] (A itself is negative, [W] has it so), constant_share m₁ [-], square_share m₂ [s²].

    D° here is Jaumann's rate of D along the path, dD/dt + D W − W D: the law keeps the D of the step before, and T_v
    takes what D gained. Errata of [W]: eq. 27 has sym(grad a) for dD/dt, a the acceleration. That is dD/dt + D² + W²:
    it gives a stress to a body that only spins. In isochoric simple shear, which [W] uses it for, D² + W² = 0, and both
    are eqs. 36-37; m₁ has no unit (table 1: s); of the triaxial constants of table 1, see `CriticalStateHypoplastic`.
    Sums of what D gains do not enhance noise, as differences of accelerations over cells would.

    What [W] leaves open, and what is done here: where the frictional part separates there is no collisional one
    either; T_v is scaled down where it would make a principal stress of T tensile; there is no cohesion.

    Limits. T_v has a memory and nothing that forgets: at a constant rate its mean drifts by |η| γ̇ (T_xx − T_zz) per
    unit of shear (zero where the normal stresses are equal), and if T differs between speeding up and slowing down, a
    part of T_v stays at rest. Reversal, stopping and boundary-value problems are untested in [W].

    Cost: 1.1 to 1.25 times `CriticalStateHypoplastic` (tests/benchmarks/stress_update.py, both in one run).

    A collisional stress is a viscosity 2 |η| σ₁. With cells of size dx the wave speed for the step is
    c (ζ + √(1 + ζ²)), ζ = 2 |η| σ₁/(ρ c dx): the limit of a damped oscillator with damping that lags half a step.
    """

    kind: Literal["solid_to_gas"] = "solid_to_gas"  # type: ignore[assignment]

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        *CriticalStateHypoplastic.STATE,
        *(StateVariable(f"collisional_{c}", "Pa", f"{c} of T_v, the stress of collisions") for c in COMPONENTS),
        *(StateVariable(f"stretching_{c}", "1/s", f"{c} of D in the last step") for c in COMPONENTS),
    )
    TENSORS: ClassVar[tuple[int, ...]] = (COLLISIONAL, STRETCHING)
    OUTPUTS: ClassVar[dict[str, str]] = {
        **CriticalStateHypoplastic.OUTPUTS, "collisional_pressure": "Pa", "collisional_q": "Pa"
    }  # fmt: skip
    RATE_DEPENDENT: ClassVar[bool] = True

    cohesion: Annotated[float, Field(ge=0.0, le=0.0)] = 0.0
    """none: colliding grains do not stick [Pa]"""
    collision_time: NonNegative
    """|A|: scale of the collisional stress [s]"""
    constant_share: NonNegative = 0.5
    """m₁ [-]"""
    square_share: NonNegative = 1e-3
    """m₂ [s2]"""

    _spacing: float = PrivateAttr(default=np.inf)

    update = staticmethod(solid_to_gas_update)
    stiffness = staticmethod(solid_to_gas_stiffness)

    def on_grid(self, spacing: float, rows: int = 1) -> "SolidToGas":
        """The law with the step limit of its viscosity on cells of this size [m]."""
        law = self.model_copy()
        law._spacing = spacing
        return law

    def viscosity(self, stress: ArrayLike, state: ArrayLike) -> Array:
        """2 |η| σ₁ [Pa s] of Cauchy stresses (..., 3, 3) [Pa] and states (..., n_state)."""
        p, q = invariants(stress)
        stretching = unpack(np.asarray(state, float)[..., STRETCHING : STRETCHING + 6])
        square = np.einsum("...ij,...ij->...", stretching, stretching)
        eta = self.collision_time * np.sqrt(self.constant_share + self.square_share * square)
        return 2.0 * eta * (np.abs(p) + 2.0 / 3.0 * q)

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """See `Law`: with the damping of collisions on the law's cells."""
        speed = super().wave_speed_at(stress, state)
        J = self._volume_ratio(state)
        damping = self.viscosity(unpack(stress), state) / (self.density / J * speed * self._spacing)
        return speed * (damping + np.sqrt(1.0 + damping**2))

    def _translated(self, stress, state):
        """Principal values of the frictional part of Kirchhoff stresses (..., 3, 3)."""
        state = np.asarray(state, float)
        collisional = unpack(state[..., COLLISIONAL : COLLISIONAL + 6])
        return super()._translated(stress - self._volume_ratio(state)[..., None, None] * collisional, state)

    def outputs(self, state: Array) -> dict[str, Array]:
        """void_ratio, gap, accumulated_strain; −tr(T_v)/3 and q of T_v, the collisional part of the Cauchy stress."""
        state = np.asarray(state)
        p, q = invariants(unpack(state[..., COLLISIONAL : COLLISIONAL + 6]))
        return {**super().outputs(state), "collisional_pressure": p, "collisional_q": q}

    def parameters(self) -> SolidToGasParameters:  # type: ignore[override]
        return SolidToGasParameters(
            **CriticalStateRateParameters._asdict(super().parameters()),
            collision_time=self.collision_time,
            constant_share=self.constant_share,
            square_share=self.square_share,
            per_root_density=1.0 / (float(np.sqrt(self.density)) * self._spacing),
        )

    def initial_state(self) -> tuple[float, ...]:
        return (*super().initial_state(), *[0.0] * 12)
