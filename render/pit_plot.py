"""A snow profile as practice draws it: hardness to the left, temperature over it, grains, densities, tests."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.quantities.snow_codes import hardness_code, is_crust, main_class
from snowmpm.render.figure import INK, check_ending, plain, save

COLOURS = {"PP": "#00ff00", "MM": "#ffd700", "DF": "#228b22", "RG": "#ffb6c1", "FC": "#add8e6", "DH": "#0000ff",
           "SH": "#ff00ff", "MF": "#ff0000", "IF": "#00ffff", "": "#d8d8d8"}
"""Of main classes: the colour convention of Fierz et al. (2009)."""
SYMBOLS = {"PP": "+", "DF": "/", "RG": "●", "FC": "□", "DH": "∧", "SH": "∨", "MF": "○", "IF": "▬", "MM": "◎",
           "PPgp": "△", "FCxr": "▢", "RGxf": "◉", "MFcr": "⊙"}
WARM = "#c1121f"
WEAK = "#d9642a"
STEPS = ((1, "F"), (2, "4F"), (3, "1F"), (4, "P"), (5, "K"), (6, "I"))
LEAST_GAP = 0.022
"""Between lines of text, as a share of the height of the panel."""


def render_pit(profile: Any, output: PathLike, *, weak: int | None = None, dpi: float = 130) -> Path:
    """Draw a `snowmpm.pit.profile.SnowProfile` to a PNG, PDF or SVG; -> the path. weak: index of its weak layer.

    Raises InputError for another ending.
    """
    check_ending(output)
    tall = float(np.clip(4.0 + 0.16 * len(profile.layers), 5.5, 11.0))
    figure = Figure(figsize=(9.2, tall), dpi=dpi, layout="constrained")
    figure.suptitle(_title(profile), fontsize=11, fontweight="bold", color=INK)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0), sharey=True)
    _strength(left, profile, weak)
    _words(right, profile, weak)
    left.set_ylim(100.0 * profile.depth, 0.0)
    left.set_ylabel("depth  [cm], vertical")
    return save(figure, output, dpi)


def _title(profile):
    parts = [profile.name, profile.time[:16].replace("T", " ")]
    if profile.elevation is not None:
        parts.append(f"{profile.elevation:.0f} m")
    if profile.aspect:
        parts.append(profile.aspect)
    if profile.slope_angle is not None:
        parts.append(f"{profile.slope_angle:g}°")
    return "   ".join(part for part in parts if part)


def _strength(axes, profile, weak):
    """Hardness as bars from the right to the left, or density where no hardness is known; temperature above."""
    plain(axes)
    hard = any(layer.hardness for layer in profile.layers)
    for k, layer in enumerate(profile.layers):
        values = layer.hardness if hard else layer.density and (layer.density, layer.density)
        top, bottom = 100.0 * layer.top, 100.0 * layer.bottom
        if values:
            axes.fill([0.0, values[0], values[1], 0.0], [top, top, bottom, bottom],
                      facecolor=COLOURS[main_class(layer.form)], alpha=0.75, edgecolor="0.35", lw=0.6,
                      hatch="////" if is_crust(layer.form) and main_class(layer.form) == "MF" else None)
        if k == weak:
            axes.axhspan(top, bottom, color=WEAK, alpha=0.25, zorder=0)
    if hard:
        axes.set_xlim(6.5, 0.0)
        axes.set_xticks([step for step, _ in STEPS], [name for _, name in STEPS])
        axes.set_xlabel("hand hardness")
    else:
        axes.set_xlim(1.1 * max(layer.density or 0.0 for layer in profile.layers) or 1.0, 0.0)
        axes.set_xlabel("density  [kg/m³]")
    if profile.temperatures:
        depth, value = np.array(sorted(profile.temperatures)).T
        warmth = axes.twiny()
        warmth.plot(value, 100.0 * depth, color=WARM, lw=1.3, marker=".", ms=4)
        warmth.set_xlim(min(-5.0, 1.1 * value.min()), 0.0)
        warmth.set_xlabel("temperature  [°C]", color=WARM)
        warmth.tick_params(axis="x", colors=WARM, labelsize=8)


def _words(axes, profile, weak):
    """A line of text each layer, beside it as far as there is room, and the tests."""
    axes.axis("off")
    axes.set_xlim(0.0, 1.0)
    heads = ((0.10, "form"), (0.25, "size\nmm"), (0.38, "hand"), (0.53, "density\nkg/m³"), (0.64, "tests"))
    for x, head in heads:
        axes.text(x, 1.005, head, transform=axes.transAxes, ha="left" if head == "tests" else "center", va="bottom",
                  fontsize=8, color="0.35")
    whole = 100.0 * profile.depth
    middles = [100.0 * layer.middle for layer in profile.layers]
    for k, (layer, y) in enumerate(zip(profile.layers, _spread(middles, LEAST_GAP * whole, whole), strict=True)):
        colour, weight = (WEAK, "bold") if k == weak else (INK, "normal")
        axes.plot([0.0, 0.03], [middles[k], y], color="0.7", lw=0.6, clip_on=False)
        form = f"{SYMBOLS.get(layer.form) or SYMBOLS.get(main_class(layer.form), '')} {layer.form}".strip()
        for x, text in zip((0.10, 0.25, 0.38, 0.53), (
                form, f"{layer.size:g}" if layer.size else "",
                hardness_code(layer.mean_hardness) if layer.hardness else "",
                f"{layer.density:.0f}" if layer.density else ""), strict=True):
            axes.text(x, y, text, ha="center", va="center", fontsize=7.5, color=colour, fontweight=weight)
    tests = sorted((test for test in profile.tests if test.depth is not None), key=lambda test: test.depth)
    places = _spread([100.0 * test.depth for test in tests], LEAST_GAP * whole, whole)
    for test, y in zip(tests, places, strict=True):
        text = str(test).rpartition(" at ")[0]
        run = "End" in test.result or "ECTP" in test.result
        axes.annotate(text, (0.60, 100.0 * test.depth), (0.64, y), fontsize=7.5, va="center",
                      color=WARM if run else INK, arrowprops={"arrowstyle": "-", "color": "0.6", "lw": 0.6})


def _spread(places, gap, whole):
    """Places of lines of text, in order, at least `gap` apart and within the panel, near to `places`."""
    spread, last = [], -np.inf
    for place in places:
        last = max(place, last + gap)
        spread.append(last)
    over = whole - 0.5 * gap
    for k in reversed(range(len(spread))):
        spread[k] = min(spread[k], over)
        over = spread[k] - gap
    return spread


def render_scatter(pairs: Any, output: PathLike, title: str, *, dpi: float = 130) -> Path:
    """Draw predicted against measured critical lengths; -> the path.

    pairs: {theory: (measured (n,), predicted (n,))} [m]. Raises InputError for another ending than of a picture.
    """
    check_ending(output)
    figure = Figure(figsize=(4.2 * max(1, len(pairs)), 4.6), dpi=dpi, layout="constrained")
    figure.suptitle(title, fontsize=11, fontweight="bold", color=INK)
    figure.supxlabel("Grey: within a factor of 1.5. On the lower edge: 0, a layer that fails under its slab alone.",
                     fontsize=8, color="0.3")
    lower, upper = 0.04, 4.0
    for axes, (theory, (measured, predicted)) in zip(
            np.atleast_1d(figure.subplots(1, max(1, len(pairs)))), pairs.items(), strict=False):
        plain(axes)
        axes.set(xscale="log", yscale="log", xlim=(lower, upper), ylim=(lower, upper), aspect="equal",
                 xlabel="measured cut  [m]", ylabel="computed critical cut length  [m]")
        line = np.array([lower, upper])
        axes.fill_between(line, line / 1.5, line * 1.5, color="0.92", lw=0)
        axes.plot(line, line, color="0.5", lw=0.9)
        axes.plot(measured, np.maximum(predicted, lower), ls="", marker="o", ms=4, color="#1d4f91", alpha=0.6,
                  mec="white", mew=0.4, clip_on=False)
        axes.set_title(f"{theory} (n = {len(measured)})", loc="left", fontsize=10)
    return save(figure, output, dpi)
