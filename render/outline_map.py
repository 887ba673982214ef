"""Affected areas of several runs on one map."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from snowmpm.annotations import Floats, PathLike
from snowmpm.io import Run
from snowmpm.io.projection import projection_name
from snowmpm.io.status import status_of
from snowmpm.render.figure import check_ending, save
from snowmpm.render.map_frame import LINE, draw_edges, draw_frame, draw_terrain, figure_size
from snowmpm.render.peak_map import RELEASE, draw_built, map_box

RAMP = colormaps["plasma"]
"""Of scenarios, which have an order."""
APART = [colormaps["tab10"](k) for k in range(10)]
"""Of ways to compute one avalanche."""


def render_outlines(runs: Sequence[tuple[str, Run]], output: PathLike, title: str, *,
                    observed: Sequence[Floats] | None = None, places: Sequence[tuple[str, Floats]] = (),
                    dpi: float = 150) -> Path:
    """Draw the affected area of each of (name, run) as a line over the terrain of the first, to a PNG, PDF or SVG; ->
    the path. The runs are of one terrain. observed: outlines (n, 2) [m] that were observed, drawn in black; None of
    scenarios, whose colours have an order. places: (words, lines or points (n, 2) [m]) beside them. Raises InputError
    for another ending."""
    check_ending(output)
    first = runs[0][1]
    boxes = [np.add(map_box(run), run.origin[:2]) for _, run in runs]
    lower = np.min([box[0] for box in boxes], axis=0) - first.origin[:2]
    upper = np.max([box[1] for box in boxes], axis=0) - first.origin[:2]
    figure = Figure(figsize=figure_size(lower, upper), dpi=dpi, layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    if first.terrain is not None and first.terrain.facets.shape[1] == 3:
        draw_terrain(axes, first, lower, upper)
    handles = []
    for k, (name, run) in enumerate(runs):
        colour = APART[k % len(APART)] if observed is not None else RAMP(0.05 + 0.85 * k / max(1, len(runs) - 1))
        raster, limit = run.maps["peak_depth"], run.hazard["numbers"]["flow_depth"]
        draw_edges(axes, run, raster, np.nan_to_num(raster.values) >= limit, color=colour, lw=1.8, zorder=4)
        handles.append(Line2D([], [], color=colour, lw=1.8, label=name))
        for part in run.hazard.get("release") or ():
            axes.plot(*np.array(part[0]).T, color=RELEASE, lw=1.2, zorder=5)
    for ring in observed or ():
        lines = axes.plot(*np.vstack([ring, ring[:1]]).T, color="black", lw=2.2, zorder=6, label="observed")
        handles = [lines[0], *(one for one in handles if one.get_label() != "observed")]
        lower = np.minimum(lower, ring.min(axis=0) - first.origin[:2])
        upper = np.maximum(upper, ring.max(axis=0) - first.origin[:2])
    for words, corners in places:
        style: dict[str, Any] = {"ls": ":", "lw": 1.2} if len(corners) > 1 else {
            "ls": "", "marker": "X", "ms": 8, "mec": "white"}
        line = axes.plot(*np.array(corners).T, color="black", zorder=6, label=words, **style)
        handles += line if words not in [one.get_label() for one in handles] else []
    draw_built(axes, first)
    axes.legend(handles=handles, loc="best", fontsize=8, framealpha=0.85, edgecolor="none").set_zorder(7)
    draw_frame(axes, first, f"{title}: affected area", lower, upper)
    width = max(40, round(12.5 * figure.get_size_inches()[0]))
    projection = projection_name(first.provenance.get("crs")) or "no projection known: coordinates of the scene"
    rows = textwrap.wrap(f"{projection}. Results of a model. No hazard assessment.", width)
    if moving := [name for name, run in runs if not status_of(run).final]:
        rows += textwrap.wrap(f"NOT FINAL: {', '.join(moving)}.", width)
    figure.supxlabel("\n".join(rows), fontsize=7, color=LINE if moving else "0.3")
    return save(figure, output, dpi)
