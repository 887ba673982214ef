"""Maps over all runs: how likely a depth, speed or pressure is exceeded, how sure that is, and quantiles.

With k of n runs above a limit in a cell, the probability is k / n. Its interval holds the true share of an unlimited
campaign with 95 % or more (Clopper and Pearson 1934, doi:10.1093/biomet/26.4.404): for independent runs; a Latin
hypercube or a Sobol sequence is nearer to it. The interval is of the sampling alone, not of the model.

Agreement of a cell: the share of runs on the side of the majority, whether the flow is at least the first limit of
depth deep; 0.5: open, 1: all runs say the same.
"""

import numpy as np
from scipy.stats import beta

from snowmpm.campaigns.stack import BLOCK, FORMAT, STORE
from snowmpm.stages import counted

CONFIDENCE = 0.95
QUANTITIES = {"depth": ("peak_depth", "m"), "speed": ("peak_speed", "m/s"), "pressure": ("peak_pressure", "Pa")}
"""Raster and unit of what is exceeded."""


def short(limit, unit):
    """A limit with its unit, without digits that say nothing."""
    return f"{limit / 1e3:g} kPa" if unit == "Pa" and limit >= 1e3 else f"{limit:g} {unit}"


def interval(count, n, confidence=CONFIDENCE):
    """Lower and upper end of the exact binomial interval of a share, for counts (any shape) of n."""
    k, tail = np.arange(n + 1), 0.5 * (1.0 - confidence)
    with np.errstate(invalid="ignore"):
        low = np.where(k == 0, 0.0, beta.ppf(tail, k, n - k + 1))
        high = np.where(k == n, 1.0, beta.ppf(1.0 - tail, k + 1, n - k))
    return low[count], high[count]


def write_maps(folder, variant, stack, wanted, rows, attributes):
    """Write maps.zarr/VARIANT/maps; -> its `xarray.Dataset`.

    stack: `xarray.Dataset` of the runs; wanted: table `maps` of the campaign's file; rows: which runs count (positions
    in the stack); attributes: of the data set.
    """
    import xarray

    shape = (stack.sizes["y"], stack.sizes["x"])
    found = {}
    for name, (_, unit) in QUANTITIES.items():
        limits = np.array(sorted(wanted[name]), float)
        if len(limits):
            for end in ("", "_low", "_high"):
                found[f"{name}_probability{end}"] = ((f"{name}_limit", "y", "x"), np.zeros((len(limits), *shape)), {
                    "units": "1"})
        found[f"{name}_quantile"] = (("quantile", "y", "x"), np.zeros((len(wanted.quantiles), *shape), np.float32), {
            "units": unit})
    found["agreement"] = (("y", "x"), np.ones(shape), {"units": "1"})
    tall = max(1, BLOCK // (4 * max(1, len(rows)) * shape[1]))
    for begin in counted(range(0, shape[0], tall), "probabilities", "strips"):
        _fill(found, stack, wanted, rows, slice(begin, begin + tall))
    coordinates = {"x": stack.x, "y": stack.y, "quantile": sorted(wanted.quantiles)}
    coordinates |= {f"{name}_limit": (f"{name}_limit", sorted(wanted[name]), {"units": unit})
                    for name, (_, unit) in QUANTITIES.items() if wanted[name]}
    maps = xarray.Dataset(found, coordinates, {**attributes, "runs": len(rows), "cell": stack.attrs["cell"],
                                               "confidence": CONFIDENCE})
    maps.to_zarr(folder / STORE, group=f"{variant}/maps", mode="w", **FORMAT)
    return maps


def _fill(found, stack, wanted, rows, strip):
    n = len(rows)
    for name, (raster, _) in QUANTITIES.items():
        values = stack[raster][rows, strip].values
        for k, limit in enumerate(sorted(wanted[name])):
            count = (values >= np.float32(limit)).sum(axis=0)
            low, high = interval(count, n)
            for end, share in (("", count / n), ("_low", low), ("_high", high)):
                found[f"{name}_probability{end}"][1][k, strip] = share
            if name == "depth" and k == 0:
                found["agreement"][1][strip] = np.maximum(count, n - count) / n
        found[f"{name}_quantile"][1][:, strip] = np.quantile(values, sorted(wanted.quantiles), axis=0)
