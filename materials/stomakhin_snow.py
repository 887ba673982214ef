"""Stomakhin's snow: fixed-corotated elasticity, clamped principal stretches, stiffness that follows the compaction."""

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from snowmpm.compiler import ti

from .arrays import Array
from .elastic import trial_state
from .hencky import KNOWN, log_volume, round_off_of, smallest_of
from .law import Law, NonNegative, Positive, StateVariable
from .precision import by_precision
from .series import log1p_series
from .spectral import compose, eigen
from .symmetric import contract, determinant, plus_isotropic, squared, trace, unpack

MAX_EXPONENT = 30.0  # of the hardening factor, up and down: exp(±30) keeps a stress and its square within float32
VOLUME_RATIOS = (1e-9, 1e4)  # bounds of J_P; beyond them the volume of a particle means nothing
TOLERANCE = (5e-7, 1e-12)  # of a stretch (float32, float64): below it a trial state counts as admissible
SERIES_ORDER = (5, 12)
UNLIKE = 0.05  # least over largest eigenvalue of b, from which on down the volume tells the least
SERIES_RADIUS = 0.05  # |h| up to which √(I + h) is summed: first term left out below 1e-2 |h|^order


class StomakhinParameters(NamedTuple):
    """What the functions of `StomakhinSnow` read."""

    mu: float  # μ at J_P = 1 [Pa]
    lam: float  # λ at J_P = 1 [Pa]
    xi: float  # hardening ξ [-]
    compression: float  # θ_c [-]
    stretch: float  # θ_s [-]
    near2: float  # |h|² below which no threshold is near and √(I + h) is a series [-]


@ti.func
def hardening_factor(xi, ratio):
    """exp(ξ (1 − J_P)), cut off."""
    return ti.exp(ti.max(-MAX_EXPONENT, ti.min(xi * (1.0 - ratio), MAX_EXPONENT)))


@ti.func
def stretch_deviation(h):
    """V − I with V = √(I + h), for |h| < SERIES_RADIUS, and det V − 1. No eigenvectors: Cayley-Hamilton series."""
    h2 = squared(h)
    i1, i3 = trace(h), determinant(h)
    i2 = 0.5 * (i1 * i1 - trace(h2))
    # h^k = c0 I + c1 h + c2 h²; coefficients of the series of √(1 + x)
    a0, a1, a2 = 0.0, 0.5, -0.125
    c0, c1, c2 = 0.0, 0.0, 1.0
    coefficient = -0.125
    for k in ti.static(range(3, by_precision(*SERIES_ORDER) + 1)):
        c0, c1, c2 = c2 * i3, c0 - c2 * i2, c1 + c2 * i1
        coefficient *= ti.static((1.5 - k) / k)
        a0 += coefficient * c0
        a1 += coefficient * c1
        a2 += coefficient * c2
    y = i1 + i2 + i3  # det b − 1
    return plus_isotropic(a1 * h + a2 * h2, a0), y / (1.0 + ti.sqrt(1.0 + y))


@ti.func
def principal(h, before, A):
    """Principal stretches − 1 of V = √(I + h), their directions, and 1 if they are more than round-off, else 0.

    h: of the trial state f b fᵀ, from `before` = b − I and A = f − I. The smallest stretch beside one that is much
    larger follows from the volume where that is known better, as in `strain_of_volume`.
    """
    w, V = eigen(h)
    lifted = ti.max(w, round_off_of(w) - 1.0)
    d, known = lifted / (1.0 + ti.sqrt(1.0 + lifted)), 1
    if not (1.0 + w.min() > ti.static(UNLIKE) * (1.0 + w.max())):
        volume, error = log_volume(before, A)
        chosen, apart = 0, True
        if ti.static(h.n == 4):
            chosen, apart = smallest_of(ti.Vector([w[0], w[1]]))
        else:
            chosen, apart = smallest_of(w)
        others, smallest = 1.0, 0.0
        for i in ti.static(range(3)):
            others *= ti.select(i == chosen, 1.0, 1.0 + d[i])
            smallest += ti.select(i == chosen, 1.0 + w[i], 0.0)
        if round_off_of(w) < error * smallest:
            error = round_off_of(w) / smallest
        else:
            for i in ti.static(range(3)):
                d[i] = ti.select(i == chosen, ti.exp(volume) / others - 1.0, d[i])
        known = ti.select(apart and error < 1.0 / KNOWN, 1, 0)
    return d, V, known


@ti.func
def volume_change(d):
    """(1 + d0)(1 + d1)(1 + d2) − 1"""
    return d[0] + d[1] + d[2] + d[0] * d[1] + d[1] * d[2] + d[2] * d[0] + d[0] * d[1] * d[2]


@ti.func
def log_ratio(d_trial, d):
    """ln((1 + d_trial) / (1 + d)), relative accuracy kept for neighbours."""
    x = (d_trial - d) / (1.0 + d)
    return ti.select(ti.abs(x) < 0.1, log1p_series(ti.max(-0.1, ti.min(x, 0.1))), ti.log(1.0 + x))


@ti.func
def stomakhin_update(prm: ti.template(), h, state, A, dt):
    """See `Law`. state: J_P."""
    mu, lam = prm.mu, prm.lam
    h_new, valid = trial_state(h, A)
    state_new = state
    factor = hardening_factor(prm.xi, state[0])
    tau = h_new
    dissipation, plastic = 0.0, 0
    if contract(h_new, h_new) < prm.near2:  # cannot reach a threshold, whatever its directions
        stretch, j = stretch_deviation(h_new)
        tau = plus_isotropic((2.0 * mu * factor) * (h_new - stretch), lam * factor * (1.0 + j) * j)
    else:
        trial, V, known = principal(h_new, h, A)
        if valid * known == 0:
            # Left out: the state as it was
            valid, h_new = 0, h
            trial, V, known = principal(h, h, 0.0 * ti.Matrix.identity(float, A.n))
        d = ti.max(-prm.compression, ti.min(trial, prm.stretch))
        if (ti.abs(trial - d) > ti.static(by_precision(*TOLERANCE))).any():
            plastic = 1
            h_new = compose(d * (2.0 + d), V, h_new)
        else:
            d = trial
        j = volume_change(d)
        stress = 2.0 * mu * d * (1.0 + d) + lam * (1.0 + j) * j
        if plastic == 1:
            flow = ti.Vector([log_ratio(trial[0], d[0]), log_ratio(trial[1], d[1]), log_ratio(trial[2], d[2])])
            ratio = state[0] * ti.exp(flow.sum())
            state_new[0] = ti.max(ti.static(VOLUME_RATIOS[0]), ti.min(ratio, ti.static(VOLUME_RATIOS[1])))
            before = factor
            factor = hardening_factor(prm.xi, state_new[0])
            energy = mu * d.norm_sqr() + 0.5 * lam * j * j
            dissipation = factor * stress.dot(flow) - (factor - before) * energy
        tau = compose(factor * stress, V, tau)
    # An ordered comparison, because a NaN fails it
    finite = ti.select(tau.norm_sqr() + state_new[0] < ti.static(by_precision(3e38, 1e100)), 1, 0)
    return h_new, tau, state_new, dissipation, ti.select(valid * finite == 1, plastic, -1)


@ti.func
def stomakhin_stiffness(prm: ti.template(), tau, state):
    """ρ₀ c² [Pa], see `StomakhinSnow.wave_speed_at`."""
    squeezed, drawn = 1.0 - prm.compression, 1.0 + prm.stretch
    ratio, drawn2 = squeezed * squeezed * squeezed, drawn * drawn
    elastic = drawn2 * (2.0 * prm.mu + prm.lam * drawn2 * drawn2)
    plastic = 2.0 * prm.mu * squeezed * prm.compression + prm.lam * ratio * (1.0 - ratio)
    plastic *= 1.0 + prm.xi * state[0]
    return hardening_factor(prm.xi, state[0]) * ti.max(elastic, plastic)


class StomakhinSnow(Law):
    """Snow of Stomakhin et al.: corotated elasticity that stiffens with compaction, and limits on the elastic stretch.

        ψ = exp(ξ (1 − J_P)) [μ |Fe − Re|² + ½ λ (J_E − 1)²]                 [S 1-2], [G 46]
        τ = exp(ξ (1 − J_P)) [2μ (b − √b) + λ (J_E − 1) J_E I],  b = Fe Feᵀ
        1 − θ_c <= s_i <= 1 + θ_s for the singular values s_i = √(eigenvalues of b) of Fe; a trial state beyond is
        clamped, and what is cut off becomes plastic: J_P = det Fp             [G 47-53]

    [S] Stomakhin, Schroeder, Chai, Teran, Selle, "A material point method for snow simulation", ACM Trans. Graph. 32(4)
    (2013), doi:10.1145/2461912.2461948; [G] Gaume et al., "Modeling snow and avalanches with the Material Point Method
    and finite strain elastoplasticity" (no DOI known; its plasticity: Gaume et al. 2018,
    doi:10.1038/s41467-018-05181-w), whose (53) must read Fp = Fe⁻¹ F. E and ν are those of J_P = 1; J_P < 1:
    compacted. A law made for pictures: thresholds of single stretches, so that strength depends on the Lode angle;
    no friction that grows with pressure; no gap to close: snow that was pulled apart carries stress as soon as it is
    pressed, with the small stiffness of its J_P.

    No energy principle stands behind the clamp: a stretch that is cut at θ_s may be under pressure when the other two
    are compressed, and then plastic work is negative (DISSIPATIVE is False). The dissipation that is returned closes
    the energy balance to first order in the step: τ : Δε_plastic less the change of the hardening factor times ψ at
    factor 1, since a stiffness that grows stores part of the plastic work, and one that falls sets energy free. With
    the published numbers it is negative in compacted snow only.
    Validity: ν >= 0; θ_c <= 0.2, so that a stress belongs to one state of stretch; exponent of hardening cut off at
    ±30 (stiffer than that only for ξ > 30); J_P kept between 1e-9 and 1e4.
    """

    kind: Literal["stomakhin_snow"] = "stomakhin_snow"

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("plastic_volume_ratio", "-", "J_P = det Fp; < 1 compacted and stiffer, > 1 torn and softer"),
    )
    OUTPUTS: ClassVar[dict[str, str]] = {"stiffness_factor": "-"}
    DISSIPATIVE: ClassVar[bool] = False

    update = staticmethod(stomakhin_update)
    stiffness = staticmethod(stomakhin_stiffness)

    poisson_ratio: Annotated[float, Field(ge=0.0, lt=0.5)]
    """ν [-]"""
    hardening: NonNegative
    """ξ: exponent of hardening with compaction [-]"""
    critical_compression: Annotated[Positive, Field(le=0.2)]
    """θ_c: principal compression at which snow yields [-]"""
    critical_stretch: Annotated[Positive, Field(lt=1.0)]
    """θ_s: principal stretch at which snow yields [-]"""

    @property
    def lame_modulus(self) -> float:
        """λ = K − 2G/3 [Pa]"""
        return self.bulk_modulus - 2.0 / 3.0 * self.shear_modulus

    @property
    def tensile_strength(self) -> float:
        stretch = 1.0 + self.critical_stretch
        shape = 2.0 * self.shear_modulus * self.critical_stretch * stretch
        return shape + self.lame_modulus * (stretch**3 - 1.0) * stretch**3

    def factor_at(self, state: ArrayLike) -> Array:
        """exp(ξ (1 − J_P)) at state (..., n_state). NumPy."""
        exponent = self.hardening * (1.0 - np.asarray(state, float)[..., 0])
        return np.exp(np.clip(exponent, -MAX_EXPONENT, MAX_EXPONENT))

    def parameters(self) -> StomakhinParameters:
        compressed = 1.0 - (1.0 - self.critical_compression) ** 2
        near = min(compressed, (1.0 + self.critical_stretch) ** 2 - 1.0, SERIES_RADIUS)
        return StomakhinParameters(
            mu=self.shear_modulus,
            lam=self.lame_modulus,
            xi=self.hardening,
            compression=self.critical_compression,
            stretch=self.critical_stretch,
            near2=near**2,
        )

    def initial_state(self) -> tuple[float, ...]:
        return (1.0,)

    def wave_speed_at(self, stress: Array, state: Array) -> Array:
        """√(M / ρ₀), M the stiffness of uniaxial strain: the larger of its elastic and its plastic bound.

        Elastic: 2μ s² + λ J_E² at the largest stretches; while compacting: |τ| (1 + ξ J_P), from dτ/dJ_P; both times
        the hardening factor of J_P, which is what a time step must follow. A bound: a few per cent above the elastic
        speed (7 per cent in the stiffness for the published thresholds).
        """
        squeezed, drawn = 1.0 - self.critical_compression, 1.0 + self.critical_stretch
        elastic = 2.0 * self.shear_modulus * drawn**2 + self.lame_modulus * drawn**6
        stress_limit = 2.0 * self.shear_modulus * squeezed * self.critical_compression
        stress_limit += self.lame_modulus * squeezed**3 * (1.0 - squeezed**3)
        plastic = stress_limit * (1.0 + self.hardening * np.asarray(state)[..., 0])
        return np.sqrt(self.factor_at(state) * np.maximum(elastic, plastic) / self.density)

    def principal_stretches(self, stress: ArrayLike, state: ArrayLike | None = None) -> Array:
        """Singular values of Fe (..., 3), in the order of `numpy.linalg.eigvalsh`, that carry a Kirchhoff stress.

        Solves τ_i = factor [2μ (s_i − 1) s_i + λ (J − 1) J] for s_i >= ½ and J >= ½, where J decides: s_i(J) falls, so
        Π s_i(J) = J has one solution at most. NaN where it has none: no such stretch carries the stress.
        """
        factor = self.factor_at(self.initial_state() if state is None else state)
        values = np.linalg.eigvalsh(np.asarray(stress, float)) / factor[..., None]
        mu, lam = self.shear_modulus, self.lame_modulus

        def deviations(j):
            c = (values - lam * ((1.0 + j) * j)[..., None]) / (2.0 * mu)
            return 2.0 * c / (1.0 + np.sqrt(np.maximum(1.0 + 4.0 * c, 0.0)))

        def excess(j):
            d = deviations(j)
            return d.sum(-1) + d[..., 0] * d[..., 1] + d[..., 1] * d[..., 2] + d[..., 2] * d[..., 0] + d.prod(-1) - j

        # The least principal stress reaches s = ½ at (J − 1) J = (τ_min + μ/2) / λ
        product = (values[..., 0] + 0.5 * mu) / max(lam, 1e-300)
        low = np.full(product.shape, -0.5)
        with np.errstate(invalid="ignore", over="ignore"):
            high = np.minimum(-0.5 + np.sqrt(0.25 + product), 1e6)
            solvable = (high > low) & (excess(low) >= 0.0) & (excess(high) <= 0.0)
        high = np.where(solvable, high, low)
        for _ in range(100):  # halvings of at most 1e6: down to the spacing of the numbers
            middle = 0.5 * (low + high)
            above = excess(middle) > 0.0
            low, high = np.where(above, middle, low), np.where(above, high, middle)
        return np.where(solvable[..., None], 1.0 + deviations(0.5 * (low + high)), np.nan)

    def h_from_stress(self, stress: ArrayLike) -> Array:
        """h (..., 3, 3) of a Kirchhoff stress at J_P = 1. Raises ValueError where no stretch carries it."""
        h = self._spectral(stress, self.principal_stretches(stress), lambda s: (s - 1.0) * (s + 1.0))
        if np.isnan(h).any():
            raise ValueError("a stress too large for this snow: no elastic stretch carries it")
        return h

    def hencky_from_stress(self, stress: ArrayLike, state: ArrayLike | None = None) -> Array:
        """Hencky strain (..., 3, 3) of a Kirchhoff stress at the J_P of its state, NaN where no stretch carries it."""
        return self._spectral(stress, self.principal_stretches(stress, state), np.log)

    def _spectral(self, stress, stretches, function):
        """Tensors coaxial with the stresses, of a function of their principal stretches."""
        _, vectors = np.linalg.eigh(np.asarray(stress, float))
        return np.einsum("...ik,...k,...jk->...ij", vectors, function(stretches), vectors)

    def elastic_energy(self, stress: Array, state: Array) -> Array:
        """ψ [J/m³] from the stretches that carry the stress at its J_P. NumPy."""
        s = self.principal_stretches(unpack(stress), state)
        volume = s.prod(-1) - 1.0
        shape = self.shear_modulus * ((s - 1.0) ** 2).sum(-1)
        return self.factor_at(state) * (shape + 0.5 * self.lame_modulus * volume**2)

    def yield_function(self, stress: ArrayLike, state: Array) -> Array:
        """Largest overrun of a threshold by a principal stretch [-], <= 0 where admissible; inf: none carries it."""
        s = self.principal_stretches(stress, state)
        overrun = np.maximum(s - 1.0 - self.critical_stretch, 1.0 - self.critical_compression - s).max(-1)
        return np.where(np.isnan(overrun), np.inf, overrun)

    def outputs(self, state: Array) -> dict[str, Array]:
        """stiffness_factor exp(ξ (1 − J_P)): above 1 hardened, below 1 damaged."""
        return {"stiffness_factor": self.factor_at(state)}
