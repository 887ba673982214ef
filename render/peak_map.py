"""Rasters of a run over the shaded terrain, in map coordinates: peak depth, speed and pressure, deposit, arrival; with
the release, obstacles and dams, the thalweg, the run-out line, and an observed outline."""

import textwrap
from collections.abc import Iterable
from pathlib import Path

import matplotlib.cm
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from matplotlib.transforms import Bbox, TransformedBbox
from PIL import Image

from snowmpm.annotations import Floats, Numbers, PathLike
from snowmpm.errors import InputError, shown_line
from snowmpm.io import Run
from snowmpm.io.built import dam_lines, footprints
from snowmpm.io.parameters import parameters
from snowmpm.io.projection import projection_name
from snowmpm.io.published import statement
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import Classes, classes_of
from snowmpm.quantities.table import quantity
from snowmpm.render import light
from snowmpm.render.credit import attribution
from snowmpm.render.figure import check_ending, framed, save, save_picture, take_literally
from snowmpm.render.overlay import ticks
from snowmpm.render.relief import heights_within, map_shade

SURROUNDINGS = 0.25  # of the raster's filled part, shown on each side of it
RELEASE, LINE, OBSERVED, BUILT, ASKED = "#101418", "#e0201b", "#19c5ff", "#8a8a8a", "#7d1c6d"
OPACITY = (0.3, 0.9)  # of pale cells, and of others
BEFORE_AFTER = ("release_depth", "deposit_depth")
GREYS = ("#f2f2f2", "#d0d0d0", "#a8a8a8", "#808080", "#585858", "#303030")
"""Of a raster that has no classes."""


def render_map(run_path: PathLike | Run, name: str, output: PathLike, *, observed: Iterable[Numbers] | None = None,
               dpi: float = 150) -> Path:
    """Draw the raster `name` of a run over its terrain as a PNG, PDF or SVG. Returns the path written.

    Axes are map coordinates [m], up is north. Values are shown in the classes that tables and QGIS styles use
    (`snowmpm.quantities.classes`); cells where the flow was thinner than the run's `flow_depth` are pale. Outline of
    the release, obstacles and dams by name, thalweg and run-out line, where the run has them; below: projection, what
    the run was computed with, and whether it is final (`snowmpm.io.status`). Credits in the provenance (a key
    `attribution` anywhere in it) too.
    observed: outline of an avalanche that was seen, rings (n, 2) in map coordinates [m], drawn beside the computed one.
    Raises InputError for an unknown raster, one without values, or another ending of `output`.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    return MapSheet(run, observed, dpi).render(name, output)


def render_before_after(run_path: PathLike | Run, output: PathLike, *, dpi: float = 150) -> Path:
    """Draw the depth of the snow at the start and at the end side by side, in the same classes, to a PNG; -> the path.
    Raises InputError for a run without these maps, or another ending."""
    return MapSheet(run_path if isinstance(run_path, Run) else Run(run_path), dpi=dpi).before_after(output)


def map_figure(run, name, *, observed=None, dpi=150):
    """The raster `name` of a `Run` as a Matplotlib figure; arguments and errors as of `render_map`."""
    return MapSheet(run, observed, dpi).figure(name)


class MapSheet:
    """Figure of the maps of a `Run`, which have ground, lines, frame and margin in common: these are drawn up once, and
    laid out once. Arguments and errors as of `render_map`."""

    def __init__(self, run, observed=None, dpi=150, places=()):
        """places: (name, corners (n, 2) in map coordinates [m]) of lines and points that are drawn with their names."""
        self._run, self._observed, self._dpi, self._places = run, observed, dpi, places
        self._figure, self._box, self._image, self._bar = None, None, None, None
        self._ground, self._canvas, self._around, self._used = [], None, None, None

    def render(self, name, output):
        """Write the map `name`; -> its path."""
        check_ending(output)
        figure = self.figure(name)
        if Path(output).suffix.lower() != ".png":
            return save(figure, output, self._dpi)
        return save_picture(self._picture(figure), output, self._dpi)

    def before_after(self, output):
        """Write the depths at the start and at the end side by side, in the same classes; -> its path."""
        if Path(output).suffix.lower() != ".png":
            raise InputError.at("output", str(output), "must end in .png")
        largest = max(float(np.nanmax(_known(self._run, name).values)) for name in BEFORE_AFTER)
        both = []
        for name in BEFORE_AFTER:
            figure, raster = self.figure(name, largest), self._run.maps[name]
            _head(self._bar, quantity(name).text(float(np.nanmax(raster.values))))
            both.append(self._picture(figure))
        sheet = Image.new("RGB", (sum(one.width for one in both), max(one.height for one in both)), "white")
        sheet.paste(both[0], (0, 0))
        sheet.paste(both[1], (both[0].width, 0))
        return save_picture(sheet, output, self._dpi)

    def _picture(self, figure):
        """The map as a picture: its raster between the ground and all else, which are the same on all maps."""
        axes = figure.axes[0]
        own = [self._image, self._bar, axes.title]
        axes.title.set_parse_math(False)
        if self._around is None:
            take_literally(figure)
            self._canvas = FigureCanvasAgg(figure)
            self._canvas.draw()
            figure.set_layout_engine("none")
            renderer = self._canvas.get_renderer()
            self._used = figure.get_tightbbox(renderer)
            rest = [one for one in _parts(figure) if one not in (*own, *self._ground, figure.patch, axes.patch)]
            self._around = [self._layer(shown) for shown in ([figure.patch, axes.patch, *self._ground], rest)]
        inches = figure.dpi_scale_trans.inverted()
        used = Bbox.union([self._used, *(TransformedBbox(one.get_tightbbox(self._canvas.get_renderer()), inches)
                                         for one in own[1:])])
        below, above = self._around
        picture = Image.alpha_composite(Image.alpha_composite(below, self._layer(own)), above)
        return framed(picture.convert("RGB"), used, self._dpi)

    def _layer(self, shown):
        """What some parts of the figure draw, on nothing."""
        parts = _parts(self._figure)
        visible = [part.get_visible() for part in parts]
        for part, was in zip(parts, visible, strict=True):
            part.set_visible(was and part in shown)
        self._canvas.draw()
        for part, was in zip(parts, visible, strict=True):
            part.set_visible(was)
        return Image.fromarray(np.array(self._canvas.buffer_rgba()))

    def figure(self, name, largest=None):
        """The figure with the map `name`; largest: as of `draw_raster`."""
        raster = _known(self._run, name)
        box = np.array(map_box(self._run, name, self._observed))
        if self._box is None or not np.array_equal(box, self._box):
            self._begin(*box)
        elif self._image:
            self._image.remove()
            self._bar.clear()
        axes = self._figure.axes[0]
        self._image, self._bar = draw_raster(self._figure, axes, self._run, raster, name, _thin(self._run, raster),
                                             largest, self._bar)
        title = f"{self._run.title}: {quantity(name).label}".replace("_", " ")
        axes.set_title(title, y=1.0)  # not where the other parts leave room: they are not drawn with it
        return self._figure

    def _begin(self, lower, upper):
        run = self._run
        self._box, self._image, self._bar, self._around = np.array([lower, upper]), None, None, None
        self._figure = Figure(figsize=figure_size(lower, upper), dpi=self._dpi, layout="constrained")
        self._figure.get_layout_engine().set(rect=(0.0, 0.0, 0.95, 1.0))  # room for the heading of the colour bar
        axes = self._figure.add_subplot(aspect="equal")
        before = axes.get_children()
        if run.terrain is not None and run.terrain.facets.shape[1] == 3:
            draw_terrain(axes, run, lower, upper)
        self._ground = [one for one in axes.get_children() if one not in before]
        draw_built(axes, run)
        _draw_places(axes, self._places)
        _draw_lines(axes, run, self._observed)
        draw_frame(axes, run, run.title, lower, upper)
        draw_margin(self._figure, axes, run)


def _parts(figure):
    """All that a figure of a map draws: parts of the map, and all else."""
    return [*figure.axes[0].get_children(), *(one for one in figure.get_children() if one is not figure.axes[0])]


def _known(run, name):
    """A map of a `Run` that can be drawn. Raises InputError for another."""
    if name not in run.maps:
        raise InputError.not_in("map", name, run.maps or ["(the run has none)"], file=run.path)
    raster = run.maps[name]
    if not (np.isfinite(raster.values) & ((raster.values > 0.0) | (name == "arrival_time"))).any():
        raise InputError(f"{run.path}: map {name} has no values to draw")
    return raster


def map_box(run, name="peak_depth", observed=None):
    """Plan corners (2,) [m] of a map of a `Run`: all its maps show the same ground, and the observed outline."""
    raster = _known(run, name)
    filled = np.argwhere(np.isfinite(raster.values) & ((raster.values > 0.0) | (name == "arrival_time")))
    whole = run.maps.get("peak_depth", raster)
    if whole.values.shape == raster.values.shape and (whole.values > 0.0).any():
        filled = np.argwhere(whole.values > 0.0)
    lower, upper = _box(raster, filled, run.terrain)
    for ring in observed or ():
        plan = np.asarray(ring, float) - run.origin[:2]
        lower, upper = np.minimum(lower, plan.min(axis=0)), np.maximum(upper, plan.max(axis=0))
    return lower, upper


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


def _extent(run, raster):
    """Map coordinates of the raster's sides: west, east, south, north [m]."""
    rows, columns = raster.values.shape
    east, north = run.origin[0] + raster.x0, run.origin[1] + raster.y0
    half = 0.5 * raster.cell
    return [east - half, east + columns * raster.cell - half, north - half, north + rows * raster.cell - half]


def draw_raster(figure, axes, run, raster, name, pale, largest=None, place=None):
    """Draw a raster in map coordinates, in its classes, with its colour bar; -> the image and the axes of the bar.

    pale (rows, columns): cells drawn faintly; largest: value that the classes hold, by default of the raster; place:
    axes for the colour bar, new ones where there are none.
    """
    values = shown_values(raster.values, name)
    largest = float(np.nanmax(values)) if largest is None else largest
    classes = classes_of(name, largest) or Classes(tuple(ticks(0.0, largest)[1:6]), GREYS, unit=raster.units)
    used = min(len(classes.limits), int(np.searchsorted(classes.limits, largest, side="right")))
    limits = classes.limits[: max(used, 1)]
    bounds = [0.0, *limits, max(largest, limits[-1] * 1.001) * 1.001]
    colours = ListedColormap(list(classes.colours[: len(limits) + 1]))  # Matplotlib 3.8: a tuple of two is a colour
    norm = BoundaryNorm(bounds, colours.N)
    image = axes.imshow(values, extent=_extent(run, raster), origin="lower", interpolation="nearest", zorder=3,
                        cmap=colours, norm=norm, alpha=np.where(pale, *OPACITY))
    drawn_bar = matplotlib.cm.ScalarMappable(norm, colours)  # in full colours
    where = {"cax": place} if place else {"ax": axes, "shrink": 0.75, "pad": 0.02}
    bar = figure.colorbar(drawn_bar, **where, spacing="uniform", ticks=bounds[:-1])
    bar.ax.set_yticklabels([f"{bound / classes.scale:g}" for bound in bounds[:-1]])
    bar.set_label(f"{quantity(name).label}  [{classes.unit}]")
    _head(bar.ax, quantity(name, raster.units).text(largest))
    return image, bar.ax


def _head(bar, text):
    """Heading of a colour bar."""
    bar.set_title(f"max {text}", fontsize=9, loc="left")


def shown_values(values, name):
    """The values of a raster that are drawn, NaN elsewhere."""
    return np.where(np.isfinite(values) & ((values > 0.0) | (name == "arrival_time")), values, np.nan)


def _thin(run, raster):
    """Which cells of the raster never were under a flow, only under scattered grains."""
    limit, depth = run.hazard.get("numbers", {}).get("flow_depth"), run.maps.get("peak_depth")
    if limit is None or depth is None or depth.values.shape != raster.values.shape:
        return np.zeros(raster.values.shape, bool)
    return ~(depth.values >= limit)


def draw_built(axes: Axes, run: Run) -> None:
    """Draw the obstacles and the dams of a `Run` in map coordinates, each with its name."""
    for name, footprint in footprints(run).items():
        for part in shapely.get_parts(footprint):
            axes.fill(*np.array(part.exterior.coords).T, facecolor=BUILT, edgecolor="white", lw=0.8, zorder=5)
        _name(axes, name, footprint.bounds[2:])
    for name, line in dam_lines(run).items():
        axes.plot(*line.T, color="white", lw=4.4, zorder=4, solid_capstyle="butt")
        axes.plot(*line.T, color=BUILT, lw=2.6, zorder=5, solid_capstyle="butt")
        _name(axes, name, line[-1])


def _draw_places(axes, places):
    """Draw lines and points that a user asked about, each with its name."""
    for name, corners in places:
        axes.plot(*corners.T, color="white", lw=3.4, zorder=5, marker="" if len(corners) > 1 else "o", ms=7)
        axes.plot(*corners.T, color=ASKED, lw=1.8, zorder=6, marker="" if len(corners) > 1 else "o", ms=5)
        _name(axes, name, corners[-1], ASKED)


def _name(axes, name, place, colour=BUILT):
    box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0}
    axes.annotate(shown_line(name, 40), place, (3.0, 3.0), textcoords="offset points", fontsize=7, color=colour,
                  bbox=box, zorder=6, clip_on=True, annotation_clip=True)


def _draw_lines(axes, run, observed):
    """Release, thalweg, run-out line and observed outline, each where there is one, and a legend."""
    release, profile, line = run.maps.get("release_depth"), run.hazard.get("profile"), run.hazard.get("runout_line")
    outlines = [ring for part in run.hazard.get("release") or () for ring in part]
    for k, ring in enumerate(outlines):
        axes.plot(*np.array(ring).T, color=RELEASE, lw=1.6, zorder=5, label="release" if k == 0 else None)
    if not outlines and release is not None and np.nanmax(release.values, initial=0.0) > 0.0:
        # Ten values a cell, so that the line follows the edges of the cells
        there = np.kron(np.pad((np.nan_to_num(release.values) > 0.0).astype(float), 1), np.ones((10, 10)))
        west, east, south, north = _extent(run, release)
        beyond = 0.95 * release.cell
        x = np.linspace(west - beyond, east + beyond, there.shape[1])
        y = np.linspace(south - beyond, north + beyond, there.shape[0])
        axes.contour(x, y, there, levels=[0.5], colors=[RELEASE], linewidths=1.6, zorder=5)
        axes.plot([], [], color=RELEASE, lw=1.6, label="release")
    if profile:
        axes.plot(profile["x"], profile["y"], color=RELEASE, lw=1.0, ls=(0, (5, 4)), zorder=5, label="thalweg")
    if line:
        (x0, y0), (x1, y1) = line
        axes.plot([x0, x1], [y0, y1], color=LINE, lw=2.6, zorder=6, label=runout_words(run))
    for k, ring in enumerate(observed or ()):
        closed = np.concatenate([ring, ring[:1]])
        axes.plot(*closed.T, color="white", lw=3.4, zorder=5)
        axes.plot(*closed.T, color=OBSERVED, lw=2.0, zorder=6, label="observed" if k == 0 else None)
    if axes.get_legend_handles_labels()[0]:
        # Above, in the middle, stands why a run is not final
        place = "best" if status_of(run).final else "lower center"
        axes.legend(loc=place, fontsize=8, framealpha=0.85, edgecolor="none").set_zorder(7)


def runout_words(run):
    """Run-out and travel angle of a `Run` in words, "so far" where they are not final."""
    numbers = run.hazard["numbers"]
    runout, angle = (quantity(name).text(numbers.get(name)) for name in ("runout", "travel_angle"))
    return f"run-out{status_of(run).so_far} {runout}, travel angle {angle}"


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
