"""Rasters of shares, such as probabilities, over the shaded terrain of a run."""

import textwrap
from collections.abc import Iterable
from pathlib import Path

import matplotlib.cm
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from snowmpm.annotations import Floats, Numbers, PathLike
from snowmpm.io import Run
from snowmpm.io.projection import projection_name
from snowmpm.render.figure import check_ending, save
from snowmpm.render.map_frame import draw_frame, draw_terrain, figure_size
from snowmpm.render.peak_map import OBSERVED, RELEASE, draw_built

MARGIN = 0.12
"""Surroundings on each side, as a share of the larger side."""

SHARES = (0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0)
COLOURS = ("#ffffff", "#fff3b0", "#fdca5c", "#f3913a", "#d64e3a", "#a02058", "#56135f", "#12061f")
"""Of the classes between SHARES; the first, of less than one run in a hundred, is left out."""

AGREEING = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
AGREEMENT = ("#7b3294", "#b27cc0", "#dcc6e0", "#cfe6d0", "#7fbf86", "#1b7837")


def render_probability(run: Run, x: Floats, y: Floats, shares: Numbers, output: PathLike, *, title: str,
                       words: str = "", agreement: bool = False, observed: Iterable[Numbers] | None = None,
                       dpi: float = 150) -> Path:
    """Draw a raster of shares over the terrain of a run; -> the path written.

    x (columns,), y (rows,): middles of the cells [m]; shares (rows, columns), from 0 to 1; title, words: above, below;
    agreement: shares from 0.5 to 1 in other colours; observed: rings (n, 2) of an outline [m]. InputError for another
    ending of output.
    """
    check_ending(output)
    shown = shares < 1.0 if agreement else shares >= SHARES[1]
    cell = float(x[1] - x[0]) if len(x) > 1 else float(y[1] - y[0]) if len(y) > 1 else 1.0
    low, high = np.array([x[0], y[0]]) - 0.5 * cell, np.array([x[-1], y[-1]]) + 0.5 * cell
    margin = MARGIN * float((high - low).max())
    lower, upper = _within(run, low - margin - run.origin[:2], high + margin - run.origin[:2])
    figure = Figure(figsize=figure_size(lower, upper), dpi=dpi, layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    if run.terrain is not None and run.terrain.facets.shape[1] == 3:
        draw_terrain(axes, run, lower, upper)
    bounds, colours = (AGREEING, AGREEMENT) if agreement else (SHARES[1:], COLOURS[1:])
    norm, classes = BoundaryNorm(bounds, len(colours)), ListedColormap(colours)
    axes.imshow(np.where(shown, shares, np.nan), extent=(low[0], high[0], low[1], high[1]), origin="lower", zorder=3,
                interpolation="nearest", cmap=classes, norm=norm, alpha=0.85)
    bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, classes), ax=axes, shrink=0.75, pad=0.02, ticks=bounds,
                          spacing="uniform")
    bar.ax.set_yticklabels([f"{100.0 * bound:g} %" for bound in bounds])
    draw_built(axes, run)
    for part in run.hazard.get("release") or ():
        axes.plot(*np.array(part[0]).T, color=RELEASE, lw=1.6, zorder=5, label="release")
    for ring in observed or ():
        closed = np.concatenate([ring, ring[:1]])
        axes.plot(*closed.T, color="white", lw=3.4, zorder=5)
        axes.plot(*closed.T, color=OBSERVED, lw=2.0, zorder=6, label="observed")
    if axes.get_legend_handles_labels()[0]:
        named = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
        axes.legend(named.values(), named, loc="best", fontsize=8, framealpha=0.85, edgecolor="none").set_zorder(7)
    draw_frame(axes, run, title, lower, upper)
    projection = projection_name(run.provenance.get("crs")) or "no projection known: coordinates of the scene"
    width = max(40, round(12.5 * figure.get_size_inches()[0]))
    figure.supxlabel(textwrap.fill(f"{projection}; cells of {cell:g} m; {words}", width), fontsize=7, color="0.3")
    return save(figure, output, dpi)


def _within(run, low, high):
    """The box, no larger than the ground."""
    if run.terrain is None:
        return low, high
    ground = run.terrain.vertices[:, :2]
    return np.maximum(low, ground.min(axis=0)), np.minimum(high, ground.max(axis=0))
