"""Maps of where schemes fail: a row a setting, a column a value, the colour how far beyond its limit the symptom is."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from snowmpm.render.figure import check_ending, save

INK, EDGE = "#11161c", "#11161c"
HOLDS_TO_FAILS = LinearSegmentedColormap.from_list(
    "holds_to_fails", ["#1d4f91", "#6f9fd8", "#dbe8f5", "#fbe3d1", "#d9642a", "#8c2308"])
DECADES = 2.0
"""Colours go from this many decades below the limit to as many above it."""


@dataclass(frozen=True)
class MapPanel:
    """One entry: symptoms (rows, columns) and their limit; borders: of each row, None for none."""

    title: str
    x_label: str
    values: tuple[Any, ...]
    settings: tuple[Any, ...]
    symptoms: np.ndarray
    limit: float
    borders: tuple[float | None, ...]
    note: str = ""


def render_atlas(panels, output, *, title, columns=2, dpi=120):
    """Draw `MapPanel`s to a PNG, PDF or SVG. Returns the path written. Raises InputError for another ending."""
    check_ending(output)
    columns = min(columns, len(panels))
    rows = -(-len(panels) // columns)
    heights = [max(len(panel.settings) for panel in panels[row * columns:(row + 1) * columns]) for row in range(rows)]
    figure = Figure(figsize=(7.6 * columns, sum(0.26 * n + 1.35 for n in heights) + 0.9), dpi=dpi,
                    layout="constrained")
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.1)
    figure.suptitle(title, fontsize=13, fontweight="bold", color=INK)
    grid = figure.subplots(rows, columns, squeeze=False, height_ratios=[n + 4 for n in heights]).ravel()
    norm = Normalize(-DECADES, DECADES)
    for axes, panel in zip(grid, panels, strict=False):
        _draw(axes, panel, norm)
    for axes in grid[len(panels):]:
        axes.set_visible(False)
    thin = max(0.03, 0.13 / figure.get_size_inches()[1])  # of a figure of one row: long enough for its labels
    bar = figure.colorbar(ScalarMappable(norm, HOLDS_TO_FAILS), ax=list(grid), location="bottom", fraction=thin,
                          aspect=50, shrink=0.6, pad=0.01)
    bar.set_ticks([-2, -1, 0, 1, 2], labels=["1/100 or less", "1/10", "limit", "10", "100 or more"])
    bar.set_label("symptom over its limit; black line: measured border", fontsize=9)
    return save(figure, output, dpi)


def _draw(axes, panel, norm):
    found = np.log10(np.maximum(panel.symptoms, 1e-300) / panel.limit)
    axes.imshow(np.clip(found, -DECADES, DECADES), cmap=HOLDS_TO_FAILS, norm=norm, aspect="auto",
                interpolation="nearest")
    places = np.arange(len(panel.values))
    for row, border in enumerate(panel.borders):
        if border is not None:
            x = np.interp(_scale(border, panel.values), _scale(np.array(panel.values), panel.values), places)
            axes.plot([x, x], [row - 0.46, row + 0.46], color=EDGE, lw=2.4, solid_capstyle="butt")
    axes.set_xticks(places, [f"{value:.3g}" for value in panel.values], fontsize=7.5,
                    rotation=45 if len(places) > 12 else 0)
    axes.set_yticks(np.arange(len(panel.settings)), panel.settings, fontsize=8)
    axes.set_xlabel(panel.x_label, fontsize=8.5)
    axes.set_title(panel.title, fontsize=10, loc="left", color=INK, fontweight="bold")
    axes.text(1.0, 1.01, panel.note, fontsize=7, ha="right", va="bottom", transform=axes.transAxes, color="#5a646e")
    axes.set_xticks(places[:-1] + 0.5, minor=True)
    axes.set_yticks(np.arange(len(panel.settings) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=0.8)
    axes.tick_params(which="both", length=0)


def _scale(value, values):
    """Along a map: logarithmic where its values are spread over more than two decades."""
    spread = values[0] > 0.0 and values[-1] > 100.0 * values[0]
    return np.log(value) if spread else value
