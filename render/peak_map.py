"""Rasters of a run over the shaded terrain, in map coordinates: peak depth, speed and pressure, deposit; with the
release, the thalweg and the run-out line."""

import matplotlib.cm
import numpy as np
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap, PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import light
from snowmpm.render.colour import SNOW_WHITE_LOW
from snowmpm.render.credit import attribution
from snowmpm.render.figure import check_ending, save
from snowmpm.render.overlay import ticks
from snowmpm.render.relief import build_relief

SURROUNDINGS = 0.25  # of the raster's filled part, shown on each side of it
NORTH_WEST = np.array([-0.58, 0.58, 0.58])
PRESSURES = (0.0, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # kPa, between the classes of hazard maps and two beyond
PRESSURE_COLOURS = ListedColormap(["#fdf6c9", "#fbd65b", "#f59a3c", "#dd4b31", "#b01e5c", "#6d1169", "#24083a"])
RELEASE, LINE = "#101418", "#c1121f"
DEPTH = LinearSegmentedColormap.from_list("depth", ["#d8ecf6", "#8cc4e2", "#3f8fc8", "#2457a4", "#1d2a6b", "#3c0a4a"])


def render_map(run_path, name, output, *, dpi=150):
    """Draw the raster `name` of a run over its terrain as a PNG, PDF or SVG. Returns the path written.

    Axes are map coordinates [m]. Pressures are shown in the classes of hazard maps; cells where the flow was thinner
    than the run's `flow_depth` are pale. Outline of the release, thalweg and run-out line, where the run has them.
    Credits in the provenance (a key `attribution` anywhere in it) are printed below.
    Raises InputError for an unknown raster, one without values, or another ending of `output`.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    if name not in run.maps:
        raise InputError.not_in("map", name, run.maps or ["(the run has none)"], file=run.path)
    check_ending(output)
    raster = run.maps[name]
    filled = np.argwhere(np.isfinite(raster.values) & (raster.values > 0.0))
    if not len(filled):
        raise InputError(f"{run.path}: map {name} has no values to draw")
    lower, upper = _box(raster, filled, run.terrain)
    figure = Figure(figsize=_figure_size(lower, upper), dpi=dpi, layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    if run.terrain is not None and run.terrain.facets.shape[1] == 3:
        _draw_terrain(axes, run, lower, upper)
    _draw_raster(figure, axes, run, raster, name)
    _draw_lines(axes, run)
    _draw_frame(figure, axes, run, name, lower, upper)
    return save(figure, output, dpi)


def _box(raster, filled, terrain):
    """Plan box of what the raster shows and its surroundings, no further than there is ground."""
    corner = np.array([raster.x0, raster.y0])
    low = corner + raster.cell * (filled.min(axis=0)[::-1] - 0.5)
    high = corner + raster.cell * (filled.max(axis=0)[::-1] + 0.5)
    margin = SURROUNDINGS * float(np.max(high - low))
    if terrain is None:
        return low - margin, high + margin
    ground = terrain.vertices[:, :2]
    return np.maximum(low - margin, np.minimum(low, ground.min(axis=0))), np.minimum(
        high + margin, np.maximum(high, ground.max(axis=0))
    )


def _figure_size(lower, upper):
    """Inches: 8 along the longer side of the map, and room for labels."""
    width, height = (upper - lower) / np.max(upper - lower) * 8.0
    return max(width, 3.0) + 2.2, max(height, 3.0) + 1.3


def _draw_terrain(axes, run, lower, upper):
    relief = build_relief(run.terrain, lower, upper)
    if relief is None:
        return
    rows, columns = relief.heights.shape
    east, north = run.origin[0] + relief.x0, run.origin[1] + relief.y0
    extent = [east - 0.5 * relief.cell, east + (columns - 0.5) * relief.cell]
    extent += [north - 0.5 * relief.cell, north + (rows - 0.5) * relief.cell]
    slope_north, slope_east = np.gradient(relief.heights, relief.cell)
    normal = np.stack([-slope_east, -slope_north, np.ones_like(slope_east)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    # Grey, so that every hue on the map belongs to the raster.
    shade = 0.85 * light.illuminate(normal.astype(np.float32), NORTH_WEST, softness=0.2).mean(axis=-1, keepdims=True)
    picture = light.encode(np.repeat(np.nan_to_num(shade), 3, axis=-1)).astype(float) / 255.0
    opaque = np.isfinite(normal).all(axis=-1)
    axes.imshow(np.dstack([picture, opaque]), extent=extent, origin="lower", interpolation="bilinear")
    x, y = east + relief.cell * np.arange(columns), north + relief.cell * np.arange(rows)
    heights = relief.heights + run.origin[2]
    levels = ticks(float(np.nanmin(heights)), float(np.nanmax(heights)))
    fine = np.linspace(levels[0], levels[-1], 5 * (len(levels) - 1) + 1) if len(levels) > 1 else levels
    axes.contour(x, y, heights, levels=fine, colors="0.15", linewidths=0.3, alpha=0.45)
    labelled = axes.contour(x, y, heights, levels=levels, colors="0.1", linewidths=0.7, alpha=0.6)
    axes.clabel(labelled, fmt="%g m", fontsize=7)


def _extent(run, raster):
    """Map coordinates of the raster's sides: west, east, south, north [m]."""
    rows, columns = raster.values.shape
    east, north = run.origin[0] + raster.x0, run.origin[1] + raster.y0
    half = 0.5 * raster.cell
    return [east - half, east + columns * raster.cell - half, north - half, north + rows * raster.cell - half]


def _draw_raster(figure, axes, run, raster, name):
    values = np.where(raster.values > 0.0, raster.values, np.nan)
    highest, units = float(np.nanmax(values)), raster.units
    options = {"extent": _extent(run, raster), "origin": "lower", "interpolation": "nearest", "zorder": 3}
    options["alpha"] = np.where(_thin(run, raster), 0.3, 0.9)
    if raster.units == "Pa":
        values, highest, units = values / 1e3, highest / 1e3, "kPa"
        options.update(cmap=PRESSURE_COLOURS, norm=BoundaryNorm(PRESSURES, PRESSURE_COLOURS.N, extend="max"))
    elif "speed" in name or "velocity" in name:
        options.update(cmap=SNOW_WHITE_LOW, vmin=0.0, vmax=highest)
    else:
        # By the root: a gully fills tens of metres deep in one cell, and most of a flow is a tenth of that
        options.update(cmap=DEPTH, norm=PowerNorm(0.5, vmin=0.0, vmax=highest))
    drawn = axes.imshow(values, **options)
    drawn_bar = matplotlib.cm.ScalarMappable(drawn.norm, drawn.cmap)  # in full colours
    bar = figure.colorbar(drawn_bar, ax=axes, shrink=0.75, pad=0.02)
    bar.set_label(f"{name.replace('_', ' ')} [{units}]")
    bar.ax.set_title(f"max {highest:.0f}" if highest >= 100.0 else f"max {highest:.3g}", fontsize=9)


def _thin(run, raster):
    """Which cells of the raster never were under a flow, only under scattered grains."""
    limit, depth = run.hazard.get("numbers", {}).get("flow_depth"), run.maps.get("peak_depth")
    if limit is None or depth is None or depth.values.shape != raster.values.shape:
        return np.zeros(raster.values.shape, bool)
    return ~(depth.values >= limit)


def _draw_lines(axes, run):
    """Release, thalweg and run-out line, each where the run has it, and a legend."""
    release, profile, line = run.maps.get("release_depth"), run.hazard.get("profile"), run.hazard.get("runout_line")
    if release is not None and np.nanmax(release.values, initial=0.0) > 0.0:
        there = (np.nan_to_num(release.values) > 0.0).astype(float)
        west, east, south, north = _extent(run, release)
        half = 0.5 * release.cell
        x = np.linspace(west + half, east - half, there.shape[1])
        y = np.linspace(south + half, north - half, there.shape[0])
        axes.contour(x, y, there, levels=[0.5], colors=[RELEASE], linewidths=1.6, zorder=5)
        axes.plot([], [], color=RELEASE, lw=1.6, label="release")
    if profile:
        axes.plot(profile["x"], profile["y"], color=RELEASE, lw=1.0, ls=(0, (5, 4)), zorder=5, label="thalweg")
    if line:
        (x0, y0), (x1, y1) = line
        numbers = run.hazard["numbers"]
        label = f"run-out {numbers['runout']:.0f} m, travel angle {numbers['travel_angle']:.1f}°"
        axes.plot([x0, x1], [y0, y1], color=LINE, lw=2.6, zorder=6, label=label)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize=8, framealpha=0.85, edgecolor="none").set_zorder(7)


def _draw_frame(figure, axes, run, name, lower, upper):
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
    axes.set_title(f"{run.name}: {name}".replace("_", " "))
    _draw_length(axes, upper - lower)
    credits = attribution(run.provenance)
    if credits:
        figure.supxlabel(credits, fontsize=7, color="0.3")


def _draw_length(axes, size):
    """A bar of a round length in the lower left corner."""
    length = ticks(0.0, 0.3 * float(size[0]))[1]
    left, bottom = axes.get_xlim()[0] + 0.05 * size[0], axes.get_ylim()[0] + 0.05 * size[1]
    for colour, width in (("white", 5), ("black", 2.5)):
        axes.plot([left, left + length], [bottom, bottom], color=colour, lw=width, solid_capstyle="butt", zorder=5)
    box = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.5}
    label = f"{length:g} m" if length < 1000 else f"{length / 1000:g} km"
    axes.text(left + 0.5 * length, bottom + 0.015 * size[1], label, ha="center", va="bottom", bbox=box, zorder=5)
