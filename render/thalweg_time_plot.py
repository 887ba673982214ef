"""Thalweg-time diagram: depth and speed of an avalanche along its thalweg over time."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.io import Run
from snowmpm.io.status import status_of
from snowmpm.io.thalweg_time import ThalwegTime
from snowmpm.render.credit import attribution
from snowmpm.render.figure import check_ending, plain, save

FRONT = "#c1121f"
PANELS = (("depth", "depth  [m]", "YlGnBu"), ("speed", "speed  [m/s]", "YlOrRd"))


def render_thalweg_time(run_path: PathLike | Run, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw depth and speed of a run along its thalweg (down) over time (right) to a PNG, PDF or SVG: at each place the
    largest value across the thalweg (`snowmpm.io.thalweg_time`), the front, and the run-out. Returns the path written.

    Raises InputError for another ending, a run without a thalweg, or frames without velocity.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    check_ending(output)
    found = ThalwegTime.of(run)
    figure = Figure(figsize=(9.5, 8.5), dpi=dpi, layout="constrained")
    status = status_of(run)
    title = f"{run.name.replace('_', ' ')}: along the thalweg over time"
    figure.suptitle(title if status.final else f"{title} (NOT FINAL)", fontsize=13, fontweight="bold",
                    color="#11161c" if status.final else FRONT)
    reach = np.nan_to_num(found.front).max(initial=0.0)
    shown = found.s <= max(reach, run.hazard["numbers"].get("runout", 0.0)) + 3.0 * np.diff(found.s).max()
    for axes, (name, label, colours) in zip(figure.subplots(len(PANELS), 1, sharex=True), PANELS, strict=True):
        plain(axes)
        values = np.where(np.nan_to_num(found.depth) >= found.flow_depth, vars(found)[name], np.nan)
        drawn = axes.pcolormesh(found.time, found.s[shown], values[:, shown].T, cmap=colours, shading="nearest",
                                vmin=0.0, rasterized=True)
        figure.colorbar(drawn, ax=axes, label=label)
        axes.plot(found.time, found.front, color=FRONT, lw=1.2, label=f"front, at most {found.front_speed:.0f} m/s")
        if "runout" in run.hazard["numbers"]:
            axes.axhline(run.hazard["numbers"]["runout"], color="0.3", lw=0.8, ls="--",
                         label=f"run-out {run.hazard['numbers']['runout']:.0f} m")
        axes.invert_yaxis()
        axes.set_ylabel("way along the thalweg, in plan  [m]")
    axes.legend(fontsize=8, edgecolor="none", loc="lower right")
    axes.set_xlabel("time  [s]")
    credits = attribution(run.provenance)
    if credits:
        figure.supxlabel(credits, fontsize=7, color="0.3")
    return save(figure, output, dpi)
