"""How much the answer of a campaign still changes with more runs, and how many are enough.

The first m runs are compared with all n: the mean difference of the probability map in cells where the runs differ, and
the area with a probability of at least 5 %. The mean half-width of the binomial interval says how far m runs may be
from the truth; it goes with 1 / sqrt(m), from which follows the number of runs for a wanted half-width.
"""

import math

import numpy as np

from snowmpm.campaigns.probability import QUANTITIES, interval
from snowmpm.campaigns.stack import BLOCK

LIKELY = 0.05
"""Probability from which a cell counts as endangered."""

WANTED = 0.05
"""Half-width of the interval with which a campaign may stop."""


def convergence(stack, limits, rows, cell):
    """Rows {"quantity", "limit", "runs", "difference", "area", "half_width"} for growing numbers of runs.

    stack: `xarray.Dataset` of the runs; limits: [(quantity, limit)]; rows: positions in the stack of the runs that
    count, in the order of the design; cell [m].
    """
    found, growing = [], numbers(len(rows))
    for name, limit in limits:
        counts = _counts(stack[QUANTITIES[name][0]], limit, rows, growing)
        last = counts[-1] / len(rows)
        differ = (last > 0.0) & (last < 1.0)
        open_cells = differ if differ.any() else np.ones_like(differ)
        for m, count in zip(growing, counts, strict=True):
            share = count / m
            low, high = interval(count, m)
            found.append({"quantity": name, "limit": limit, "runs": m,
                          "difference": float(np.abs(share - last)[open_cells].mean()),
                          "area": float((share >= LIKELY).sum() * cell**2),
                          "half_width": float(0.5 * (high - low)[open_cells].mean())})
    return found


def _counts(raster, limit, rows, growing):
    """Runs above the limit among the first m, for each m (len(growing), y, x); a strip at a time, since all maps
    together may be larger than memory."""
    shape = raster.shape[1:]
    counts = np.zeros((len(growing), *shape), np.int32)
    tall = max(1, BLOCK // (4 * max(1, len(rows)) * shape[1]))
    for begin in range(0, shape[0], tall):
        strip = slice(begin, begin + tall)
        above = raster[rows, strip].values >= np.float32(limit)
        for k, m in enumerate(growing):
            counts[k, strip] = above[:m].sum(axis=0)
    return counts


def numbers(n):
    """Growing numbers of runs up to n, each about 1.4 times the one before."""
    steps = max(1, int(2 * math.log2(max(n / 8.0, 1.0))))
    return sorted({max(1, round(n / 2 ** (k / 2))) for k in range(steps + 1)})


def enough(rows):
    """{(quantity, limit): number of runs for a mean half-width of WANTED}."""
    last = {(row["quantity"], row["limit"]): row for row in rows}
    return {key: max(1, math.ceil(row["runs"] * (row["half_width"] / WANTED) ** 2)) for key, row in last.items()}
