"""Tables of weighted samples: what a calibration writes, and what a forecast draws from."""

import functools
from pathlib import Path

import numpy as np

from snowmpm.draft import write_table
from snowmpm.errors import InputError, did_you_mean
from snowmpm.reading.table_file import read_table

WEIGHT = "weight"
DISTANCE = "distance"


def write_posterior(path, names, values, weights, distances):
    """Write samples (n, d) of the named parameters, each with weight and distance, as CSV; -> its path."""
    rows = [[*map(repr, map(float, row)), repr(float(weight)), repr(float(distance))]
            for row, weight, distance in zip(values, weights, distances, strict=True)]
    return write_table(path, [*names, WEIGHT, DISTANCE], rows)


@functools.lru_cache(maxsize=8)
def read_posterior(path):
    """{column: (n,)} of a file that `write_posterior` wrote. InputError for another."""
    rows = read_table(Path(path), lambda row: {name: float(value) for name, value in row.items()})
    if not rows or WEIGHT not in rows[0]:
        raise InputError(f"{path}: not a table of samples: has no column {WEIGHT}")
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    weights = table[WEIGHT]
    if not (np.isfinite(weights).all() and (weights >= 0.0).all() and weights.sum() > 0.0):
        raise InputError(f"{path}: column {WEIGHT}: must be numbers >= 0, not all 0")
    return table


def rows_of(path, column, where):
    """Function share u -> value of the column in the row up to which the share u of the weight lies."""
    table = read_posterior(str(path))
    if column not in table or column in (WEIGHT, DISTANCE):
        known = [name for name in table if name not in (WEIGHT, DISTANCE)]
        raise InputError(f"{where}: {path} has no column {column}{did_you_mean(column, known)}; it has"
                         f" {', '.join(known)}")
    ends = np.cumsum(table[WEIGHT]) / table[WEIGHT].sum()

    def value(u):
        return float(table[column][min(int(np.searchsorted(ends, u, side="right")), len(ends) - 1)])

    return value
