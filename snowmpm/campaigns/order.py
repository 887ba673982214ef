"""Order of convergence over a grid of cells: from the last three values of a number that varies with `solver.dx`.

With f(h) = f_0 + C h^p on spacings h_3 > h_2 > h_1 (Roache 1997, doi:10.1146/annurev.fluid.29.1.123):

    (f_3 - f_2) / (f_2 - f_1) = (h_3^p - h_2^p) / (h_2^p - h_1^p)

Differences that alternate, or that do not shrink, have no order. Against a reference, the order is the slope of
ln |error| over ln h.

The interval of the value on the finest cells is the grid convergence index (Roache 1994, doi:10.1115/1.2910291),

    f_1 +- F |f_2 - f_1| / ((h_2 / h_1)^p - 1)

with F = 1.25 and the order that three grids show, 2 at most, which is that of the schemes, else F = 3 and p = 1. It is
at least the resolution of the number on the cells of the maps (`quantities.resolution`).
"""

import numpy as np
from scipy.optimize import brentq

from snowmpm.campaigns.distributions import Choices
from snowmpm.campaigns.table import OF_OTHERS, parts
from snowmpm.quantities.resolution import resolutions
from snowmpm.quantities.table import quantity

KEY = "solver.dx"
LEAST, MOST = 0.05, 8.0
"""Orders that are looked for."""
FORMAL = 2.0
"""Order of the schemes at best: a higher one is chance."""
SEEN, ASSUMED = 1.25, 3.0
"""Factors of safety of the grid convergence index: with an order from three grids, and with one of 1."""


def order(spacings, values):
    """(order, value towards which it goes) of values (k,) on spacings (k,), coarse to fine; None where they have
    none."""
    h, f = np.asarray(spacings, float)[-3:], np.asarray(values, float)[-3:]
    if len(h) < 3 or not np.isfinite(f).all():
        return None
    before, last = f[0] - f[1], f[1] - f[2]
    if last == 0.0 or before / last <= 0.0:
        return None

    def open_at(p):
        return (h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p) - before / last

    if open_at(LEAST) * open_at(MOST) > 0.0:
        return None
    p = brentq(open_at, LEAST, MOST)
    return float(p), float(f[2] - last * h[2] ** p / (h[1] ** p - h[2] ** p))


def interval(spacings, values):
    """Half width of the interval of the last of values (k,) on spacings (k,), coarse to fine; None of one grid."""
    h, f = np.asarray(spacings, float)[-2:], np.asarray(values, float)[-2:]
    if len(h) < 2 or not np.isfinite(f).all():
        return None
    found = order(spacings, values)
    safety, p = (SEEN, min(found[0], FORMAL)) if found else (ASSUMED, 1.0)
    return float(safety * abs(f[1] - f[0]) / ((h[0] / h[1]) ** p - 1.0))


def order_of_errors(spacings, errors):
    """Order by relative errors (k,) against a reference; None where they do not shrink."""
    h, size = np.asarray(spacings, float), np.abs(np.asarray(errors, float))
    if len(h) < 3 or not (np.isfinite(size) & (size > 0.0)).all():
        return None
    p = float(np.polyfit(np.log(h), np.log(size), 1)[0])
    return p if p > 0.0 else None


def grid_of_spacings(file):
    """Name of the parameter of a `CampaignFile` that varies the spacing over two values or more; None without."""
    for name, one in file.parameters.items():
        if one.keys == (KEY,) and isinstance(one, Choices) and len(one.values) >= 2:
            return name
    return None


def on_the_finest(campaign, names):
    """Rows of what a grid of spacings says of these numbers, for each choice of the other parameters.

    where: that choice, in words; number; spacing: the finest on which it has a value [m]; value on it; interval: half
    its width, None of one grid; grids: that have a value, of so many; order, None where there is none; reference:
    whether it is against one.
    """
    spacing, table = grid_of_spacings(campaign.file), campaign.table
    if spacing is None:
        return []
    cell = _map_cell(campaign.example)
    others, rows = [name for name in campaign.file.parameters if name != spacing], []
    for where, own in parts(table, others, spacing):
        own = own[::-1]  # coarse to fine
        for name in names:
            if name not in own or name.endswith("_error") or len(own) < 2:
                continue
            there = own[np.isfinite(own[name].to_numpy(float))]
            errors, h, values = there.get(f"{name}_error"), *(there[key].to_numpy(float) for key in (spacing, name))
            if not len(h):
                continue
            found = order(h, values) if errors is None else [order_of_errors(h, errors.to_numpy(float))]
            rows.append({"where": where, "number": name, "spacing": float(h[-1]), "value": float(values[-1]),
                         "interval": _interval(there, name, h, values, cell), "grids": len(h), "of": len(own),
                         "order": found[0] if found else None, "reference": errors is not None})
    return rows


def _interval(rows, name, spacings, values, map_cell):
    """`interval`, and at least the resolution of the number on the finest cells; None of one grid."""
    half, finest = interval(spacings, values), rows.iloc[-1]
    if half is None:
        return None
    measured = [float(finest[name + end]) for end in OF_OTHERS if name + end in rows]
    numbers = {key: float(finest[key]) for key in (name, "runout", "fall") if key in rows}
    resolution = resolutions(numbers, max(map_cell, spacings[-1])).get(name, 0.0)
    return max([half, resolution, *(value for value in measured if np.isfinite(value))])


def _map_cell(run):
    """Side of the map cells [m] of the runs of a campaign, which all have the same; 0 without maps."""
    raster = run.maps.get("peak_depth") if run else None
    return raster.cell if raster is not None else 0.0


def orders(campaign, names):
    """`on_the_finest` in words, a line each."""
    lines = []
    for row in on_the_finest(campaign, names):
        number = quantity(row["number"], dimension=campaign.dimension)
        where = f"{row['where']}: " if row["where"] else ""
        known = f"order {row['order']:.2g}" if row["order"] else "no order of convergence"
        known += " against the reference" if row["reference"] else ""
        known = "no interval of one grid" if row["interval"] is None else known
        some = f" ({row['grids']} of {row['of']} grids have a value)" if row["grids"] < row["of"] else ""
        lines.append(f"{where}{number.label} {number.text(row['value'], row['interval'])} on cells of"
                     f" {row['spacing']:g} m, {known}{some}")
    return lines
