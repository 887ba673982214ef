"""Pressure over the face of an obstacle: peaks, a field, the profile over height, and in time."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.draft import write_table
from snowmpm.io import Run
from snowmpm.io.panels import HEAD, panel_rows, panels_of
from snowmpm.io.status import status_of
from snowmpm.render.figure import check_ending, plain, prefixed, save, titled

COLOURS = "YlOrRd"
NOT_FINAL = "#c1121f"
MOST = 12
"""Obstacles of a picture."""
LINES = {"peak": "#c1121f", "force": "#0072B2", "mean": "#000000"}


def render_panels(run_path: PathLike | Run, output: PathLike, *, time: float | None = None, dpi: float = 130
                  ) -> list[Path]:
    """Draw the pressure panels of a run (`snowmpm.io.panels`) to a PNG, PDF or SVG, a row of pictures an obstacle;
    beside it a table of the same name, .csv: place, peak and impulse of each panel.

    From the left: largest pressure of each panel (3-D), the field at `time` [s], by default at the greatest force, the
    profile over height, and mean pressure over the width, in time. Returns both paths. Raises InputError for another
    ending, a run without panels, or a time outside the record.
    """
    check_ending(output)
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    found = panels_of(run)
    shown = sorted(sorted(found, key=lambda name: -found[name].peak.max())[:MOST], key=list(found).index)
    left_out = len(found) - len(shown)
    found = {name: found[name] for name in shown}
    plan = run.dimension == 3
    figure = Figure(figsize=(17.5 if plan else 9.5, 3.9 * len(found) + 0.5), dpi=dpi, layout="constrained")
    status = status_of(run)
    title = f"{run.name.replace('_', ' ')}: pressure over the face"
    title += f"; the {MOST} with the largest pressures, {left_out} others are in the table" if left_out else ""
    figure.suptitle(title if status.final else f"{title} (NOT FINAL)", fontsize=13, fontweight="bold",
                    color="#11161c" if status.final else NOT_FINAL)
    cells = figure.subplots(len(found), 4 if plan else 2, squeeze=False)
    for row, one in zip(cells, found.values(), strict=True):
        scale, unit = prefixed(one.peak)
        chosen = one.row_at(time)
        if plan:
            _field(figure, row[0], one, one.peak / scale, f"{one.name}: largest pressure", unit, one.peak.max() / scale)
            _field(figure, row[1], one, one.pressure[chosen] / scale, f"at {one.time[chosen]:.3g} s", unit,
                   one.peak.max() / scale)
        _profile(row[-2], one, chosen, scale, unit)
        _in_time(figure, row[-1], one, chosen, scale, unit)
    path = save(figure, output, dpi)
    return [path, write_table(path.with_suffix(".csv"), list(HEAD), panel_rows(run))]


def _field(figure, axes, one, values, title, unit, most):
    across, up = ((np.arange(values.shape[1 - k] + 1)) * one.edges[k] for k in (0, 1))
    drawn = axes.pcolormesh(across, up, values, cmap=COLOURS, vmin=0.0, vmax=most or 1.0, rasterized=True)
    axes.invert_xaxis()  # across goes to the left
    axes.set_aspect("equal")
    titled(axes, title, "from the right end, as the flow sees it  [m]", "height on the face  [m]")
    figure.colorbar(drawn, ax=axes, label=f"[{unit}]", location="top", shrink=0.8)


def _profile(axes, one, chosen, scale, unit):
    plain(axes)
    height = one.middles(1)
    over_time = np.average(one.pressure, axis=0, weights=one.spans).mean(axis=1)
    axes.plot(one.peak.max(axis=1) / scale, height, color=LINES["peak"], lw=1.4, label="largest of the row")
    axes.plot(one.pressure[chosen].mean(axis=1) / scale, height, color=LINES["force"], lw=1.8,
              label=f"mean of the row, {one.time[chosen]:.3g} s")
    axes.plot(over_time / scale, height, color=LINES["mean"], lw=1.4, label="mean of row and time")
    axes.set_ylim(0.0, one.edges[1] * len(height))
    axes.legend(fontsize=8, edgecolor="none")
    titled(axes, f"{one.name}: means over {one.spans.mean():.2g} s", f"pressure  [{unit}]", "height on the face  [m]")


def _in_time(figure, axes, one, chosen, scale, unit):
    mean = one.pressure.mean(axis=2).T / scale
    up = np.arange(len(mean) + 1) * one.edges[1]
    drawn = axes.pcolormesh(np.concatenate([[0.0], one.time]), up, mean, cmap=COLOURS, vmin=0.0, rasterized=True)
    axes.axvline(one.time[chosen], color="0.3", lw=0.8, ls="--")
    titled(axes, "mean over the width, in time", "time  [s]", "height on the face  [m]")
    figure.colorbar(drawn, ax=axes, label=f"[{unit}]", location="top", shrink=0.8)
