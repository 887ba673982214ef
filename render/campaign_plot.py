"""Plots of many runs: what a number depends on, how it scatters, how it converges, and what is known of parameters."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from snowmpm.annotations import Floats, PathLike
from snowmpm.quantities.quantity import digits
from snowmpm.quantities.table import quantity
from snowmpm.render.figure import INK, check_ending, plain, save, titled

BLUE, RED, GREY, PALE = "#2457a4", "#c1121f", "#6b7280", "#b9c6dc"
COLOURS = ("#0072B2", "#E69F00", "#000000", "#CC79A7", "#009E73", "#56B4E9")
DASHES = ("--", ":", "-.")

Line = tuple[str, Floats, Floats, NDArray[np.bool_], bool]
"""(label, x (n,), values (n,), which runs are whole (n,), whether it is a theory)"""


def label(name: str, dimension: int = 3) -> str:
    """A number of the table, with its unit; in 2-D amounts are per metre of width."""
    one = quantity(name, dimension=dimension)
    unit = "" if one.unit in ("1", "share") else f" [{one.unit}]"
    return f"{one.label}{unit}"


def render_tornado(number: str, rows: Sequence[Mapping[str, float | str]], output: PathLike, dpi: float = 150) -> Path:
    """What a number depends on: rank correlation of each parameter, and shares of the variance where they are known.

    rows: of the number, one a parameter: "parameter", "correlation", "first", "total" and their "_low" and "_high".
    """
    check_ending(output)
    ordered = sorted(rows, key=lambda row: abs(float(row["correlation"])))
    names, at = [str(row["parameter"]) for row in ordered], np.arange(len(ordered))
    known = any(np.isfinite(float(row["first"])) for row in ordered)
    figure = Figure(figsize=(8.4 if known else 5.0, 1.5 + 0.55 * len(ordered)), layout="constrained")
    panels = figure.subplots(1, 2 if known else 1, sharey=True, squeeze=False)[0]
    correlation = np.array([float(row["correlation"]) for row in ordered])
    panels[0].barh(at, correlation, 0.6, color=[BLUE if value > 0.0 else RED for value in correlation])
    panels[0].axvline(0.0, color=INK, lw=0.8)
    panels[0].set_xlim(-1.05, 1.05)
    plain(panels[0])
    titled(panels[0], f"{label(number)}: rank correlation", "grows with it: blue, falls with it: red", "")
    panels[0].set_yticks(at, names)
    if known:
        for shift, part, colour, words in ((0.17, "first", BLUE, "alone (first order)"),
                                           (-0.17, "total", PALE, "with all others (total)")):
            values = np.array([float(row[part]) for row in ordered])
            ends = np.array([[float(row[f"{part}_{side}"]) for row in ordered] for side in ("low", "high")])
            errors = np.maximum(np.array([values - ends[0], ends[1] - values]), 0.0)
            panels[1].barh(at + shift, values, 0.32, xerr=errors, color=colour, label=words,
                           error_kw={"lw": 0.9, "ecolor": INK, "capsize": 2})
        plain(panels[1])
        panels[1].set_xlim(0.0, 1.05)
        titled(panels[1], "share of its variance", f"{rows[0]['method']}; bars: 95 %", "")
        panels[1].legend(fontsize=8, frameon=False, loc="lower right")
    return save(figure, output, dpi)


def render_scatter(table: Mapping[str, Floats], parameters: Sequence[str], numbers: Sequence[str], output: PathLike,
                   dpi: float = 130, dimension: int = 3) -> Path:
    """Each number over each parameter, a point a run. table: columns (runs,)."""
    check_ending(output)
    figure = Figure(figsize=(2.6 * len(parameters) + 0.6, 2.1 * len(numbers) + 0.5), layout="constrained")
    panels = figure.subplots(len(numbers), len(parameters), sharex="col", sharey="row", squeeze=False)
    for row, number in zip(panels, numbers, strict=True):
        for axes, parameter in zip(row, parameters, strict=True):
            axes.plot(table[parameter], table[number], ".", ms=4.0, color=BLUE, alpha=0.6, mew=0)
            plain(axes)
            axes.tick_params(labelsize=7)
        row[0].set_ylabel(label(number, dimension), fontsize=8)
    for axes, parameter in zip(panels[-1], parameters, strict=True):
        axes.set_xlabel(parameter, fontsize=9)
    return save(figure, output, dpi)


def render_curves(number: str, across: str, lines: Sequence[Line], output: PathLike, dpi: float = 150,
                  dimension: int = 3) -> Path:
    """A number of a grid of runs over one of its parameters. lines: `Line`s; runs that are not whole are hollow,
    theories dashed."""
    check_ending(output)
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.add_subplot()
    runs = [one for one in lines if not one[4]]
    for i, (words, x, values, whole, theory) in enumerate(lines):
        colour = COLOURS[sum(not one[4] for one in lines[:i + 1]) % len(COLOURS) - 1]
        if theory:
            dashes = DASHES[i % len(DASHES)]
            axes.plot(x, values, ls=dashes, lw=1.2, color=GREY if len(runs) == 1 else colour, label=words)
            continue
        axes.plot(x, values, "-", lw=1.6, color=colour, label=words if words != "computed" or len(lines) > 1 else None)
        axes.plot(x[whole], values[whole], "o", ms=5, color=colour)
        axes.plot(x[~whole], values[~whole], "o", ms=5, color=colour, mfc="white")
    if any((~one[3] & np.isfinite(one[2])).any() for one in lines):
        axes.plot([], [], "o", ms=5, color=GREY, mfc="white", label="did not run to the end")
    plain(axes)
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8, frameon=False)
    titled(axes, f"{sum(int(np.isfinite(one[2]).sum()) for one in runs)} runs", across, label(number, dimension))
    return save(figure, output, dpi)


def render_distribution(number: str, values: Floats, output: PathLike, dpi: float = 150, dimension: int = 3) -> Path:
    """Share of runs with at least this value of a number."""
    check_ending(output)
    ordered = np.sort(values[np.isfinite(values)])
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.add_subplot()
    axes.step(ordered, 1.0 - np.arange(len(ordered)) / len(ordered), where="pre", color=BLUE, lw=1.8)
    for share in (0.95, 0.5, 0.05):
        value = float(np.quantile(ordered, 1.0 - share))
        axes.plot([value, value], [0.0, share], color=GREY, lw=0.8, ls=(0, (4, 3)))
        axes.annotate(f"{100 * share:g} %: {quantity(number, dimension=dimension).text(value)}", (value, share), (4, 2),
                      fontsize=8, color=INK, textcoords="offset points")
    plain(axes)
    axes.set_ylim(0.0, 1.02)
    titled(axes, f"{len(ordered)} runs", label(number, dimension), "share of runs at or above")
    return save(figure, output, dpi)


def render_convergence(rows: Sequence[Mapping[str, float | str]], output: PathLike, dpi: float = 150) -> Path:
    """How the probability maps change with the number of runs. rows: of `snowmpm.campaigns.convergence`."""
    check_ending(output)
    figure = Figure(figsize=(8.4, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    kinds = list(dict.fromkeys((row["quantity"], row["limit"]) for row in rows))
    for (name, limit), colour in zip(kinds, (BLUE, RED, GREY, INK), strict=False):
        own = [row for row in rows if (row["quantity"], row["limit"]) == (name, limit)]
        runs = [float(row["runs"]) for row in own]
        words = f"{name} of {quantity(f'peak_{name}').text(float(limit))}"
        left.loglog(runs, [float(row["half_width"]) for row in own], "-", color=colour, label=f"{words}: interval")
        changes = np.array([float(row["difference"]) for row in own])
        left.loglog(np.array(runs)[changes > 0.0], changes[changes > 0.0], "o--", ms=3.5, lw=1.0, color=colour,
                    label=f"{words}: from all runs")
        right.plot(runs, [float(row["area"]) / 1e4 for row in own], "o-", ms=3.5, color=colour, label=words)
    for axes in (left, right):
        plain(axes)
        axes.legend(fontsize=7, frameon=False)
    left.xaxis.set_major_locator(right.xaxis.get_major_locator().__class__(4))
    left.set_xscale("log")
    titled(left, "probability map: mean uncertainty", "runs", "probability")
    titled(right, "area with a probability of 5 % or more", "runs", "area [ha]")
    right.set_ylim(bottom=0.0)
    return save(figure, output, dpi)


def render_corner(samples: Mapping[str, Floats], weights: Floats, output: PathLike, *,
                  prior: Mapping[str, tuple[float, float]] | None = None, truth: Mapping[str, float] | None = None,
                  dpi: float = 150) -> Path:
    """What is known of parameters: weighted samples of each, and of each pair.

    samples: (n,) by parameter; weights (n,); prior: range of the axes by parameter; truth: values to be marked.
    """
    check_ending(output)
    names = list(samples)
    size = 2.3 * len(names) + 0.7
    figure = Figure(figsize=(max(size, 3.8), max(size, 3.2)), layout="constrained")
    panels = figure.subplots(len(names), len(names), squeeze=False)
    for i, below in enumerate(names):
        for j, across in enumerate(names):
            axes = panels[i, j]
            if j > i:
                axes.set_visible(False)
                continue
            plain(axes)
            axes.tick_params(labelsize=7)
            if prior and across in prior:
                axes.set_xlim(*prior[across])
            if i == j:
                _distribution(axes, samples[across], weights, axes.get_xlim() if prior else None)
                axes.set_yticks([])
            else:
                axes.scatter(samples[across], samples[below], s=300.0 * weights / weights.max() / 10.0, color=BLUE,
                             alpha=0.5, lw=0)
                if prior and below in prior:
                    axes.set_ylim(*prior[below])
                if truth and below in truth:
                    axes.axhline(truth[below], color=RED, lw=1.0)
            if truth and across in truth:
                axes.axvline(truth[across], color=RED, lw=1.0)
            if i == len(names) - 1:
                axes.set_xlabel(across, fontsize=9)
            if j == 0 and i:
                axes.set_ylabel(below, fontsize=9)
    return save(figure, output, dpi)


def _distribution(axes, values, weights, limits):
    mean = float(weights @ values / weights.sum())
    spread = float(np.sqrt(weights @ (values - mean) ** 2 / weights.sum()))
    axes.hist(values, 20, range=limits, weights=weights, color=PALE)
    axes.axvline(mean, color=INK, lw=1.0)
    axes.set_title(f"{digits(mean)} ± {digits(spread)}", fontsize=9, loc="left")
