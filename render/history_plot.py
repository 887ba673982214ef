"""The history of a run as a plot: front, speed, energies, time step and what limits it, loads and pressure on
obstacles."""

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.impact import impacts
from snowmpm.io.status import cautions, thalweg_doubts
from snowmpm.render.figure import check_ending, plain, prefixed, save

COLOURS = ("#0072B2", "#E69F00", "#000000", "#CC79A7", "#009E73", "#56B4E9", "#D55E00", "#8a949e", "#7d1c6d",
           "#8a8f2d")
FAINT = 0.35  # opacity of the fine record behind the means between frames
LEGEND = {"fontsize": 8, "edgecolor": "none", "framealpha": 0.75, "borderpad": 0.2}
PANEL = (5.4, 3.3)  # inches

ENERGIES = {
    "kinetic_energy": "kinetic", "elastic_energy": "elastic", "potential_energy": "potential, lost",
    "plastic_work": "plastic work", "contact_work": "taken by contact", "energy_remainder": "numerical remainder",
    "removed_energy": "left with snow", "affine_energy": "kinetic, affine", "damping_work": "taken by damping",
    "force_work": "given by forces", "handover_energy": "lost in handing over",
}
"""All but the work of forces, which is on the other side, add up to the energy of the start."""
RARE = ("removed_energy", "affine_energy", "damping_work", "force_work", "handover_energy")
"""Drawn where they are not zero all along."""
CAUSES = "steps_"


def render_history(run_path: PathLike | Run, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw the history of a run (a folder, a file or a `snowmpm.io.Run`) to a PNG, PDF or SVG.

    Returns the path written. Raises InputError for another ending, or a run without two rows of history.
    """
    check_ending(output)
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    return save(history_figure(run, dpi), output, dpi)


def history_figure(run, dpi=130):
    """The history of a run as a Matplotlib figure; a quantity that it does not hold has no panel."""
    history = run.history
    panels = [
        (_draw_way, history.keys() & {"front", "front_distance"}),
        (_draw_speed, history.keys() & {"max_speed"}),
        (_draw_energies, history.keys() & ENERGIES.keys()),
        (_draw_steps, history.keys() & {"steps", "dt"}),
    ]
    drawn = [draw for draw, there in panels if there]
    pressed = {name: one for name, one in impacts(run).items() if "impact_peak_pressure" in one.numbers}
    if pressed:
        drawn.append(_pressure_panel(pressed))
    for name, obstacle in run.obstacles.items():
        if len(obstacle.time):
            drawn += [_force_panel(name, obstacle), _moment_panel(name, obstacle)]
    if len(history["time"]) < 2 or not drawn:
        raise InputError(f"{run.path}: no history to plot yet")
    rows = -(-len(drawn) // 2)
    columns = min(len(drawn), 2)
    figure = Figure(figsize=(PANEL[0] * columns, PANEL[1] * rows + 0.5), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1, wspace=0.03, hspace=0.03)
    title = run.name.replace("_", " ")
    figure.suptitle(title, fontsize=13, fontweight="bold", color="#11161c")
    warned, doubts = cautions(run), thalweg_doubts(run.hazard.get("numbers", {}))
    if warned:
        said = ("" if set(warned) <= set(doubts) else "NOT FINAL: ") + " ".join(warned)
        figure.supxlabel(textwrap.fill(said, 62 * min(len(drawn), 2)), fontsize=9, color="#c1121f", fontweight="bold")
    cells = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for axes, draw in zip(cells, drawn, strict=False):
        plain(axes)
        draw(axes, run)
        axes.set_xlabel("time  [s]")
        axes.tick_params(labelbottom=True)
    for axes in cells[len(drawn) :]:
        axes.set_visible(False)
    return figure


def colour_of(i: int) -> str:
    """Colour of the i-th of several runs."""
    return COLOURS[i % len(COLOURS)]


def _named(axes, title, label):
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_ylabel(label)


def _legend(axes):
    if len(axes.get_legend_handles_labels()[0]) > 1:
        axes.legend(**LEGEND)


def _draw_way(axes, run):
    for name, label, colour in (("front", "from the first centre of mass", COLOURS[0]),
                                ("front_distance", "from the top of what moved", COLOURS[1])):
        if name in run.history:
            axes.plot(run.history["time"], run.history[name], color=colour, lw=1.8, label=label)
    _legend(axes)
    _named(axes, "front", "along the slope, in plan  [m]")


def _draw_speed(axes, run):
    axes.plot(run.history["time"], run.history["max_speed"], color=COLOURS[0], lw=1.8)
    axes.set_ylim(bottom=0.0)
    _named(axes, "speed of the fastest particle", "[m/s]")


def _draw_energies(axes, run):
    """Where the energy of the start went. The potential energy has no zero: what is drawn is how much of it is gone."""
    there = {name: run.history[name] for name in ENERGIES if name in run.history
             and (name not in RARE or np.nan_to_num(run.history[name]).any())}
    if "potential_energy" in there:
        there["potential_energy"] = there["potential_energy"][0] - there["potential_energy"]
    scale, unit = prefixed(*there.values(), unit="J")
    for (name, values), colour in zip(there.items(), COLOURS, strict=False):
        axes.plot(run.history["time"], values / scale, color=colour, lw=1.6, label=ENERGIES[name])
    _legend(axes)
    _named(axes, "energy", f"[{unit}{_width(run)}]")


def _draw_steps(axes, run):
    """Mean step between two rows, in the colour of what limited most of the steps."""
    history = run.history
    axes.set_yscale("log")
    _named(axes, "time step and what limits it", "[s]")
    if "steps" not in history:
        axes.plot(history["time"], history["dt"], color=COLOURS[0], lw=1.6)
        return
    time, steps = history["time"], np.diff(history["steps"])
    with np.errstate(divide="ignore", invalid="ignore"):
        dt = np.where(steps > 0.0, np.diff(time) / steps, np.nan)
    counts = {name: np.diff(np.nan_to_num(history[name])) for name in history if name.startswith(CAUSES)}
    if not counts:
        axes.stairs(dt, time, baseline=None, color=COLOURS[0], lw=1.6)
        return
    if np.isnan(dt).all():
        return
    most = np.argmax(list(counts.values()), axis=0)
    for k, name in enumerate(counts):
        if (most == k).any():
            own, label = np.where(most == k, dt, np.nan), name.removeprefix(CAUSES)
            axes.stairs(own, time, baseline=None, color=COLOURS[k % len(COLOURS)], lw=2.2, label=label)
    axes.set_ylim(0.5 * np.nanmin(dt), 2.0 * np.nanmax(dt))
    axes.legend(**LEGEND)


def _force_panel(name, obstacle):
    def draw(axes, run):
        parts = [0, 2] if run.dimension == 2 else [0, 1, 2]
        scale, unit = prefixed(obstacle.force, unit="N")
        means = _between_frames(run, obstacle, obstacle.impulse)
        for colour, part in zip(COLOURS, parts, strict=False):
            fine, mean = obstacle.force[:, part] / scale, means[1][:, part] / scale
            _draw_load(axes, obstacle.time, fine, means[0], mean, colour, "xyz"[part])
        _legend(axes)
        _named(axes, f"force on {name}", f"[{unit}{_width(run)}]")

    return draw


def _pressure_panel(found):
    """Force over the wetted area of each obstacle over time, with its early peak and its steady part."""
    def draw(axes, run):
        peaks = {name: one.numbers["impact_peak_pressure"] for name, one in found.items()}
        scale, unit = prefixed(np.array([*peaks.values()]))
        for colour, (name, one) in zip(COLOURS, found.items(), strict=False):
            obstacle = run.obstacles[name]
            ends, force = _between_frames(run, obstacle, obstacle.impulse)
            wetted = one.wetted_at(0.5 * (ends[1:] + ends[:-1]))
            pressure = np.where(wetted > 0.0, force @ one.direction / np.where(wetted > 0.0, wetted, 1.0), 0.0)
            steady = one.numbers["impact_steady_pressure"]
            label = f"{name}: {peaks[name] / scale:.3g} at peak force, {steady / scale:.3g} {unit} steady"
            axes.stairs(pressure / scale, ends, baseline=None, color=colour, lw=1.6, label=label)
            axes.plot(one.numbers["impact_peak_time"], peaks[name] / scale, "o", color=colour, ms=4)
        axes.legend(**LEGEND)
        _named(axes, "pressure where snow touches the obstacle", f"[{unit}]")

    return draw


def _moment_panel(name, obstacle):
    def draw(axes, run):
        moment = obstacle.moment.reshape(len(obstacle.time), -1)
        scale, unit = prefixed(moment, unit="N m")
        gained = np.cumsum(moment * _spans(obstacle.time)[:, None], axis=0)
        means = _between_frames(run, obstacle, gained)
        for k, colour in zip(range(moment.shape[1]), COLOURS, strict=False):
            label = "xyz"[k] if moment.shape[1] == 3 else "from x to z"
            _draw_load(axes, obstacle.time, moment[:, k] / scale, means[0], means[1][:, k] / scale, colour, label)
        _legend(axes)
        _named(axes, f"moment on {name}, about its centre of rotation", f"[{unit}{_width(run)}]")

    return draw


def _draw_load(axes, time, fine, ends, mean, colour, label):
    axes.stairs(fine, np.concatenate([[time[0] - _spans(time)[0]], time]), baseline=None, color=colour, lw=0.8,
                alpha=FAINT)
    axes.stairs(mean, ends, baseline=None, color=colour, lw=1.8, label=label)


def _spans(time):
    """Length of the interval that ends at each row; the first begins with the run."""
    return np.diff(time, prepend=min(0.0, time[0]))


def _between_frames(run, obstacle, gained):
    """Ends (k + 1,) of the intervals between frames, and the mean rate (k, ...) of what was gained, known at rows."""
    ends = run.times[(run.times > 0.0) & (run.times <= obstacle.time[-1] * (1.0 + 1e-9))]
    ends = ends if len(ends) else obstacle.time[-1:]
    rows = np.clip(np.searchsorted(obstacle.time, ends * (1.0 - 1e-9)), 0, len(obstacle.time) - 1)
    ends, gained = np.concatenate([[0.0], ends]), np.concatenate([np.zeros((1, gained.shape[1])), gained[rows]])
    return ends, np.diff(gained, axis=0) / np.diff(ends)[:, None]


def _width(run):
    return "/m" if run.dimension == 2 else ""
