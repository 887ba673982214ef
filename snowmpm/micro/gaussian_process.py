"""A Gaussian process through scattered values, with what it does not know.

    y(x) = m + f(x) + noise,   cov(f(x), f(x')) = s^2 (1 + sqrt(5) r + 5 r^2 / 3) exp(-sqrt(5) r),
    r^2 = sum_a (x_a - x'_a)^2 / l_a^2                       (Matern 5/2: Rasmussen and Williams 2006, 4.17)

l, s and the noise make the values most likely (their 5.8 and 5.9). Twice continuously differentiable only, since
tractions bend sharply where bonds fail. For some hundred points: the time goes with the cube of their number. The
polynomials of `campaigns.emulator` are for results of runs over a box of parameters; they swing at such bends.
"""

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize

ROOT = np.sqrt(5.0)
LOWEST, HIGHEST = 1e-3, 1e2
"""Of lengths, over the spread of the points, and of s, over that of the values."""

LEAST_NOISE = 1e-3
"""Over the spread of the values."""


class GaussianProcess:
    """Of points x (n, d) and values y (n,). noise: standard deviation of a value, lengths (d,): in units of x.

    Raises ValueError for values that are not finite, and for less than two points.
    """

    def __init__(self, x, y):
        x, y = np.asarray(x, float), np.asarray(y, float)
        if len(x) < 2 or not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise ValueError("a Gaussian process needs two points or more, and finite numbers")
        self._scale, self._mean = np.where(np.ptp(x, axis=0) > 0.0, np.ptp(x, axis=0), 1.0), float(y.mean())
        self._spread = max(float(y.std()), 1e-300)
        self._x, self._y = x / self._scale, (y - self._mean) / self._spread
        d = x.shape[1]
        start = np.log([*np.full(d, 0.5), 1.0, 0.1])
        bounds = [*[tuple(np.log([LOWEST, HIGHEST]))] * (d + 1), tuple(np.log([LEAST_NOISE, 1.0]))]
        found = minimize(self._unlikelihood, start, jac=True, bounds=bounds, method="L-BFGS-B")
        self._numbers = np.exp(found.x)
        self.lengths, self.noise = self._numbers[:d] * self._scale, self._numbers[-1] * self._spread
        covariance, _ = _matern(self._x, self._x, self._numbers)
        self._factor = cho_factor(covariance + self._numbers[-1] ** 2 * np.eye(len(x)), lower=True)
        self._weights = cho_solve(self._factor, self._y)

    def __call__(self, x):
        """Values (m,) at points (m, d), and standard deviations (m,) of what would be seen there, noise included."""
        covariance, _ = _matern(np.asarray(x, float) / self._scale, self._x, self._numbers)
        known = solve_triangular(self._factor[0], covariance.T, lower=True)
        variance = self._numbers[-2] ** 2 + self._numbers[-1] ** 2 - (known**2).sum(axis=0)
        return self._mean + self._spread * covariance @ self._weights, self._spread * np.sqrt(np.maximum(variance, 0.0))

    def _unlikelihood(self, logarithms):
        """-log p(y), and its slopes by the logarithms of the lengths, of s and of the noise."""
        numbers = np.exp(logarithms)
        covariance, slopes = _matern(self._x, self._x, numbers)
        noise = numbers[-1] ** 2
        factor = cho_factor(covariance + noise * np.eye(len(self._y)), lower=True)
        weights = cho_solve(factor, self._y)
        rest = cho_solve(factor, np.eye(len(self._y))) - np.outer(weights, weights)
        value = 0.5 * self._y @ weights + np.log(np.diag(factor[0])).sum()
        slope = [0.5 * (rest * part).sum() for part in slopes]
        return value, np.array([*slope, (rest * covariance).sum(), noise * np.trace(rest)])


def _matern(x, z, numbers):
    """Covariances (n, m), and their slopes by the logarithm of each length (d, n, m)."""
    lengths, size = numbers[:-2], numbers[-2]
    parts = ((x[:, None] - z[None]) / lengths) ** 2
    r = np.sqrt(parts.sum(axis=2))
    fall = size**2 * np.exp(-ROOT * r)
    slopes = np.moveaxis(parts, 2, 0) * (fall * (5.0 / 3.0) * (1.0 + ROOT * r))
    return fall * (1.0 + ROOT * r + 5.0 / 3.0 * r**2), slopes
