"""Elasticity of other energies than Hencky's: neo-Hookean and St. Venant-Kirchhoff."""

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from snowmpm.compiler import ti

from .arrays import Array
from .elastic import elastic_trial, small_elastic_trial
from .law import REDO, Law, StateVariable
from .series import SMALL_EXP, expm1_series
from .symmetric import contract, plus_isotropic, squared, trace, unpack

ROUNDS = 60
"""Of Newton's method from a stress to its strain."""

SHEARED = 2.0 * np.sqrt(2.0 / 3.0)
"""Of |dev tau|, at most: what shear adds to the stiffness of a neo-Hookean solid."""


@ti.func
def expm1(x):
    """exp(x) - 1, near zero too."""
    value = expm1_series(x)
    if not (ti.abs(x) < SMALL_EXP):
        value = ti.exp(x) - 1.0
    return value


@ti.func
def straight_expm1(x):
    """exp(x) - 1 for |x| < 4 SMALL_EXP, without a branch: of a fourth of x, squared twice."""
    part = expm1_series(0.25 * x)
    half = part * (2.0 + part)
    return half * (2.0 + half)


class NeoHookeanParameters(NamedTuple):
    """What the update of `NeoHookean` reads."""

    K: float  # bulk modulus [Pa]
    G: float  # shear modulus [Pa]


@ti.func
def neo_hookean_stiffness(prm: ti.template(), tau, state):
    """rho_0 c^2 [Pa], see `NeoHookean.wave_speed_at`."""
    mean = ti.static(1.0 / 3.0) * trace(tau)
    deviator = plus_isotropic(tau, -mean)
    swollen = 2.0 * ti.max(mean, 0.0)
    return prm.K + ti.static(4.0 / 3.0) * prm.G + swollen + ti.static(SHEARED) * ti.sqrt(contract(deviator, deviator))


def neo_hookean_update(trial, grown, failed):
    """Update function (see `Law`) that makes its trial state and exp(x) - 1 by functions; a failure is a number."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, _, volume, _, valid = trial(h, A)
        mean = ti.static(1.0 / 3.0) * trace(h_new)
        size = prm.G * (1.0 + grown(ti.static(-2.0 / 3.0) * volume))
        tau = plus_isotropic(size * h_new, 0.5 * prm.K * grown(2.0 * volume) - size * mean)
        near = ti.abs(2.0 * volume) < ti.static(4.0 * SMALL_EXP if failed == REDO else np.inf)
        return h_new, tau, state, 0.0, ti.select(valid == 1 and near, 0, failed)

    return update


class StVenantKirchhoffParameters(NamedTuple):
    """What the update of `StVenantKirchhoff` reads."""

    half_lame: float  # lambda / 2 [Pa]
    G: float  # shear modulus [Pa]


@ti.func
def st_venant_kirchhoff_stiffness(prm: ti.template(), tau, state):
    """rho_0 c^2 [Pa], see `StVenantKirchhoff.wave_speed_at`."""
    stretch2 = 1.0 + state[0]
    return 2.0 * (prm.half_lame + prm.G) * stretch2 * stretch2 + 2.0 * ti.sqrt(contract(tau, tau))


def st_venant_kirchhoff_update(trial, failed):
    """Update function (see `Law`) that makes its trial state by a function and reports a failure by a number."""

    @ti.func
    def update(prm: ti.template(), h, state, A, dt):
        h_new, _, _, _, valid = trial(h, A)
        pull = prm.half_lame * trace(h_new)
        tau = plus_isotropic((pull + prm.G) * h_new + prm.G * squared(h_new), pull)
        state_new = state
        state_new[0] = ti.select(valid == 1, ti.sqrt(contract(h_new, h_new)), state[0])
        return h_new, tau, state_new, 0.0, ti.select(valid == 1, 0, failed)

    return update


class Hyperelastic(Law):
    """Base of isotropic elasticity by an energy of b: what is asked of a stress, by its principal values."""

    YIELDS: ClassVar[bool] = False

    @property
    def tensile_strength(self) -> float:
        return np.inf

    def strains_of(self, tau: Array) -> Array:
        """Principal values of h = b - I (n, 3) of those of the stress (n, 3) [Pa]; NaN where there are none."""
        raise NotImplementedError

    def energy_of(self, h: Array) -> Array:
        """Energy per unit reference volume [J/m3] (n,) of principal values of h (n, 3)."""
        raise NotImplementedError

    def hencky_from_stress(self, stress: ArrayLike, state: ArrayLike | None = None) -> Array:
        """Hencky strain (..., 3, 3) of a Kirchhoff stress (..., 3, 3) [Pa]; NaN where no strain has it."""
        tau, axes = np.linalg.eigh(np.asarray(stress, float))
        strain = 0.5 * np.log1p(self.strains_of(tau.reshape(-1, 3)))
        return np.einsum("...ik,...k,...jk->...ij", axes, strain.reshape(tau.shape), axes)

    def elastic_energy(self, stress: Array, state: Array) -> Array:
        """Recoverable energy per unit reference volume [J/m3] of Kirchhoff stresses (n, 6), packed [Pa]; NumPy."""
        return self.energy_of(self.strains_of(np.linalg.eigvalsh(unpack(np.asarray(stress, float)))))


class NeoHookean(Hyperelastic):
    """Neo-Hookean elasticity, its change of volume apart.

        psi = mu/2 (J^(-2/3) tr b - 3) + K/2 ((J^2 - 1)/2 - ln J),    tau = mu J^(-2/3) dev b + K/2 (J^2 - 1) I

    Simo & Hughes, Computational Inelasticity (1998), section 9.2.1; Simo (1988), doi:10.1016/0045-7825(88)90076-X.
    Stiffness at rest is Hooke's with K and mu. Validity: moderate strains; stress grows without end both ways.
    """

    kind: Literal["neo_hookean"] = "neo_hookean"

    update = staticmethod(neo_hookean_update(elastic_trial, expm1, -1))
    vector_update = staticmethod(neo_hookean_update(small_elastic_trial, straight_expm1, REDO))
    stiffness = staticmethod(neo_hookean_stiffness)

    def parameters(self) -> NeoHookeanParameters:
        return NeoHookeanParameters(self.bulk_modulus, self.shear_modulus)

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """sqrt(M / rho_0), M = K + 4G/3 + 2 max(tr tau / 3, 0) + 2 sqrt(2/3) |dev tau|.

        Along an axis of b M is K J^2 + 2/3 mu J^(-2/3) (b_i + tr b / 3). Of it K J^2 = K + 2/3 tr tau, and mu J^(-2/3)
        b_i = dev tau_i + mu q, q = J^(-2/3) tr b / 3; det (dev tau / mu + q I) = 1 leaves q <= 1 + |dev tau| / mu.
        """
        mean = stress[:, :3].mean(axis=1)
        deviator = unpack(stress) - mean[:, None, None] * np.eye(3)
        M = self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus + 2.0 * np.maximum(mean, 0.0)
        return np.sqrt((M + SHEARED * np.linalg.norm(deviator, axis=(1, 2))) / self.density)

    def strains_of(self, tau: Array) -> Array:
        """h; by the root y of det (D + (1 + y) I) = 1, D = dev tau / mu."""
        mean = tau.mean(axis=1, keepdims=True)
        D, grown = (tau - mean) / self.shear_modulus, 2.0 * mean / self.bulk_modulus
        y = np.maximum(0.0, -D.min(axis=1, keepdims=True))  # all factors at least 1: right of the root
        for _ in range(ROUNDS):
            a = D + y
            pairs = a[:, [0]] * a[:, [1]] + a[:, [0]] * a[:, [2]] + a[:, [1]] * a[:, [2]]
            slope = 3.0 + 2.0 * a.sum(axis=1, keepdims=True) + pairs
            y = y - (3.0 * y + pairs + a.prod(axis=1, keepdims=True)) / slope
        with np.errstate(invalid="ignore"):
            cubed = np.expm1(np.log1p(grown) / 3.0)  # J^(2/3) - 1
        return D + y + cubed * (1.0 + D + y)

    def energy_of(self, h: Array) -> Array:
        square = _volume(h)
        with np.errstate(invalid="ignore"):
            shrink = np.expm1(-np.log1p(square) / 3.0)
            shape = h.sum(axis=1) + shrink * (3.0 + h.sum(axis=1))
            return 0.5 * self.shear_modulus * shape + 0.25 * self.bulk_modulus * (square - np.log1p(square))


class StVenantKirchhoff(Hyperelastic):
    """St. Venant-Kirchhoff elasticity: Hooke's law between S and Green's strain E = (F^T F - I) / 2.

        psi = lambda/2 (tr E)^2 + mu E : E,    S = lambda tr(E) I + 2 mu E,    tau = F S F^T = lambda/2 tr(h) b + mu b h

    Ogden, Non-linear Elastic Deformations (1984), section 4.4; Bonet & Wood (2008), section 6.3. Validity: large turns
    and small strains. In compression it softens, and beyond a stretch of sqrt(1/3) = 0.577 a bar has no more force to
    give: there a body folds. In tension it stiffens, with s^2 (2 s^2 - 1) of its first stiffness at a stretch s, which
    the step follows.
    """

    kind: Literal["st_venant_kirchhoff"] = "st_venant_kirchhoff"

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("strain_size", "-", "|b - I|, from which follows how stiff it is"),
    )

    update = staticmethod(st_venant_kirchhoff_update(elastic_trial, -1))
    vector_update = staticmethod(st_venant_kirchhoff_update(small_elastic_trial, REDO))
    stiffness = staticmethod(st_venant_kirchhoff_stiffness)

    @property
    def _lame(self) -> float:
        return self.bulk_modulus - 2.0 / 3.0 * self.shear_modulus

    def parameters(self) -> StVenantKirchhoffParameters:
        return StVenantKirchhoffParameters(0.5 * self._lame, self.shear_modulus)

    def initial_state(self) -> tuple[float, ...]:
        return (0.0,)

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """sqrt(M / rho_0), M = (lambda + 2 mu) (1 + |h|)^2 + 2 |tau|: along an axis of b it is (lambda + 2 mu) b_i^2 +
        2 tau_i."""
        M = (self._lame + 2.0 * self.shear_modulus) * (1.0 + np.asarray(state)[:, 0]) ** 2
        return np.sqrt((M + 2.0 * np.linalg.norm(unpack(stress), axis=(1, 2))) / self.density)

    def strains_of(self, tau: Array) -> Array:
        """h by Newton's method from Hooke's; NaN where none is found on this side of the fold."""
        half, mu = 0.5 * self._lame, self.shear_modulus
        mean = tau.mean(axis=1, keepdims=True)
        h = np.maximum((tau - mean) / mu + 2.0 * mean / (3.0 * self.bulk_modulus), -0.5)
        for _ in range(ROUNDS):
            b, total = 1.0 + h, h.sum(axis=1, keepdims=True)
            slope = half * b[:, :, None] + (half * total + mu * (b + h))[:, :, None] * np.eye(3)
            step = np.linalg.solve(slope, (half * total * b + mu * h * b - tau)[:, :, None])[:, :, 0]
            h = np.maximum(h - step, 0.5 * (h - 2.0 / 3.0))  # stays above the fold of a single stretch
        b, total = 1.0 + h, h.sum(axis=1, keepdims=True)
        left = np.abs(half * total * b + mu * h * b - tau).max(axis=1, keepdims=True)
        return np.where(left <= 1e-9 * (np.abs(tau).max(axis=1, keepdims=True) + 1e-6 * mu), h, np.nan)

    def energy_of(self, h: Array) -> Array:
        return 0.25 * (0.5 * self._lame * h.sum(axis=1) ** 2 + self.shear_modulus * (h**2).sum(axis=1))


def _volume(h: Array) -> Any:
    """J^2 - 1 (n,) of principal values of h (n, 3), near zero too."""
    pairs = h[:, 0] * h[:, 1] + h[:, 0] * h[:, 2] + h[:, 1] * h[:, 2]
    return h.sum(axis=1) + pairs + h.prod(axis=1)
