"""The avalanche along its thalweg: ground, travel angle, and the peak values across it."""

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.records import Record
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import PRESSURES
from snowmpm.render.credit import attribution
from snowmpm.render.figure import check_ending, plain, save
from snowmpm.render.peak_map import runout_words

GROUND, SNOW, LINE = "#4a4f55", "#3f8fc8", "#c1121f"
PANELS = (
    ("peak_depth", "depth  [m]", 1.0, "#3f8fc8"),
    ("peak_speed", "speed  [m/s]", 1.0, "#1d4f91"),
    ("peak_pressure", "pressure ρv²  [kPa]", 1e3, "#d9642a"),
)


def render_thalweg(run_path: PathLike | Run, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw a run along its thalweg to a PNG, PDF or SVG. Returns the path written.

    Top: the ground, the travel angle from the top of the release to the run-out; below: peak depth with the deposit,
    peak speed and peak pressure, the largest value across the thalweg at each place.
    Raises InputError for another ending, or a run without a thalweg.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    check_ending(output)
    profile = Record({name: np.array(values) for name, values in run.hazard.get("profile", {}).items()},
                     f"{run.path}: thalweg")
    if not profile:
        raise InputError(f"{run.path}: no thalweg: the run is two-dimensional, not yet at its end, or nothing moved")
    figure = Figure(figsize=(8.5, 10.0), dpi=dpi, layout="constrained")
    grounds, *others = figure.subplots(1 + len(PANELS), 1, sharex=True, height_ratios=[2.0, 1.0, 1.0, 1.0])
    title = run.name.replace("_", " ")
    figure.suptitle(f"{title}: along the thalweg", fontsize=13, fontweight="bold", color="#11161c")
    _draw_ground(grounds, profile, run)
    for axes, (name, label, scale, colour) in zip(others, PANELS, strict=True):
        plain(axes)
        axes.fill_between(profile["s"], profile[name] / scale, color=colour, alpha=0.25, lw=0.0, step="mid")
        axes.step(profile["s"], profile[name] / scale, color=colour, lw=1.4, where="mid", label="peak")
        axes.axvline(run.hazard["numbers"]["runout"], color=LINE, lw=1.2)
        axes.set_ylabel(label)
        axes.set_ylim(bottom=0.0)
    others[0].step(profile["s"], profile["deposit_depth"], color="#11161c", lw=1.2, where="mid", label="at the end")
    others[0].legend(fontsize=8, edgecolor="none")
    for limit in (pressure / 1e3 for pressure in PRESSURES):
        if limit < others[2].get_ylim()[1]:
            others[2].axhline(limit, color="0.6", lw=0.6, ls=":")
    others[-1].set_xlabel("way along the thalweg, in plan  [m]")
    status = status_of(run)
    if not status.final:
        figure.text(0.5, 0.955, textwrap.fill(status.text, 100), ha="center", va="top", fontsize=9, color=LINE,
                    fontweight="bold")
        lines = len(textwrap.wrap(status.text, 100))
        figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 0.945 - 0.013 * lines))
        figure.suptitle(f"{title}: along the thalweg", y=0.985, fontsize=13, fontweight="bold", color="#11161c")
    credits = attribution(run.provenance)
    if credits:
        figure.supxlabel(credits, fontsize=7, color="0.3")
    return save(figure, output, dpi)


def _draw_ground(axes, profile, run):
    plain(axes)
    numbers = run.hazard["numbers"]
    s, z = profile["s"], profile["z"]
    axes.fill_between(s, z, np.nanmin(z), color=GROUND, alpha=0.15, lw=0.0)
    axes.plot(s, z, color=GROUND, lw=1.6)
    ends = ([0.0, numbers["runout"]], [numbers["top"], numbers["top"] - numbers["fall"]])
    axes.plot(*ends, color=LINE, lw=1.2, ls="--", label=runout_words(run))
    axes.plot(ends[0][1], ends[1][1], "o", color=LINE, ms=5)
    axes.set_ylabel("height  [m]")
    axes.legend(fontsize=9, edgecolor="none")
