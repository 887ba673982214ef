"""Rasters of a run over the shaded terrain, in map coordinates: peak depth, speed and pressure, deposit, arrival; with
the release, obstacles and dams, the thalweg, the run-out line, and an observed outline."""

from collections.abc import Iterable
from pathlib import Path

import matplotlib.cm
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox, TransformedBbox
from PIL import Image

from snowmpm.annotations import Numbers, PathLike
from snowmpm.errors import InputError, shown_line
from snowmpm.io import Run
from snowmpm.io.built import dam_lines, footprints
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import GREYS, Classes, classes_of
from snowmpm.quantities.table import quantity
from snowmpm.render.figure import check_ending, framed, save, save_picture, take_literally
from snowmpm.render.map_frame import LINE, draw_edges, draw_frame, draw_margin, draw_terrain, figure_size
from snowmpm.render.overlay import ticks

SURROUNDINGS = 0.25  # of the raster's filled part, shown on each side of it
RELEASE, OBSERVED, BUILT, ASKED = "#101418", "#19c5ff", "#8a8a8a", "#7d1c6d"
OPACITY = (0.3, 0.9)  # of pale cells, and of others
BEFORE_AFTER = ("release_depth", "deposit_depth")


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
        # Room for the heading of the colour bar; for the title, Matplotlib 3.11 leaves too little
        self._figure.get_layout_engine().set(rect=(0.0, 0.0, 0.95, 0.96))
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
        draw_edges(axes, run, release, np.nan_to_num(release.values) > 0.0, color=RELEASE, lw=1.6, zorder=5)
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
