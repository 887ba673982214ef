"""Designs: which shares of the parameters' distributions the runs of a campaign take.

A design is an array (runs, parameters) of shares from 0 to 1. It follows from its kind, seed and number of runs, so
that run i of a campaign can be made again from these and i.

    latin_hypercube   each parameter takes each of n equal shares once (McKay et al. 1979, doi:10.2307/1268522)
    sobol             scrambled Sobol sequence (Owen 1998); balanced for n = 2^m
    random            independent; run i does not depend on n, so that more runs may be added
    saltelli          for sensitivities: n base runs twice, and with each column exchanged, n (d + 2) runs in all
                      (Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018)
    grid              all combinations of levels
    one_at_a_time     the middle, and from there each parameter alone at its levels
"""

import inspect
import itertools
import warnings

import numpy as np
from scipy.stats import norm, qmc

DESIGNS = ("latin_hypercube", "sobol", "random", "saltelli", "grid", "one_at_a_time")
COUNTED = ("latin_hypercube", "sobol", "random", "saltelli")
"""Designs of a given number of runs."""

RANDOM = ("latin_hypercube", "sobol", "random")
"""Designs whose runs are as likely as the parameters: shares of runs are probabilities."""


def shares(kind, n, d, seed, levels=()):
    """Design (runs, d) of shares in [0, 1]. n: its number of runs (saltelli: of its base, a power of 2); levels: shares
    of each parameter, for grid and one_at_a_time."""
    if kind == "grid":
        return np.array(list(itertools.product(*levels)), float).reshape(-1, d)
    if kind == "one_at_a_time":
        rows = [np.full(d, 0.5)]
        for k, own in enumerate(levels):
            for share in own:
                rows.append(np.full(d, 0.5))
                rows[-1][k] = share
        return np.unique(np.array(rows), axis=0)
    if kind == "random":
        return np.array([np.random.default_rng([seed, i]).random(d) for i in range(n)]).reshape(n, d)
    if kind == "saltelli":
        return saltelli(n, d, seed)
    engine = {"latin_hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[kind]
    return _drawn(engine(d, **random_of(engine, seed)), n)


def _drawn(engine, n):
    with warnings.catch_warnings():  # a Sobol sequence cut short is less balanced, and still even
        warnings.simplefilter("ignore", UserWarning)
        return engine.random(n)


def random_of(function, seed):
    """The argument of a SciPy function that takes its random numbers, whose name changed with SciPy 1.15."""
    known = inspect.signature(function).parameters
    name = next(name for name in ("rng", "seed", "random_state") if name in known)
    return {name: np.random.default_rng(seed)}


def saltelli(n, d, seed):
    """Rows A (n), B (n), then A with column k of B, for each k."""
    both = _drawn(qmc.Sobol(2 * d, **random_of(qmc.Sobol, seed)), n)
    first, second = both[:, :d], both[:, d:]
    mixed = []
    for k in range(d):
        mixed.append(first.copy())
        mixed[-1][:, k] = second[:, k]
    return np.concatenate([first, second, *mixed])


def correlated(u, matrix):
    """Shares (n, d) with the correlations (d, d) of a Gaussian copula: of the normal scores of the parameters."""
    tiny = np.finfo(float).eps
    scores = norm.ppf(np.clip(u, tiny, 1.0 - tiny))
    return norm.cdf(scores @ np.linalg.cholesky(matrix).T)
