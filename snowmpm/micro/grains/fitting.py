"""From tests of a sample of grains to the numbers of a law of the Cam-Clay family.

Young's modulus and Poisson's ratio are those of the rows where no bond is broken, by linear least squares. For the
other numbers the law is driven by the deformations F of each `DrivenCurve`. Least squares make its Cauchy stresses
those of the sample: the difference of six components over the largest stress of the curve, curves with equal weight.
Confidence intervals follow from the Jacobians. Rows of a curve are not independent: their number is divided by the
autocorrelation time of the residuals, which of elastic rows is a whole curve.

The second part starts from the yield ellipse through the points of largest stress, and hardening from the end of the
first curve.
"""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from snowmpm.materials import LAWS
from snowmpm.materials.stress_update import StressUpdate
from snowmpm.materials.symmetric import invariants, size, unpack

ROWS = 120
"""Of a curve that the law is compared with."""

NAMES = ("youngs_modulus", "poisson_ratio", "critical_slope", "cohesion", "p0", "hardening", "softening")
LOWEST = np.array([np.log(1e2), 0.0, np.log(0.2), 0.02, np.log(1e1), np.log(2e-3), 0.02])
HIGHEST = np.array([np.log(1e10), 0.45, np.log(5.0), 1.0, np.log(1e8), np.log(30.0), 0.95])
KINDS = {"anticrack_cam_clay": 7, "cohesive_cam_clay": 6}
"""Laws that can be fitted, and how many of `NAMES` they have."""

CONFIDENCE = 0.95


@dataclass(frozen=True)
class FittedLaw:
    """law; intervals: {name: (low, high)} of `CONFIDENCE`; errors: {curve: its `difference`}; peaks: {curve: largest
    stress of the law over that of the sample}."""

    law: Any
    intervals: dict
    errors: dict
    peaks: dict


def fitted_law(curves, kind="anticrack_cam_clay", density=100.0):
    """`FittedLaw` of a kind of law (`KINDS`) for `DrivenCurve`s, the first of them a closing beyond failure."""
    thin = [curve.thinned(ROWS) for curve in curves]
    elastic, elastic_covariance = elastic_unknowns(curves)
    free = slice(2, KINDS[kind])
    bounds = LOWEST[free], HIGHEST[free]
    start = np.clip(_start(curves, elastic)[free], bounds[0] + 1e-3, bounds[1] - 1e-3)

    def residual(x):
        return _residual(thin, law_of(kind, [*elastic, *x], density))

    begins = np.repeat(start[None], len(STRENGTHS) * len(SOFTENINGS), axis=0)
    strengths, softenings = np.array(list(itertools.product(STRENGTHS, SOFTENINGS))).T
    begins[:, 2] += strengths
    begins[:, 4:] = softenings[:, None]
    begins = sorted(begins.tolist(), key=lambda x: float((residual(x) ** 2).sum()))[:TRIED]
    tries = [least_squares(residual, begin, bounds=bounds, diff_step=5e-3, x_scale=SCALE[free], max_nfev=40)
             for begin in begins]
    found = min(tries, key=lambda one: one.cost)
    x = np.array([*elastic, *found.x])
    covariance, factor = _covariance(found, thin)
    law = law_of(kind, x, density)
    predicted = predictions(law, curves)
    errors = {curve.name: difference(curve, stress) for curve, stress in zip(curves, predicted, strict=True)}
    peaks = {curve.name: _largest(stress) / _largest(curve.stress)
             for curve, stress in zip(curves, predicted, strict=True)}
    return FittedLaw(law, _intervals(kind, x, block_diag(elastic_covariance, covariance), factor), errors, peaks)


def difference(curve, stress):
    """Root mean square, over the way of the deformation, of the difference between stresses (n, 3, 3) and those of a
    curve, over the largest of the curve."""
    steps = np.linalg.norm(np.diff(curve.deformation, axis=0), axis=(1, 2))
    way = np.gradient(np.concatenate([[0.0], np.cumsum(steps)]))
    square = ((stress - curve.stress) ** 2).sum(axis=(1, 2))
    return float(np.sqrt((square * way).sum() / way.sum()) / _largest(curve.stress))


STRENGTHS, SOFTENINGS = np.linspace(-0.3, 0.3, 9), (0.2, 0.4, 0.6, 0.8, 0.94)
"""What is tried at the start, since collapses make many minima: of log p0 beside the start, and of the last unknown."""

TRIED = 3
"""Best of these from which least squares begin."""

SCALE = np.array([0.3, 0.1, 0.3, 0.2, 0.3, 0.5, 0.3])
"""Of a step in each unknown."""


def numbers_of(kind, x, density):
    """Keys of a law by name, of the unknowns x: logarithms, and the softening over the largest with one answer."""
    values = {"kind": kind, "density": density, "youngs_modulus": float(np.exp(x[0])), "poisson_ratio": float(x[1]),
              "critical_slope": float(np.exp(x[2])), "cohesion": float(x[3]), "p0": float(np.exp(x[4])),
              "hardening": float(np.exp(x[5]))}
    if len(x) > 6:
        limit = LAWS[kind](**values, softening=1.0).critical_hardening()
        values["softening"] = float(x[6] * limit / values["hardening"])
    return values


def law_of(kind, x, density):
    """The law of the unknowns x."""
    return LAWS[kind](**numbers_of(kind, x, density))


def predictions(law, curves):
    """Cauchy stresses (n, 3, 3) [Pa] of a law along the deformations of each curve; NaN where its update fails."""
    longest = max(len(curve.bonds) for curve in curves)
    increments = np.zeros((len(curves), longest, 3, 3))
    for one, curve in zip(increments, curves, strict=True):
        F = curve.deformation
        before = np.concatenate([np.eye(3)[None], F[:-1]])
        one[: len(F)] = (F - before) @ np.linalg.inv(before)
    update = StressUpdate(law, 3, "f64")
    done = update.integrate(np.zeros((len(curves), size(3))), update.initial_state(len(curves)), increments)
    found = []
    for k, curve in enumerate(curves):
        rows = len(curve.bonds)
        stress = unpack(done.stress[k, :rows]) / np.linalg.det(curve.deformation)[:, None, None]
        found.append(np.where((done.iterations[k, :rows] < 0)[:, None, None], np.nan, stress))
    return found


def _largest(stress):
    return max(float(np.linalg.norm(stress.reshape(len(stress), 9), axis=1).max()), 1e-300)


def _residual(curves, law):
    parts = []
    for curve, stress in zip(curves, predictions(law, curves), strict=True):
        difference = np.nan_to_num(stress - curve.stress, nan=10.0 * _largest(curve.stress)) / _largest(curve.stress)
        parts.append(difference.reshape(-1) / np.sqrt(len(curve.bonds)))
    return np.concatenate(parts)


def _intervals(kind, x, covariance, factor):
    """{name: (low, high)} of the logarithm of each number, which hangs on the unknowns linearly near the end."""
    def logarithms(of):
        numbers = numbers_of(kind, of, 1.0)
        return np.log([max(numbers[name], 1e-12) for name in NAMES[: len(x)]])

    slope = np.array([(logarithms(x + step) - logarithms(x - step)) / 2e-5 for step in 1e-5 * np.eye(len(x))]).T
    half = factor * np.sqrt(np.diag(slope @ covariance @ slope.T))
    middle = logarithms(x)
    return {name: (float(np.exp(middle[k] - half[k])), float(np.exp(middle[k] + half[k])))
            for k, name in enumerate(NAMES[: len(x)])}


def _covariance(found, curves):
    """Covariance of the unknowns, and what its square roots are multiplied with for an interval."""
    at, times = 0, []
    for curve in curves:
        part = found.fun[at : at + 9 * len(curve.bonds)].reshape(-1, 9)
        at += 9 * len(curve.bonds)
        times.append(_autocorrelation_time(part))
    independent = 6.0 * sum(len(curve.bonds) / time for curve, time in zip(curves, times, strict=True))
    free = max(1.0, independent - len(found.x))
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * (found.fun**2).sum() / free
    return covariance, float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, free))


def _autocorrelation_time(rows):
    """1 + 2 times the sum of the autocorrelations of columns of rows, up to the first that is not positive."""
    power = (rows**2).sum()
    time = 1.0
    for lag in range(1, len(rows)):
        correlation = (rows[:-lag] * rows[lag:]).sum() / max(power, 1e-300)
        if correlation <= 0.0:
            break
        time += 2.0 * correlation
    return time


def _start(curves, elastic):
    """Unknowns to begin with."""
    young, poisson = np.exp(elastic[0]), elastic[1]
    points = []
    for curve in curves:
        whole = np.flatnonzero(curve.bonds > 0.9)
        row = whole[np.argmax(np.linalg.norm(curve.stress[whole].reshape(-1, 9), axis=1))]
        points.append(invariants(curve.stress[row]))
    p, q = np.array(points).T
    scale = float(np.abs(p).max() + q.max())

    def ellipse(x):
        M2, shape, beta, p0 = np.exp(2.0 * x[0]), 1.0 + 2.0 * x[1], x[1], scale * np.exp(x[2])
        value = q**2 * shape + M2 * (p + beta * p0) * (p - p0)
        return value / np.hypot(2.0 * q * shape, M2 * (2.0 * p - (1.0 - beta) * p0)) / scale

    surface = least_squares(ellipse, [0.2, 0.4, 0.0], bounds=([-1.6, 0.02, -2.0], [1.6, 1.0, 3.0])).x
    K = young / (3.0 * (1.0 - 2.0 * poisson))
    end = curves[0]
    compaction = -np.log(np.linalg.det(end.deformation[-1]))
    hardening = np.arcsinh(max(invariants(end.stress[len(end.bonds) // 2 :].mean(axis=0))[0], 1.0) / K)
    hardening /= 0.5 * max(compaction, 1e-3)
    return np.array([np.log(young), poisson, surface[0], surface[1], np.log(scale) + surface[2], np.log(hardening),
                     0.5])


def elastic_unknowns(curves, whole=0.999):
    """The first two unknowns, log E and Poisson's ratio, of the rows before a bond is broken; their covariance (2, 2).

    Each curve counts as often as there are components, since its residuals are those of a straight line.
    """
    left, right = [], []
    for curve in curves:
        until = int(np.argmax(curve.bonds < whole)) or len(curve.bonds)
        F = curve.deformation[:until]
        strain = 0.5 * (F + F.transpose(0, 2, 1)) - np.eye(3)
        volume = np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        left.append(np.stack([volume.reshape(-1), 2.0 * strain.reshape(-1)], axis=1))
        right.append(curve.stress[:until].reshape(-1))
    left, right = np.concatenate(left), np.concatenate(right)
    moduli, *_ = np.linalg.lstsq(left, right, rcond=None)

    def unknowns(lame, shear):
        poisson = lame / (2.0 * (lame + shear))
        return np.array([np.log(2.0 * shear * (1.0 + poisson)), poisson])

    variance = ((left @ moduli - right) ** 2).sum() / max(1.0, 6.0 * len(curves) - 2.0)
    slope = np.array([(unknowns(*(moduli + step)) - unknowns(*(moduli - step))) / (2e-4 * moduli[1])
                      for step in 1e-4 * moduli[1] * np.eye(2)]).T
    return unknowns(*moduli), slope @ (np.linalg.inv(left.T @ left) * variance) @ slope.T
