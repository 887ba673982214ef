"""Work-precision charts: error against cost, log-log, a panel a problem, with the Pareto front."""

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from snowmpm.render.figure import check_ending, save

INK, FRONT = "#11161c", "#f2c14e"
COLOURS = {"program": INK, "precision": "#8a949e", "basis": "#1d4f91", "gradient": "#6f9fd8",
           "transfer": "#d9642a", "particles": "#2f8f4e", "step": "#8c6bb1", "wall": "#00868b",
           "return map": "#b5446e", "dimension": "#7a5c2e", "method": "#c2185b"}
OTHERS = ("#0072B2", "#E69F00", "#CC79A7", "#009E73", "#56B4E9", "#D55E00", "#7a5c2e")
"""Of groups that have no colour of their own."""
MARKS = "os^Dv<>P"


@dataclass(frozen=True)
class Curve:
    """A line of a panel: name and group for the legend; x: costs or cells, y: errors, coarse to fine."""

    name: str
    group: str
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True)
class Panel:
    """front: (x, y) of the points that none beats, cheap to dear, or None; guide: slope of a dashed line through the
    middle of the first curve, with its name, or None; note: a line of small text."""

    title: str
    curves: tuple[Curve, ...]
    front: tuple[Sequence[float], Sequence[float]] | None = None
    guide: tuple[float, str] | None = None
    note: str = ""


def render_work_precision(panels, output, *, x_label, title, y_label="relative error", columns=3, size=None,
                          legend_columns=6, dpi=130):
    """Draw `Panel`s to a PNG, PDF or SVG. Returns the path written. Raises InputError for another ending."""
    check_ending(output)
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=size or (4.4 * columns, 3.5 * rows + 1.2), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.06, h_pad=0.08)
    figure.suptitle(title, fontsize=13, fontweight="bold", color=INK)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    styles = _styles(panels)
    for axes, panel in zip(grid, panels, strict=False):
        _draw(axes, panel, styles)
    for axes in grid[len(panels):]:
        axes.set_visible(False)
    for k, axes in enumerate(grid[: len(panels)]):
        if k + columns >= len(panels):
            axes.set_xlabel(x_label, fontsize=10)
        if k % columns == 0:
            axes.set_ylabel(y_label, fontsize=10)
    _legend(figure, panels, styles, legend_columns)
    return save(figure, output, dpi)


def _styles(panels):
    """Colour, mark and line of each name: the colour tells the group, the mark which of it."""
    members = {}
    for panel in panels:
        for curve in panel.curves:
            names = members.setdefault(curve.group, [])
            if curve.name not in names:
                names.append(curve.name)
    others = iter(OTHERS)
    colours = {group: COLOURS.get(group) or next(others) for group in members}
    return {name: {"color": colours[group], "marker": MARKS[k % len(MARKS)],
                   "linestyle": "-" if k == 0 else ("--", ":", "-.")[k % 3],
                   "linewidth": 2.2 if group == "program" else 1.1, "markersize": 5.0 if group == "program" else 3.8,
                   "zorder": 4 if group == "program" else 3}
            for group, names in members.items() for k, name in enumerate(names)}


def _draw(axes, panel, styles):
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.92", lw=0.7, which="major")
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=9, color="0.5")
    _few_numbers(axes.xaxis, [x for curve in panel.curves for x in curve.x])
    _few_numbers(axes.yaxis, [y for curve in panel.curves for y in curve.y])
    if panel.front is not None:
        axes.plot(*panel.front, color=FRONT, lw=7.0, alpha=0.75, solid_joinstyle="round", solid_capstyle="round",
                  zorder=1)
    for curve in panel.curves:
        axes.plot(curve.x, curve.y, **styles[curve.name])
    if panel.guide is not None:
        slope, _ = panel.guide
        curve = panel.curves[0]
        middle = len(curve.x) // 2
        x = [curve.x[0], curve.x[-1]]
        axes.plot(x, [curve.y[middle] * (value / curve.x[middle]) ** slope for value in x], color="0.35", lw=0.9,
                  ls=(0, (6, 4)), zorder=2)
    axes.set_title(panel.title, fontsize=10.5, loc="left", color=INK, pad=17 if panel.note else 6)
    axes.text(0.0, 1.02, panel.note, transform=axes.transAxes, ha="left", va="bottom", fontsize=7.8, color="0.35")


def _few_numbers(axis, values):
    """Powers of ten; 2 and 5 of each between them where there are few of those."""
    few = max(values) / min(values) < 30.0
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
    if few:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else f"{value:.0e}"))
    axis.set_minor_formatter(NullFormatter())


def _legend(figure, panels, styles, columns):
    handles = [figure.axes[0].plot([], [], label=name, **style)[0] for name, style in styles.items()]
    if any(panel.front is not None for panel in panels):
        handles += figure.axes[0].plot([], [], color=FRONT, lw=7.0, alpha=0.75, label="Pareto front")
    guides = {panel.guide[1] for panel in panels if panel.guide is not None}
    if guides:
        handles += figure.axes[0].plot([], [], color="0.35", lw=0.9, ls=(0, (6, 4)), label=", ".join(sorted(guides)))
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize=8.5)
