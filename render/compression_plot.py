"""Stress against strain of a sample under a piston, with the stages that it goes through."""


from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.figure import check_ending, plain, prefixed, save
from snowmpm.results.compression import StressStrain, stages

CURVE, MARK = "#1d4f91", "#d9642a"
BANDS = ("#e9f0f8", "#fbe9dd", "#eef5ec", "#f3e8f1")
WIDE = 10.0  # end over peak stress from which the axis is logarithmic: densification would flatten all before it
NAMES = ("elastic", "softening", "collapse", "densification")


def render_compression(run_path: PathLike | Run, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw the stress-strain curve of a run (a folder, a file or a `snowmpm.io.Run`) to a PNG, PDF or SVG; -> its path.

    Raises InputError for another ending, or a run that presses no sample.
    """
    check_ending(output)
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    curve = curve_of(run)
    figure = Figure(figsize=(9.0, 3.6), dpi=dpi, layout="constrained")
    axes = figure.subplots()
    plain(axes)
    scale, unit = prefixed(curve.stress)
    found = stages(curve)
    axes.set_xlim(0.0, curve.strain[-1])
    if found:
        _draw_stages(axes, curve, found, scale)
    axes.plot(curve.strain, curve.stress / scale, color=CURVE, lw=1.6)
    if found and found.end_stress > WIDE * found.peak_stress:
        axes.set_yscale("log")
        axes.set_ylim(0.5 * found.softened / scale, 3.0 * curve.stress.max() / scale)
    else:
        axes.set_ylim(0.0, 1.12 * curve.stress.max() / scale)
    axes.set_xlabel("strain, of the height at the start  [-]")
    axes.set_ylabel(f"stress on the piston  [{unit}]")
    return save(figure, output, dpi)


def curve_of(run):
    """`StressStrain` of the obstacle that moves down in a domain with a floor."""
    scene = run.scene
    pistons = {name: one for name, one in run.obstacles.items() if np.ptp(one.translation[:, 2]) > 0.0}
    if len(pistons) != 1 or "min" not in scene.get("domain", {}):
        raise InputError(f"{run.path}: no compression to plot: it takes one obstacle that moves down in a [domain] with"
                         " min and max")
    (piston,) = pistons.values()
    low, high = np.array(scene["domain"]["min"]), np.array(scene["domain"]["max"])
    height = float(piston.vertices[:, 2].min() + run.origin[2] - low[-1])
    moved = piston.translation[0, 2] - piston.translation[:, 2]
    displacement = np.interp(piston.time, run.times, moved)
    return StressStrain.of_piston(piston.time, piston.impulse[:, 2], displacement, height, np.prod((high - low)[:-1]))


def _draw_stages(axes, curve, found, scale):
    """Bands of the stages, what was read off as a mark each."""
    low = np.flatnonzero((curve.stress <= found.softened) & (curve.strain >= found.peak_strain))[0]
    ends = [0.0, found.peak_strain, curve.strain[low], found.densification, curve.strain[-1]]
    for k, name in enumerate(NAMES):
        axes.axvspan(ends[k], ends[k + 1], color=BANDS[k], lw=0)
        axes.annotate(name, (0.5 * (ends[k] + ends[k + 1]), 0.97), xycoords=("data", "axes fraction"), ha="center",
                      va="top", fontsize=9, color="0.3", rotation=90 if ends[k + 1] - ends[k] < 0.1 * ends[-1] else 0)
    axes.plot([found.peak_strain], [found.peak_stress / scale], "o", color=MARK, ms=5)
    axes.hlines(found.plateau / scale, found.peak_strain, found.densification, color=MARK, ls="--", lw=1.2)
