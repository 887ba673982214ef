"""Hypoplasticity: the stress rate as a function of stress and stretching, without yield surface or elastic range."""

from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from snowmpm.compiler import ti

from .arrays import Array
from .conventions import tensile_apex
from .hypoplastic_calibration import (
    coefficients,
    lateral_rate,
    stress_ratio,
    triaxial_failure,
    triaxial_rate,
)
from .law import Law, NonNegative, Positive, StateVariable
from .rate_integration import rate_stiffness, rate_update
from .symmetric import contract, plus_isotropic, trace, unpack
from .tension_gap import GAP

JAMMED_ANGLE = 5.0  # no granular material fails below this friction angle [deg]
FARTHEST_RATIO = 100.0  # principal over mean stress, above which a stress has failed by any measure
VOID_RATIO = StateVariable("void_ratio", "-", "e: volume of the pores over that of the grains")

STRAIN = StateVariable("accumulated_strain", "-", "∫ √(2/3 D':D') dt, D' the deviator of the stretching")


class RateParameters(NamedTuple):
    """What the functions of every rate law read."""

    apex: float  # tension by which η = σ − apex I is translated [Pa]
    log_floor: float  # lowest ln p, p in Pa
    void_ratio: float  # initial e [-]
    tolerance: float  # of a sub-step [-]
    c1: float  # coefficients of the rate [-]
    c2: float
    c3: float
    c4: float


@ti.func
def linear_rate(prm: ti.template(), r, log_p, void_ratio, direction):
    """G of `Hypoplastic`, see rate_integration.py."""
    doubled = plus_isotropic(2.0 * r, ti.static(-1.0 / 3.0))  # r + dev r
    factor = prm.c2 * trace(direction) + prm.c3 * contract(r, direction)
    return prm.c1 * direction + factor * r + prm.c4 * doubled


@ti.func
def linear_modulus(prm: ti.template(), share, log_p, void_ratio):
    """Stiffness of unloading over 3p, see `rate_stiffness`."""
    return -(prm.c1 + share * (prm.c2 + prm.c3 * share) + prm.c4 * (2.0 * share - ti.static(1.0 / 3.0)))


class RateLaw(Law):
    """What hypoplastic laws share: a triaxial test as parameters, cohesion by translation, separation, void ratio.

    The tensor that a solver carries as h is the Cauchy stress σ [Pa] itself. Rotation and integration over a step of
    any size: rate_integration.py. `iterations` is the number of sub-steps (0: stress-free, or no strain), −1 if more
    than 400 would be needed, which takes strains of tens of per cent in one step; `tolerance` is the relative error of
    the stress that each may add.

    Parameters are those of one drained triaxial compression test at `reference_pressure` σ₃: initial slope
    (youngs_modulus), its Poisson ratio, friction and dilation angle [deg]. A set whose test stops before its friction
    angle is refused. Stiffness is proportional to pressure, so it has no constant wave speed: `wave_speed` is that of
    an axial stress of σ₃ under K₀, `wave_speed_at` that of any stress. A solver's step is that of σ₃ or shorter: give
    about the highest pressure expected, and youngs_modulus in proportion; only their ratio enters the law.

    Cohesion: σ is replaced by η = σ − c cot φ I in every term [P 24-25], which puts the apex where Coulomb's line
    meets the axis; it is perfect, as in [P]: not lost in tension. ([P] translates by its "c" itself: its c = 5 kPa with
    φ = 30° is a Coulomb cohesion of 2.89 kPa here.) At η = 0 the rate equation stands still, so p_η never falls below
    `pressure_floor`. Where it would, material without cohesion separates: stress-free, with a gap that must close
    before contact begins again, isotropic at the floor, as it does from a start without stress. With cohesion the
    stress stays at the apex (less the floor).

    No elastic energy is known to a rate law: `elastic_energy` is 0 and the dissipation is all work of the stress, so
    that energies add up; it is negative where unloading gives work back (DISSIPATIVE is False).
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (VOID_RATIO, GAP, STRAIN)
    OUTPUTS: ClassVar[dict[str, str]] = {"void_ratio": "-", "gap": "-", "accumulated_strain": "-"}
    STORED: ClassVar[Literal["strain", "stress"]] = "stress"
    DISSIPATIVE: ClassVar[bool] = False

    youngs_modulus: Positive
    """initial slope of the triaxial test [Pa]"""
    poisson_ratio: Annotated[float, Field(ge=0.0, lt=0.5)]
    """ν_i, at the begin of the triaxial test [-]"""
    friction_angle: Annotated[float, Field(ge=JAMMED_ANGLE, lt=60.0)]
    """φ in triaxial compression [degrees]"""
    dilation_angle: Annotated[float, Field(gt=-30.0, lt=30.0)] = 0.0
    """ψ at failure in triaxial compression [degrees]"""
    cohesion: NonNegative = 0.0
    """c of Coulomb's line [Pa]"""
    reference_pressure: Positive = 1e5
    """σ₃: lateral pressure of the triaxial test [Pa]"""
    void_ratio: Positive = 0.7
    """at the start, that of `density` [-]"""
    pressure_floor: Positive = 1.0
    """least pressure of the rate equation [Pa]"""
    tolerance: Positive = 1e-5
    """error of the stress that a substep may add [-]"""

    @staticmethod
    def terms(stress: Array, rate: Array) -> Array:
        """The four terms of the law (..., 3, 4), tension positive, for principal stresses and strain rates (..., 3)."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _reaches_failure(self):
        wanted = stress_ratio(self.friction_angle)
        reached = triaxial_failure(self.terms, self.coefficients, 1.1 * wanted)
        if not abs(reached - wanted) < 1e-6 * wanted:
            angle = np.degrees(np.arcsin((min(reached, 1e9) - 1.0) / (min(reached, 1e9) + 1.0)))
            raise ValueError(
                f"friction_angle {self.friction_angle:g} is not what this law reaches with the other parameters: "
                f"triaxial compression ends at {angle:.3g} degrees"
            )
        return self

    @classmethod
    def from_coefficients(cls, values: ArrayLike, reference_pressure: float = 1e5, **others: Any) -> "RateLaw":
        """The law of given coefficients: parameters of the triaxial test that they stand for at `reference_pressure`.

        Raises ValueError where triaxial compression reaches no failure below 60 degrees, or jams below 5.
        """
        nu = float(lateral_rate(cls.terms, values, 1.0))
        slope = triaxial_rate(cls.terms, values, 1.0, nu)[..., 0]
        ratio = triaxial_failure(cls.terms, values, stress_ratio(60.0))
        if not (np.isfinite(ratio) and np.isfinite(nu)):
            raise ValueError("these coefficients know no failure in triaxial compression")
        if ratio < stress_ratio(JAMMED_ANGLE):
            raise ValueError(f"these coefficients jam: triaxial compression ends at a stress ratio of {ratio:.4g}")
        return cls(
            youngs_modulus=float(slope * reference_pressure),
            poisson_ratio=nu,
            friction_angle=float(np.degrees(np.arcsin((ratio - 1.0) / (ratio + 1.0)))),
            dilation_angle=float(np.degrees(np.arctan(2.0 * lateral_rate(cls.terms, values, ratio) - 1.0))),
            reference_pressure=reference_pressure,
            **others,
        )

    @cached_property
    def coefficients(self) -> tuple[float, ...]:
        """The law's four coefficients [-]."""
        stiffness = self.youngs_modulus / self.reference_pressure
        return tuple(
            float(c)
            for c in coefficients(self.terms, stiffness, self.poisson_ratio, self.friction_angle, self.dilation_angle)
        )

    @property
    def tensile_apex(self) -> float:
        """c cot φ [Pa]: the isotropic tension that intact bonds carry."""
        return float(tensile_apex(self.cohesion, self.friction_angle))

    @property
    def tensile_strength(self) -> float:
        return self.tensile_apex

    @property
    def friction_exceeds_dilation(self) -> bool:
        return self.dilation_angle < self.friction_angle

    @cached_property
    def lateral_pressure(self) -> float:
        """K₀ [-], the ratio that oedometric compression of cohesionless material tends to."""
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            stress, rate = -np.array([1.0, middle, middle]), np.array([-1.0, 0.0, 0.0])
            axial, lateral = -(self.terms(stress, rate) @ self.coefficients)[:2]
            low, high = (middle, high) if lateral > middle * axial else (low, middle)
        return 0.5 * (low + high)

    def wave_speed(self) -> float:
        """Speed of P-waves [m/s] under an axial stress of `reference_pressure` and K₀, unloading, the stiffer way."""
        stress = -self.reference_pressure * np.array(
            [[1.0, self.lateral_pressure, self.lateral_pressure, 0.0, 0.0, 0.0]]
        )
        return float(self.wave_speed_at(stress, np.array([self.initial_state()]))[0])

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """√(M / ρ), M the largest stiffness in uniaxial strain, either way, along a principal direction of stress."""
        eta = self._translated(unpack(stress), state)
        eta = np.where(eta.mean(axis=1, keepdims=True) < -self.pressure_floor, eta, -self.pressure_floor)
        c = self.coefficients_at(eta.mean(axis=-1), state)
        stiffness = np.zeros(len(eta))
        for axis in range(3):
            for sign in (1.0, -1.0):
                rate = np.tile(sign * np.eye(3)[axis], (len(eta), 1))
                stiffness = np.maximum(stiffness, sign * self._rate(c, eta, rate)[:, axis])
        return np.sqrt(stiffness * self._volume_ratio(state) / self.density)

    def coefficients_at(self, mean: Array, state: Array) -> Array:
        """Coefficients (..., 4) at the mean translated stress [Pa] and the state: the law's own, whatever they are."""
        return np.broadcast_to(self.coefficients, (*np.shape(mean), 4))

    def _rate(self, coefficients, stress, rate):
        """Principal stress rates (..., 3) that belong to principal stresses and strain rates."""
        return np.einsum("...ik,...k->...i", self.terms(stress, rate), coefficients)

    def _translated(self, stress, state):
        """Principal values of η = σ − apex I (..., 3) of Kirchhoff stresses (..., 3, 3)."""
        return np.linalg.eigvalsh(np.asarray(stress, float)) / self._volume_ratio(state)[..., None] - self.tensile_apex

    def _volume_ratio(self, state):
        return (1.0 + np.asarray(state, float)[..., 0]) / (1.0 + self.void_ratio)

    def parameters(self) -> RateParameters:
        return RateParameters(
            self.tensile_apex, float(np.log(self.pressure_floor)), self.void_ratio, self.tolerance, *self.coefficients
        )

    def initial_state(self) -> tuple[float, ...]:
        return self.void_ratio, 0.0, 0.0

    def hencky_from_stress(self, stress: ArrayLike, state: ArrayLike | None = None) -> Array:
        """NaN: a rate law has no elastic strain."""
        return np.full(np.shape(stress), np.nan)

    def elastic_energy(self, stress: Array, state: Array) -> Array:
        """0: a rate law has no energy."""
        return np.zeros(len(stress))

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """Mean tension beyond the apex [Pa]: the only stress that cannot be. (There is no yield surface.)"""
        tension = np.trace(np.asarray(stress, float), axis1=-2, axis2=-1) / 3.0
        return tension / self._volume_ratio(state) - self.tensile_apex

    def failure_function(self, stress: ArrayLike, state: Array) -> Array:
        """‖L⁻¹ : N‖ − 1 (...,), > 0 where some stretching leaves the stress as it is: failure. −1 without stress.

        L : D + N |D| is the rate at this stress; Wu and Bauer (1994), and eq. 14 of Wu, Wang, Alipour (2020).
        """
        eta = self._translated(stress, state)
        held = eta.mean(axis=-1) < -self.pressure_floor
        beyond = np.abs(eta).max(axis=-1) > -FARTHEST_RATIO * eta.mean(axis=-1)  # no number of use: a cone's p = 0
        eta = np.where((held & ~beyond)[..., None], eta, -1.0)
        c = self.coefficients_at(eta.mean(axis=-1), state)
        one, other = (
            np.stack([self._rate(c, eta, np.broadcast_to(sign * unit, eta.shape)) for unit in np.eye(3)], axis=-1)
            for sign in (1.0, -1.0)
        )
        flow = np.linalg.solve(0.5 * (one - other), 0.5 * (one + other)[..., :1])[..., 0]
        return np.where(held, np.where(beyond, np.inf, np.linalg.norm(flow, axis=-1)), 0.0) - 1.0

    def outputs(self, state: Array) -> dict[str, Array]:
        """void_ratio, gap and accumulated_strain."""
        state = np.asarray(state)
        return {"void_ratio": state[..., 0], "gap": state[..., 1], "accumulated_strain": state[..., 2]}


class Hypoplastic(RateLaw):
    """Hypoplastic sand of Peng et al.: four coefficients, failure on a Drucker-Prager cone.

        σ° = c₁ tr(σ) D + c₂ tr(D) σ + c₃ [tr(σ D)/tr σ] σ + c₄ (σ + dev σ) |D|,    |D| = √(D : D)     [P 15]

    [P] Peng, Wu, Yu, Wang, "A SPH approach for large deformation analysis with hypoplastic constitutive model", Acta
    Geotech. 10 (2015) 703, doi:10.1007/s11440-015-0399-3, after Wang and Wu. σ: Cauchy stress, tension positive; D:
    stretching. Homogeneous of degree one in stress and in stretching: path-dependent, rate-independent, stiffness and
    strength in proportion to pressure. K₀ = c₄/(3c₁ + c₄).

    The cone is that of triaxial compression, q = 6 sin φ/(3 − sin φ) p at every Lode angle: plane strain and simple
    shear are stronger than Coulomb's φ. Density plays no part; dilation goes on for ever unless ψ = 0 (and then nearly
    ceases). Validity: dry sand at moderate pressure, flow slow enough for no rate effects; no small-strain stiffness.
    """

    kind: Literal["hypoplastic"] = "hypoplastic"

    update = staticmethod(rate_update(linear_rate))
    stiffness = staticmethod(rate_stiffness(linear_modulus))

    @staticmethod
    def terms(stress: Array, rate: Array) -> Array:
        total, mean = stress.sum(-1, keepdims=True), stress.mean(-1, keepdims=True)
        along = (stress * rate).sum(-1, keepdims=True) / total
        size = np.sqrt((rate**2).sum(-1, keepdims=True))
        volume = rate.sum(-1, keepdims=True)
        return np.stack([total * rate, volume * stress, along * stress, (2.0 * stress - mean) * size], axis=-1)

    @property
    def lateral_pressure(self) -> float:
        """K₀ = c₄/(3c₁ + c₄) [P 38] [-]"""
        c1, _, _, c4 = self.coefficients
        return c4 / (3.0 * c1 + c4)
