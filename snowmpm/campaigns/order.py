"""Order of convergence over a grid of cells: from the last three values of a number that varies with `solver.dx`.

With f(h) = f_0 + C h^p on spacings h_3 > h_2 > h_1 (Roache 1997, doi:10.1146/annurev.fluid.29.1.123):

    (f_3 - f_2) / (f_2 - f_1) = (h_3^p - h_2^p) / (h_2^p - h_1^p)

Differences that alternate, or that do not shrink, have no order. Against a reference, the order is the slope of
ln |error| over ln h.
"""

import math

import numpy as np
from scipy.optimize import brentq

from snowmpm.campaigns.distributions import Choices
from snowmpm.campaigns.table import parts

KEY = "solver.dx"
LEAST, MOST = 0.05, 8.0
"""Orders that are looked for."""


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


def order_of_errors(spacings, errors):
    """Order by relative errors (k,) against a reference; None where they do not shrink."""
    h, size = np.asarray(spacings, float), np.abs(np.asarray(errors, float))
    if len(h) < 3 or not (np.isfinite(size) & (size > 0.0)).all():
        return None
    p = float(np.polyfit(np.log(h), np.log(size), 1)[0])
    return p if p > 0.0 else None


def grid_of_spacings(file):
    """Name of the parameter of a `CampaignFile` that varies the spacing over three values or more; None without."""
    for name, one in file.parameters.items():
        if one.keys == (KEY,) and isinstance(one, Choices) and len(one.values) >= 3:
            return name
    return None


def orders(campaign, names):
    """Lines: of each of these numbers, for each choice of the other parameters, its order over the spacings."""
    spacing, table = grid_of_spacings(campaign.file), campaign.table
    if spacing is None:
        return []
    others = [name for name in campaign.file.parameters if name != spacing]
    lines = []
    for where, own in parts(table, others, spacing):
        own = own[::-1]  # coarse to fine
        lines += [f"{where + ': ' if where else ''}{name}: {_words(own, spacing, name)}"
                  for name in names if name in own and not name.endswith("_error")]
    return lines


def _words(own, spacing, name):
    h, values = own[spacing].to_numpy(float), own[name].to_numpy(float)
    errors = own.get(f"{name}_error")
    if errors is not None:
        found = order_of_errors(h, errors.to_numpy(float))
        return f"order {found:.2g} against the reference" if found else "no order: the errors do not shrink"
    found = order(h, values)
    if found is None:
        return "no order: the differences do not shrink"
    return f"order {found[0]:.2g}, towards {found[1]:.4g}" if math.isfinite(found[1]) else f"order {found[0]:.2g}"
