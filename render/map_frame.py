"""What all maps have in common: shaded ground, frame, length bar, north, margin; lines around cells."""

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from snowmpm.annotations import Floats
from snowmpm.io import Run
from snowmpm.io.ground_maps import Map
from snowmpm.io.parameters import parameters
from snowmpm.io.projection import projection_name
from snowmpm.io.published import statement
from snowmpm.io.status import status_of
from snowmpm.render import light
from snowmpm.render.credit import attribution
from snowmpm.render.overlay import ticks
from snowmpm.render.relief import heights_within, map_shade

LINE = "#e0201b"
"""Colour of the run-out line, and of what is not final."""


def figure_size(lower: Floats, upper: Floats) -> tuple[float, float]:
    """Inches of a map between plan corners (2,): 8 along the longer side of the map, and room for labels."""
    width, height = (upper - lower) / np.max(upper - lower) * 8.0
    return max(width, 3.0) + 2.2, max(height, 3.0) + 1.3


def draw_terrain(axes: Axes, run: Run, lower: Floats, upper: Floats) -> None:
    """Draw the shaded ground of a `Run` and its contours between plan corners (2,) [m], relative to its origin."""
    found = heights_within(run.terrain, lower, upper)
    if found is None:
        return
    heights, cell = found
    rows, columns = heights.shape
    east, north = run.origin[0] + float(lower[0]), run.origin[1] + float(lower[1])
    half = 0.5 * cell
    extent = (east - half, east + columns * cell - half, north - half, north + rows * cell - half)
    # Grey, so that every hue on the map belongs to the raster.
    shade = map_shade(heights, cell)
    opaque = np.isfinite(shade)
    picture = light.encode(np.repeat(np.nan_to_num(shade)[..., None], 3, axis=-1))
    picture = np.dstack([picture, np.where(opaque, np.uint8(255), np.uint8(0))])
    axes.imshow(picture, extent=extent, origin="lower", interpolation="bilinear")
    x, y = east + cell * np.arange(columns), north + cell * np.arange(rows)
    heights = heights + run.origin[2]
    levels = ticks(float(np.nanmin(heights)), float(np.nanmax(heights)))
    fine = np.linspace(levels[0], levels[-1], 5 * (len(levels) - 1) + 1) if len(levels) > 1 else levels
    axes.contour(x, y, heights, levels=fine, colors="0.15", linewidths=0.3, alpha=0.45)
    labelled = axes.contour(x, y, heights, levels=levels, colors="0.1", linewidths=0.7, alpha=0.6)
    axes.clabel(labelled, fmt="%g m", fontsize=7)


def draw_edges(axes: Axes, run: Run, raster: Map, inside: NDArray[np.bool_], *, color: Any, lw: float,
               zorder: float) -> None:
    """Draw the line around the cells of a map of a `Run` where `inside` (rows, columns) is true, along their edges."""
    # Ten values a cell, so that the line follows the edges
    there = np.kron(np.pad(inside.astype(float), 1), np.ones((10, 10)))
    x, y = (run.origin[axis] + low + raster.cell * (0.1 * np.arange(n) - 1.45)
            for axis, low, n in ((0, raster.x0, there.shape[1]), (1, raster.y0, there.shape[0])))
    axes.contour(x, y, there, levels=[0.5], colors=[color], linewidths=lw, zorder=zorder)


def draw_frame(axes: Axes, run: Run, title: str, lower: Floats, upper: Floats) -> None:
    """Title, axes in map coordinates, length bar and north of a map between plan corners (2,) [m]."""
    axes.set_xlim(run.origin[0] + lower[0], run.origin[0] + upper[0])
    axes.set_ylim(run.origin[1] + lower[1], run.origin[1] + upper[1])
    plain = FuncFormatter(lambda value, _: f"{value:,.0f}".replace(",", " "))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(plain)
        axis.set_major_locator(MaxNLocator(5, integer=True))
    axes.tick_params(labelsize=8)
    axes.tick_params(axis="y", labelrotation=90)
    axes.set_xlabel("east [m]")
    axes.set_ylabel("north [m]")
    axes.set_title(title.replace("_", " "))
    _draw_length(axes, upper - lower)
    _draw_north(axes)


def draw_margin(figure, axes, run):
    """Below the map: projection, what the run was computed with, credits; in the map: why it is not final."""
    status, width = status_of(run), max(40, round(12.5 * figure.get_size_inches()[0]))
    projection = projection_name(run.provenance.get("crs")) or "no projection known: coordinates of the scene"
    facts = ", ".join(text if name in ("method", "version") else f"{name} {text}"
                      for name, text in parameters(run).items() if name != "scene")
    lines = [f"{projection}; {facts}.", statement(run), attribution(run.provenance)]
    if status.final:
        lines[0] += f" {status.text.capitalize()}."
    else:
        box = {"facecolor": "white", "alpha": 0.9, "edgecolor": LINE, "boxstyle": "round,pad=0.4"}
        axes.text(0.5, 0.985, textwrap.fill(status.text, max(30, round(0.62 * width))), transform=axes.transAxes,
                  ha="center", va="top", fontsize=8.5, color=LINE, fontweight="bold", bbox=box, zorder=8)
    figure.supxlabel("\n".join(row for line in lines if line for row in textwrap.wrap(line, width)), fontsize=7,
                     color="0.3")


def _draw_north(axes):
    """An arrow to grid north in the lower right corner."""
    axes.annotate("N", xy=(0.955, 0.125), xytext=(0.955, 0.035), xycoords="axes fraction", ha="center", va="center",
                  fontsize=11, fontweight="bold", zorder=7,
                  arrowprops={"facecolor": "black", "edgecolor": "white", "width": 3, "headwidth": 10},
                  bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.5})


def _draw_length(axes, size):
    """A bar of a round length in the lower left corner."""
    length = ticks(0.0, 0.3 * float(size[0]))[1]
    left, bottom = axes.get_xlim()[0] + 0.05 * size[0], axes.get_ylim()[0] + 0.05 * size[1]
    for colour, width in (("white", 5), ("black", 2.5)):
        axes.plot([left, left + length], [bottom, bottom], color=colour, lw=width, solid_capstyle="butt", zorder=5)
    box = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.5}
    label = f"{length:g} m" if length < 1000 else f"{length / 1000:g} km"
    axes.text(left + 0.5 * length, bottom + 0.015 * size[1], label, ha="center", va="bottom", bbox=box, zorder=5)
