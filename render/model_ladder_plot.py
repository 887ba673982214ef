"""The ladder of models: error against processor time, a mark for each rung, and the front of what nothing beats."""

from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from snowmpm.render.figure import check_ending, save

INK, FRONT, QUIET = "#11161c", "#f2c14e", "#8a949e"
MOST = 20.0
"""Relative error up to which is drawn."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7a5c2e", "#c2185b", "#11161c", "#999933")


@dataclass(frozen=True)
class Rung:
    """name; seconds, errors: of each problem; typical: median of the seconds; error: expected, None where too few
    problems tell."""

    name: str
    seconds: tuple[float, ...]
    errors: tuple[float, ...]
    typical: float
    error: float | None


def render_ladder(rungs, output, *, title, y_label, problems, dpi=110):
    """Draw `Rung`s to a PNG, PDF or SVG: small dots for problems, a large mark for the expected error; -> the path.
    Raises InputError for another ending."""
    check_ending(output)
    figure = Figure(figsize=(9.2, 5.6), dpi=dpi, layout="constrained")
    axes = figure.subplots()
    kinds = list(dict.fromkeys(_kind(one.name) for one in rungs))
    colours = {kind: COLOURS[k % len(COLOURS)] for k, kind in enumerate(kinds)}
    for one in rungs:
        axes.scatter(one.seconds, one.errors, s=9, color=colours[_kind(one.name)], alpha=0.35, linewidths=0)
    known = sorted((one for one in rungs if one.error is not None), key=lambda one: (one.typical, one.error))
    for kind in dict.fromkeys(_kind(one.name) for one in known):
        own = sorted((one for one in known if _kind(one.name) == kind), key=_fineness)
        axes.plot([one.typical for one in own], [one.error for one in own], "o-", color=colours[kind], markersize=6,
                  linewidth=1.2, label=kind, zorder=3)
        for one in own:
            label = one.name.rpartition(", ")[2] if ", " in one.name else ""
            axes.annotate(label, (one.typical, one.error), textcoords="offset points", xytext=(5, 4), fontsize=7,
                          color=colours[kind])
    front, best = [], float("inf")
    for one in known:
        if one.error < best:
            front.append(one)
            best = one.error
    if front:
        axes.plot([one.typical for one in front], [one.error for one in front], color=FRONT, linewidth=6, alpha=0.5,
                  zorder=1, solid_capstyle="round", label="nothing beats these")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(top=MOST)
    axes.spines[["top", "right"]].set_visible(False)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100.0 * value:g} %"))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("processor seconds of the whole command, one thread (median of the problems)")
    axes.set_ylabel(y_label)
    axes.grid(True, which="major", color="#e3e6e9", linewidth=0.7)
    axes.set_title(title, fontsize=12, fontweight="bold", color=INK, loc="left")
    if known:
        axes.legend(frameon=False, fontsize=8, loc="upper right")
    figure.supxlabel(f"{problems} problems; small dots: the error of one problem; large: expected, from all of them",
                     fontsize=8, color=QUIET)
    return save(figure, output, dpi)


def _fineness(rung):
    """Number in the name of a rung: cells, or their size, which is the finer the less it is."""
    number, _, unit = rung.name.rpartition(", ")[2].partition(" ")
    try:
        return -float(number) if unit == "m" else float(number)
    except ValueError:
        return 0.0


def _kind(name):
    """Name of a rung without its grid."""
    return name.rpartition(", ")[0] or name
