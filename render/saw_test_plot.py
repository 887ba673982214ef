"""A propagation saw test as field studies show it: crack in space and time, its speed, the slab that bends and settles.

Space-time diagram and speed against crack length as from tracked markers (Bergfeld et al. 2021,
doi:10.5194/tc-15-3539-2021), settlement of points of the slab with time, deflection of the slab at several times;
beside it what theories say, and how the test was made.
"""

import textwrap
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.saw_theories import FLAT, THEORIES, compared
from snowmpm.io.saw_words import not_to_the_end, outcome, set_up, spread, unknown, why
from snowmpm.render.figure import INK, check_ending, plain, save, titled

COLOURS = ("#0072B2", "#E69F00", "#000000", "#CC79A7", "#009E73")
LEGEND = {"fontsize": 8, "edgecolor": "none", "framealpha": 0.8, "borderpad": 0.2}
SAW, TIP = "#11161c", "#d9642a"
SETTLING = "Blues"
USUAL = 90.0
"""Percentile of the speeds that must fit into their panel."""
POINTS = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the column, whose settlement is drawn over time


def render_saw_test(run_path: PathLike | Run, output: PathLike, *, dpi: float = 130,
                    theories: Mapping[str, float] | None = None) -> Path:
    """Draw the saw test of a run (a folder, a file or a `snowmpm.io.Run`) to a PNG, PDF or SVG.

    theories: {name: value} beside those that the run's summary holds (`saw_test.theories`).
    Returns the path written. Raises InputError for another ending, or a run without a saw test or without rows of it.
    """
    check_ending(output)
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    return save(saw_test_figure(run, dpi, theories), output, dpi)


def saw_test_figure(run, dpi=130, theories=None):
    """The saw test of a run as a Matplotlib figure."""
    test = run.saw_test
    if test is None:
        raise InputError(f"{run.path}: not a saw test")
    if len(test["time"]) < 3:
        raise InputError(f"{run.path}: no measurements to plot yet")
    figure = Figure(figsize=(17.5, 7.6), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1, wspace=0.03, hspace=0.03)
    about, found = test.about, run.summary.get("saw_test", {})
    found = {**found, "theory": {**about.get("theory", {}), **found.get("theory", {}), **(theories or {})}}
    words = "\n" + textwrap.fill(outcome(found, test).split("; ")[0], 160) if "crack_length" in found else ""
    title = run.name.replace("_", " ")
    unfinished = "" if run.complete else f"UNFINISHED, up to {test['time'][-1]:.3g} s: "
    figure.suptitle(f"{unfinished}{title}: slope {about['slope_angle']:g}°, slab {about['slab_thickness']:g} m,"
                    f" weak layer {1e3 * about['weak_layer_thickness']:g} mm{words}",
                    fontsize=12, fontweight="bold", color=INK)
    cells = figure.subplots(2, 4).ravel()
    panels = (_space_time, _speed, _energy, _lengths, _deflection, _settlement, _slip, _words)
    for axes, draw in zip(cells, panels, strict=True):
        plain(axes)
        draw(figure, axes, test, found)
    return figure


def _window(test):
    """First and last time worth showing [s]: from the cut to a while after the crack has come through."""
    time, tip = test["time"], test["tip"]
    moving = np.flatnonzero(np.diff(tip) > 0.0)
    if not len(moving):
        return time[0], time[-1]
    first, last = time[moving[0]], time[moving[-1]]
    return max(time[0], first - 0.1 * (last - first)), min(time[-1], last + 0.35 * (last - first))


def _space_time(figure, axes, test, found):
    x, time = test["x"], test["time"]
    speed = test["settling_speed"]
    limit = max(float(np.nanpercentile(speed, 99.5)), 1e-9)
    scale, unit = (1e-3, "mm/s") if limit < 1.0 else (1.0, "m/s")
    mesh = axes.pcolormesh(x, time, speed / scale, cmap=SETTLING, vmin=0.0, vmax=limit / scale, shading="nearest",
                           rasterized=True)
    figure.colorbar(mesh, ax=axes, label=f"settling speed of the slab  [{unit}]", pad=0.01)
    arrival = test["arrival"]
    axes.plot(x, arrival, ".", ms=2.2, color=TIP, label="weak layer broken")
    axes.plot(test["saw"], time, color=SAW, lw=1.4, label=f"saw, {test.about['saw_speed']:g} m/s")
    if found.get("critical_length"):
        length, near = found["critical_length"], found.get("critical_length_resolution") or 0.0
        axes.axvspan(length - near, length + near, color=TIP, lw=0, alpha=0.15)
        axes.axvline(length, color=TIP, lw=1.0, ls="--", label="critical length, ± a bin")
    if test.about["notch"] > 0.0:
        axes.axvspan(0.0, test.about["notch"], color="0.6", lw=0, alpha=0.5, label="notch")
    axes.set_xlim(0.0, test.about["length"])
    axes.set_ylim(*_window(test))
    axes.grid(False)
    axes.legend(loc="lower right", **LEGEND)
    titled(axes, "crack in space and time", "along the column  [m]", "time  [s]")


def _speed(figure, axes, test, found):
    D = test.about["slab_thickness"]
    x, arrival, first = test["x"], test["arrival"], found.get("critical_length") or 0.0
    own = np.isfinite(arrival) & (x > first)
    for window, style in ((0.5 * D, {"color": "0.7", "lw": 1.0, "label": "over half a slab thickness"}),
                          (2.0 * D, {"color": TIP, "lw": 2.0, "label": "over two"})):
        axes.plot(*local_speed(x[own], arrival[own], window), **style)
    if found.get("crack_speed"):
        v, near = found["crack_speed"], found.get("crack_speed_spread") or 0.0
        axes.axhspan(v - near, v + near, color=TIP, lw=0, alpha=0.15,
                     label=f"crack speed: {v:.0f}{spread(found, 'crack_speed', 0)} m/s")
    theory = {**{name: test.about[name] for name in ("shear_wave_speed", "plate_wave_speed")},
              **found.get("theory", {})}
    # Where two cracks meet, or one leaves at the free end, the last bins break almost at once: that is no speed
    top = 1.25 * max([1.0, *(float(np.percentile(line.get_ydata(), USUAL)) for line in axes.lines
                             if len(line.get_ydata()))])
    flat = abs(test.about["slope_angle"]) <= FLAT
    for name, label, style in (*([("collapse_wave_speed", "collapse wave (Heierli 2005)", "--")] if flat else []),
                               ("shear_wave_speed", "0.6 shear waves of the slab", ":"),
                               ("plate_wave_speed", "plate waves of the slab", "-.")):
        value = theory.get(name)
        value = value and value * (0.6 if name == "shear_wave_speed" else 1.0)
        if value and (value < top or name != "plate_wave_speed"):
            axes.axhline(value, color="0.35", lw=1.0, ls=style, label=f"{label}: {value:.0f} m/s")
            top = max(top, 1.15 * value)
    axes.set_ylim(0.0, 1.45 * top)  # room for the legend
    axes.set_xlim(0.0, test.about["length"])
    axes.legend(loc="upper left", ncols=2, **{**LEGEND, "fontsize": 7})
    titled(axes, "speed of the crack", "crack length  [m]", "[m/s]")


def local_speed(x, arrival, window):
    """Slope of x over the arrival in windows of that length [m]: middles and speeds."""
    if len(x) < 3:
        return np.zeros(0), np.zeros(0)
    n = max(1, round(window / max(float(np.median(np.diff(x))), 1e-9)))
    if len(x) <= n:
        return np.zeros(0), np.zeros(0)
    duration = arrival[n:] - arrival[:-n]
    good = duration > 0.0
    return 0.5 * (x[n:] + x[:-n])[good], ((x[n:] - x[:-n])[good] / duration[good])


def _energy(figure, axes, test, found):
    x, work = test["x"], test["work"][-1]
    own = np.isfinite(test["arrival"])
    axes.plot(x[own], work[own], color="0.7", lw=1.2, label="dissipated in the weak layer at the end")
    axes.plot(x, test["fracture_energy"], color=COLOURS[0], lw=1.8, label="until its strength was gone")
    value = found.get("theory", {}).get("fracture_energy")
    if value:
        axes.axhline(value, color="0.35", lw=1.0, ls="--", label=f"collapse of the whole layer: {value:.2f} J/m²")
    axes.set_xlim(0.0, test.about["length"])
    axes.set_ylim(bottom=0.0)
    axes.legend(**LEGEND)
    titled(axes, "energy that the crack takes", "along the column  [m]", "[J/m²]")


def _lengths(figure, axes, test, found):
    """The critical length, and what theories say of it."""
    length = found.get("critical_length")
    said = {one.label: found["theory"].get(one.predicted) for one in THEORIES if one.measured == "critical_length"}
    said = {label: value for label, value in said.items() if value}
    rows = {**({"measured": length} if length else {}), **said}
    for k, (label, value) in enumerate(rows.items()):
        colour = TIP if label == "measured" else "0.55"
        axes.barh(k, value, height=0.32, color=colour)
        axes.text(0.0, k - 0.26, label, fontsize=8, va="bottom")
        known = spread(found, "critical_length", 2) if label == "measured" else ""
        axes.text(value, k, f" {value:.2f}{known} m", fontsize=8, va="center")
    if length:
        axes.axvline(length, color=TIP, lw=1.0, ls="--")
    else:
        words = why(found, "critical_length") if "crack_length" in found else "known when the run has ended"
        axes.text(0.5, 0.05 if rows else 0.5, textwrap.fill(words, 48), fontsize=9, ha="center",
                  transform=axes.transAxes)
    axes.set_yticks([])
    axes.set_ylim(max(len(rows), 1) - 0.5, -0.7)
    axes.set_xlim(0.0, 1.25 * max([*rows.values(), 1e-3]))
    titled(axes, "critical length, and theories of it", "cut  [m]", "")


def _words(figure, axes, test, found):
    """How the test was made, the load beside Maxwell's, and why measured and predicted numbers lie far apart."""
    about, rows = test.about, set_up(test.about)
    maxwell = found.get("theory", {}).get("maxwell_load")
    if maxwell:
        above = "above: a collapse can run" if about["normal_stress"] > maxwell else "below: no collapse runs"
        rows["Maxwell's load"] = f"{maxwell:.0f} Pa normal; the load lies {above} on the flat"
    lines = [f"{what}: {words}" for what, words in rows.items()]
    lines += [line for line in [not_to_the_end(found, test)] if line]
    lines += unknown(found) if found.get("critical_length") else []
    lines += [one.remark for one in compared(found, about["slope_angle"]) if one.remark]
    axes.axis("off")
    axes.set_title("how it was made and read", loc="left", fontsize=10)
    axes.text(0.0, 1.0, "\n".join(textwrap.fill(line, 60, subsequent_indent="   ") for line in lines), fontsize=7.5,
              va="top", linespacing=1.3, transform=axes.transAxes)


def _times(test, count=6):
    """Rows at which the tip has come through equal parts of its way, the first at the end of the stable cut."""
    tip = test["tip"]
    goals = np.linspace(0.05, 1.0, count) * tip.max()
    return np.unique(np.searchsorted(np.maximum.accumulate(tip), goals).clip(max=len(tip) - 1))


def _deflection(figure, axes, test, found):
    rows = _times(test)
    for k, row in enumerate(rows):
        shade = colormaps["viridis"](0.9 * (1.0 - (k + 1) / len(rows)))
        axes.plot(test["x"], -1e3 * test["settlement"][row], color=shade, lw=1.5, label=f"{test['time'][row]:.3f} s")
        axes.plot(test["tip"][row], 0.0, "v", ms=5, color=TIP, clip_on=False)
    axes.set_xlim(0.0, test.about["length"])
    axes.legend(loc="lower right", title="time; ▼ tip", title_fontsize=8, **LEGEND)
    titled(axes, "deflection of the slab", "along the column  [m]", "displacement normal to the slope  [mm]")


def _settlement(figure, axes, test, found):
    _over_time(axes, test, 1e3 * test["settlement"])
    axes.invert_yaxis()
    titled(axes, "settlement of points of the slab", "time  [s]", "normal to the slope  [mm]")


def _slip(figure, axes, test, found):
    scale, unit = (1e-3, "mm") if np.nanmax(np.abs(test["slip"])) < 0.1 else (1.0, "m")
    _over_time(axes, test, test["slip"] / scale)
    titled(axes, "displacement along the slope", "time  [s]", f"in the saw's way  [{unit}]")


def _over_time(axes, test, lines):
    x, (first, last) = test["x"], _window(test)
    shown = (test["time"] >= first) & (test["time"] <= last)
    for colour, share in zip(COLOURS, POINTS, strict=True):
        i = int(np.argmin(np.abs(x - share * test.about["length"])))
        axes.plot(test["time"][shown], lines[shown, i], color=colour, lw=1.4, label=f"x = {x[i]:.1f} m")
    axes.set_xlim(first, last)
    axes.legend(**LEGEND)
