"""Rows of a run file. Vectors have three components always, those of a plane-strain run with y = 0."""

import numpy as np

from snowmpm.errors import shown_line


def as_rows(values):
    """(n, 3) from (n, 3) or, with y = 0, from plane-strain (n, 2) rows (x, z); one row from a single vector."""
    values = np.atleast_2d(np.asarray(values))
    if values.ndim != 2 or values.shape[1] not in (2, 3):
        raise ValueError(f"shape {values.shape}, must be (n, 2) or (n, 3)")
    if values.shape[1] == 2:
        values = np.column_stack([values[:, 0], np.zeros(len(values), values.dtype), values[:, 1]])
    return np.ascontiguousarray(values)


def as_field(name, values, n):
    """A particle field as it is stored: (n,), (n, 3) or (n, 6), float32 or integers. ValueError for another shape."""
    values = np.asarray(values)
    if values.ndim == 2 and values.shape[1] == 2:
        values = as_rows(values)
    if values.shape not in ((n,), (n, 3), (n, 6)):
        raise ValueError(f"field {name}: shape {values.shape}, must be ({n},), ({n}, 3) or ({n}, 6)")
    if values.dtype == bool:
        return values.astype(np.uint8)
    return values.astype(np.float32, copy=False) if values.dtype.kind == "f" else values


def units_of(data):
    """Unit of a table in the file; "" if missing."""
    unit = data.attrs.get("units", "")
    return shown_line(unit, 40) if isinstance(unit, str) else ""
