"""Runs over each other: profiles, fronts, energies, stress along a line, and what is known of the scene."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from snowmpm.annotations import Numbers, PathLike
from snowmpm.render.figure import DASHES, INK, check_ending, plain, prefixed, save, titled
from snowmpm.render.history_plot import LEGEND, colour_of

PANEL = (5.6, 3.5)  # inches
ENERGIES = {"kinetic_energy": "kinetic", "potential_energy": "potential, lost", "plastic_work": "plastic work"}


@dataclass(frozen=True)
class ComparedRun:
    """One run as it is drawn. profile: (s, height) [m] at the end, first: the same at the start; line: {name: (place
    [m], stress [Pa])}; history: of the run file; measured: (x, y) of the curve beside the known one, or None."""

    label: str
    profile: tuple[Numbers, Numbers]
    first: tuple[Numbers, Numbers]
    line: Mapping[str, tuple[Numbers, Numbers]]
    history: Mapping[str, Numbers]
    measured: tuple[Numbers, Numbers] | None = None


@dataclass(frozen=True)
class Comparison:
    """What is drawn. along: label of the profiles' axis; line: where the stresses are; moment [s]: of profiles and
    stresses; width: per metre of width (2-D); known_profile: (label, s, height); curve: (x label, y label, x, y) of
    what is known beside `measured`; numbers: [(name, unit, low, high, [measured of each run])]."""

    title: str
    runs: list[ComparedRun]
    along: str
    line: str
    moment: float
    width: bool
    known_profile: tuple[str, Numbers, Numbers] | None = None
    curve: tuple[str, str, Numbers, Numbers] | None = None
    numbers: list[tuple[str, str, float, float, list[float]]] = field(default_factory=list)


def render_comparison(comparison: Comparison, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw a `Comparison` to a PNG, PDF or SVG. Returns the path written. Raises InputError for another ending."""
    check_ending(output)
    return save(comparison_figure(comparison, dpi), output, dpi)


def comparison_figure(comparison, dpi=130):
    """A `Comparison` as a Matplotlib figure: the profiles above, over its whole width; below what else there is."""
    fronts = all("front" in run.history for run in comparison.runs)  # saw tests and periodic domains have none
    panels = [*([_draw_fronts] if fronts else []), _draw_energies]
    if any(run.line for run in comparison.runs):
        panels.append(_draw_line)
    if comparison.curve:
        panels.append(_draw_curve)
    if _beside_a_scale(comparison):
        panels.append(_draw_numbers)
    columns = 3 if len(panels) in (3, 5, 6) else 2
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(PANEL[0] * columns, PANEL[1] * (rows + 1) + 0.6), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1, wspace=0.03, hspace=0.03)
    figure.suptitle(comparison.title, fontsize=13, fontweight="bold", color=INK)
    cells = figure.add_gridspec(rows + 1, columns)
    _draw_profiles(figure.add_subplot(cells[0, :]), comparison)
    for i, draw in enumerate(panels):
        draw(figure.add_subplot(cells[1 + i // columns, i % columns]), comparison)
    for axes in figure.axes:
        plain(axes)
    return figure


def _draw_profiles(axes, comparison):
    for i, run in enumerate(comparison.runs):
        if i == 0:
            axes.fill_between(*run.first, np.min(run.first[1]), color="0.94", lw=0)
            axes.plot(*run.first, color="0.7", lw=1.0, label="at the start")
        axes.plot(*run.profile, color=colour_of(i), lw=1.8, label=run.label)
    if comparison.known_profile:
        label, s, height = comparison.known_profile
        axes.plot(s, height, color=INK, lw=1.4, ls="--", label=label)
    for name, unit, low, high, _ in comparison.numbers:
        if name == "run-out" and unit == "m":
            axes.axvline(0.5 * (low + high), color=INK, lw=1.2, ls="--", label="run-out, measured in experiments")
    reach = max(np.ptp(run.profile[0]) for run in comparison.runs)
    rise = max(np.max(run.first[1]) - min(np.min(run.profile[1]), np.min(run.first[1])) for run in comparison.runs)
    if reach < 12.0 * max(rise, 1e-12) and rise < 1.2 * reach:
        axes.set_aspect("equal", adjustable="datalim")
    axes.legend(**LEGEND)
    titled(axes, f"surface at {comparison.moment:.4g} s", comparison.along, "height  [m]")


def _draw_fronts(axes, comparison):
    for i, run in enumerate(comparison.runs):
        axes.plot(run.history["time"], run.history["front"], color=colour_of(i), lw=1.8, label=run.label)
    axes.legend(**LEGEND)
    titled(axes, "front of 99.5 % of what moved", "time  [s]", "from the first centre  [m]")


def _draw_energies(axes, comparison):
    drawn = [(i, name, run.history["time"], _energy(run.history, name)) for i, run in enumerate(comparison.runs)
             for name in ENERGIES if name in run.history]
    scale, unit = prefixed(*(values for *_, values in drawn), unit="J")
    names = [name for name in ENERGIES if any(name == one for _, one, _, _ in drawn)]
    for i, name, time, values in drawn:
        axes.plot(time, values / scale, color=colour_of(i), lw=1.5, ls=DASHES[names.index(name)])
    styles = [Line2D([], [], color="0.35", ls=DASHES[k], label=ENERGIES[name]) for k, name in enumerate(names)]
    axes.legend(handles=styles, **LEGEND)
    titled(axes, "energy", "time  [s]", f"[{unit}{'/m' if comparison.width else ''}]")


def _energy(history, name):
    return history[name][0] - history[name] if name == "potential_energy" else history[name]


def _draw_line(axes, comparison):
    scale, unit = prefixed(*(stress for run in comparison.runs for _, stress in run.line.values()))
    names = list(dict.fromkeys(name for run in comparison.runs for name in run.line))
    upright = comparison.line.startswith("x")
    for i, run in enumerate(comparison.runs):
        for name, (place, stress) in run.line.items():
            pair = (stress / scale, place) if upright else (place, stress / scale)
            axes.plot(*pair, color=colour_of(i), lw=1.5, ls=DASHES[names.index(name)])
    styles = [Line2D([], [], color="0.35", ls=DASHES[k], label=name) for k, name in enumerate(names)]
    axes.legend(handles=styles, **LEGEND)
    stress_label, place_label = f"compressive stress  [{unit}]", "height  [m]" if upright else "x  [m]"
    labels = (stress_label, place_label) if upright else (place_label, stress_label)
    titled(axes, f"stress on {comparison.line} at {comparison.moment:.4g} s", *labels)


def _draw_curve(axes, comparison):
    x_label, y_label, x, y = comparison.curve
    closed = len(x) > 2 and x[0] == x[-1] and y[0] == y[-1]
    if closed:
        axes.fill(x, y, color="0.75", lw=0, label="what is known")
    else:
        axes.plot(x, y, color=INK, lw=1.4, ls="--", label="what is known", zorder=3)
    for i, run in enumerate(comparison.runs):
        if run.measured is not None:
            axes.plot(*run.measured, color=colour_of(i), lw=1.6, label=run.label)
    axes.legend(**LEGEND)
    titled(axes, "against what is known", x_label, y_label)


def _draw_numbers(axes, comparison):
    """Each number over what is known of it, and the band of that."""
    numbers = _beside_a_scale(comparison)
    for k, (_, _, low, high, measured) in enumerate(numbers):
        middle = 0.5 * (low + high)
        width = max((high - low) / abs(middle), 0.004)
        axes.barh(k, width, left=1.0 - 0.5 * width, height=0.7, color="0.8", lw=0)
        axes.plot([1.0, 1.0], [k - 0.35, k + 0.35], color=INK, lw=1.2)
        for i, value in enumerate(measured):
            axes.plot(value / middle, k + 0.5 * ((i + 0.5) / len(measured) - 0.5), "o", color=colour_of(i), ms=6)
    axes.set_yticks(range(len(numbers)), [name for name, *_ in numbers])
    axes.set_ylim(len(numbers) - 0.4, -0.6)
    axes.use_sticky_edges = False  # of the bars: a band that fills the panel has no end
    axes.margins(x=0.15)
    titled(axes, "numbers over what is known", "measured / known", "")


def _beside_a_scale(comparison):
    """Numbers whose known value is not about zero, so that a ratio means something."""
    return [one for one in comparison.numbers if one[2] * one[3] > 0.0]
