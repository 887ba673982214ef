"""What the numbers of a campaign depend on: shares of their variance by parameter, and rank correlations.

    first order S_k = Var(E(y | x_k)) / Var(y),   total T_k = 1 - Var(E(y | all but x_k)) / Var(y)

A saltelli design gives both without a model (`scipy.stats.sobol_indices`); of other random designs they are those of an
emulator (`snowmpm.campaigns.emulator`), with its quality. Both need independent parameters. Intervals are bootstrapped
(95 %).
"""

import numpy as np
from scipy import stats

from snowmpm.campaigns import emulator
from snowmpm.campaigns.design import random_of

LEAST = 16
"""Runs below which no indices are given."""

RESAMPLES = 100
TRUSTED = 0.8
"""Quality of an emulator from which its indices are shown."""


def sensitivities(design, u, numbers, names, independent=True, seed=0):
    """Rows {"number", "parameter", "correlation", "first", "first_low", "first_high", "total", ..., "quality",
    "method"}.

    design: its kind; u (n, d): shares of the parameters (`names`); numbers: {name: (n,)}, NaN of failed runs.
    """
    rows, fits = [], {}
    for number, values in numbers.items():
        there = np.isfinite(values)
        if there.sum() < LEAST or np.ptp(values[there]) <= 1e-9 * np.abs(values[there]).max():
            continue
        found = _of_design(design, u, values, seed, fits) if independent else None
        for k, name in enumerate(names):
            row = {"number": number, "parameter": name, "correlation": _rank(u[there, k], values[there])}
            rows.append(row | ({part: found[part][k] for part in PARTS} if found else dict.fromkeys(PARTS, np.nan)) | {
                "quality": found["quality"] if found else np.nan, "method": found["method"] if found else ""})
    return rows


PARTS = ("first", "first_low", "first_high", "total", "total_low", "total_high")


def _rank(x, y):
    return float(stats.spearmanr(x, y).statistic) if np.ptp(x) > 0.0 else 0.0


def _of_design(design, u, values, seed, fits):
    if design == "saltelli":
        return saltelli_indices(values, u.shape[1], seed)
    if design in ("latin_hypercube", "sobol", "random"):
        return emulated_indices(u, values, seed, fits)
    return None


def saltelli_indices(values, d, seed):
    """Indices from values (n (d + 2),) of a saltelli design; of the runs of its base that all succeeded, as many as a
    power of 2. None of too few."""
    table = values.reshape(d + 2, -1)
    whole = table[:, np.isfinite(table).all(axis=0)]
    n = 1 << (whole.shape[1].bit_length() - 1) if whole.shape[1] else 0
    if n < LEAST:
        return None
    first, second, mixed = whole[None, 0, :n], whole[None, 1, :n], whole[2:, None, :n]
    found = stats.sobol_indices(func={"f_A": first, "f_B": second, "f_AB": mixed}, n=n,
                                **random_of(stats.sobol_indices, seed))
    boot = found.bootstrap(confidence_level=0.95, n_resamples=RESAMPLES)
    ends = {"first": boot.first_order.confidence_interval, "total": boot.total_order.confidence_interval}
    return {"first": np.ravel(found.first_order), "total": np.ravel(found.total_order), "quality": 1.0,
            **{f"{name}_{side}": np.ravel(getattr(ends[name], side)) for name in ends for side in ("low", "high")},
            "method": f"saltelli, n = {n}"}


def emulated_indices(u, values, seed, fits):
    """Indices of the emulator of values (n,) at shares (n, d); None of too few runs, or one not to be trusted.

    fits: `emulator.Fits` by the runs that have a value, kept for other numbers.
    """
    there = np.isfinite(values)
    if there.tobytes() not in fits:
        fits[there.tobytes()] = emulator.Fits(u[there])
    known = fits[there.tobytes()]
    values = values[there]
    best = known.best(values)
    if best is None or best.quality < TRUSTED:
        return None
    again = [one.indices() for one in known.refits(best, values, RESAMPLES, np.random.default_rng(seed))]
    first, total = best.indices()
    low, high = (np.quantile(again, end, axis=0) for end in (0.025, 0.975))
    return {"first": first, "total": total, "first_low": low[0], "first_high": high[0], "total_low": low[1],
            "total_high": high[1], "quality": best.quality,
            "method": f"polynomial of degree {best.powers.sum(axis=1).max()}"}
