"""A polynomial through the results of runs: number = sum of c_a P_a(u), u the shares of the parameters.

P_a are products of shifted Legendre polynomials, orthonormal over [0, 1]^d, so that the parts of the variance are sums
of squares of coefficients (Sudret 2008, doi:10.1016/j.ress.2007.04.002):

    first order of k: terms of u_k alone,  total of k: all terms with u_k

Its quality Q2 = 1 - (leave-one-out error)^2 / variance decides the degree, and whether it may be believed.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legval

HIGHEST = 6
"""Largest total degree."""

POINTS = 1.5
"""Least number of runs a term."""


@dataclass(frozen=True)
class Emulator:
    """powers (t, d): degree of each term in each parameter; coefficients (t,); quality: Q2."""

    powers: np.ndarray
    coefficients: np.ndarray
    quality: float

    def __call__(self, u):
        """Values (n,) at shares (n, d)."""
        return basis(np.asarray(u, float), self.powers) @ self.coefficients

    def indices(self):
        """(first (d,), total (d,)) shares of the variance."""
        parts = self.coefficients**2
        moving = self.powers > 0
        variance = parts[moving.any(axis=1)].sum()
        if variance <= 0.0:
            return np.zeros(self.powers.shape[1]), np.zeros(self.powers.shape[1])
        alone = moving & (moving.sum(axis=1) == 1)[:, None]
        return (parts @ alone) / variance, (parts @ moving) / variance


def basis(u, powers):
    """Values (n, t) of the terms at shares (n, d)."""
    highest = int(powers.max(initial=0))
    # P[k] (n, d): Legendre polynomial of degree k, of unit mean square over [0, 1]
    each = [np.sqrt(2 * k + 1) * legval(2.0 * u - 1.0, np.eye(highest + 1)[k]) for k in range(highest + 1)]
    values = np.ones((len(u), len(powers)))
    for t, row in enumerate(powers):
        for k, degree in enumerate(row):
            if degree:
                values[:, t] *= each[degree][:, k]
    return values


def terms(d, degree):
    """Powers (t, d) of all terms up to a total degree."""
    rows = [row for row in itertools.product(range(degree + 1), repeat=d) if sum(row) <= degree]
    return np.array(sorted(rows, key=lambda row: (sum(row), row)), int).reshape(-1, d)


class Fits:
    """Polynomials of growing degree at the same shares u (n, d), for any number of results."""

    def __init__(self, u):
        self._u, self._bases = u, []
        for degree in range(1, HIGHEST + 1):
            powers = terms(u.shape[1], degree)
            if len(u) < POINTS * len(powers) + 1:
                break
            columns = basis(u, powers)
            q, r = np.linalg.qr(columns)
            leverage = np.minimum((q**2).sum(axis=1), 1.0 - 1e-9)
            self._bases.append((powers, columns, np.linalg.solve(r, q.T), leverage))

    def best(self, values):
        """`Emulator` of values (n,), of the degree with the best Q2; None of too few runs."""
        found, variance = None, float(np.var(values))
        for powers, columns, solve, leverage in self._bases:
            coefficients = solve @ values
            left_out = (values - columns @ coefficients) / (1.0 - leverage)
            quality = 1.0 - float(np.mean(left_out**2)) / variance if variance > 0.0 else 0.0
            if found is None or quality > found.quality:
                found = Emulator(powers, coefficients, quality)
        return found

    def refits(self, found, values, times, rng):
        """Emulators of the same terms as `found`, each to values whose residuals are drawn anew. Residuals rather than
        runs: a run drawn twice would leave too few for the terms."""
        columns, solve = next((columns, solve) for powers, columns, solve, _ in self._bases if powers is found.powers)
        fitted = columns @ found.coefficients
        spread = (values - fitted)[rng.integers(len(values), size=(len(values), times))]
        return [Emulator(found.powers, one, found.quality) for one in (solve @ (fitted[:, None] + spread)).T]
