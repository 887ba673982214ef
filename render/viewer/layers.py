"""The maps of a run as layers on the ground of an interactive page."""

import matplotlib
import numpy as np

from snowmpm.quantities.table import quantity

LAYERS = 6
FIRST = ("peak_depth", "deposit_depth", "peak_speed", "peak_pressure", "arrival_time")
LONGEST = 400  # cells: larger maps are thinned
SHADES = 254  # 0: no value
FULL = 0.995  # share of the values that the scale holds


def layers_of(run, parts, colormap="viridis"):
    """Add the maps of a `Run` that have values to `Parts`, as `layer.0` ...; -> what the page has to know of them.

    Their bytes are 0 without a value and 1 to 255 on the scale, row by row from the smallest y.
    """
    known, table = [], matplotlib.colormaps[colormap](np.linspace(0.0, 1.0, 256))[:, :3]
    for name in sorted(run.maps, key=lambda one: (FIRST.index(one) if one in FIRST else len(FIRST), one)):
        raster = run.maps[name]
        values = raster.values.astype(float)
        some = np.isfinite(values) & ((values > 0.0) | (name == "arrival_time"))
        if not some.any() or len(known) == LAYERS:
            continue
        rows, columns = (slice(line[0], line[-1] + 1) for line in (np.flatnonzero(some.any(axis=k)) for k in (1, 0)))
        every = max(1, -(-max(rows.stop - rows.start, columns.stop - columns.start) // LONGEST))
        rows, columns = slice(rows.start, rows.stop, every), slice(columns.start, columns.stop, every)
        values, some = values[rows, columns], some[rows, columns]
        if not some.any():
            continue
        low, high = 0.0, float(np.quantile(values[some], FULL)) or 1.0
        shares = np.clip((np.where(some, values, low) - low) / (high - low), 0.0, 1.0)
        parts.add(f"layer.{len(known)}", np.where(some, 1 + np.round(SHADES * shares), 0).astype(np.uint8))
        words = quantity(name)
        units = f" [{raster.units}]" if raster.units not in ("", "1") else ""
        half = 0.5 * raster.cell
        x0, y0 = raster.x0 + columns.start * raster.cell - half, raster.y0 + rows.start * raster.cell - half
        known.append({"title": f"{words.label}{units}", "low": low, "high": high, "names": [],
                      "table": np.round(255 * table).astype(int).ravel().tolist(), "rows": values.shape[0],
                      "columns": values.shape[1], "x0": x0, "y0": y0,
                      "x1": x0 + values.shape[1] * every * raster.cell,
                      "y1": y0 + values.shape[0] * every * raster.cell})
    return known
