"""Picture of a strength reduction: how far the slope moved with each factor, and what slid on what."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from snowmpm.annotations import Floats, PathLike
from snowmpm.render.figure import INK, check_ending, plain, save, titled

STANDS, SLIDES = "#2457a4", "#c1121f"
LEAST = 1e-6
"""Smallest way that is drawn [m]: nothing moves less in single precision."""
AREA = 4e4
"""Of all points together [pt2]."""


@dataclass(frozen=True)
class StrengthCurve:
    """Way over time of one trial: factor, verdict, times (n,) [s], ways (n,) [m]."""

    factor: float
    slides: bool
    times: Floats
    ways: Floats


@dataclass(frozen=True)
class SlipPicture:
    """Particles of a vertical section at the start (n, 2) [m], their ways (n,) [m], the slip surface (m, 2) [m], and a
    line of slices (k, 2) [m] with its factor, where there is one."""

    points: Floats
    ways: Floats
    surface: Floats
    slices: Floats | None = None
    slices_factor: float = float("nan")


def render_strength(title: str, curves: Sequence[StrengthCurve], slip: SlipPicture, output: PathLike,
                    dpi: float = 150) -> Path:
    """Draw a strength reduction to `output`."""
    check_ending(output)
    extent = np.ptp(slip.points, axis=0)
    figure = Figure(figsize=(9.0, 3.4 + 8.6 * min(extent[1] / max(extent[0], 1e-9), 1.2)), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=[2.6, 0.6 + 8.0 * min(extent[1] / max(extent[0], 1e-9), 1.2)])
    for curve in sorted(curves, key=lambda curve: curve.factor):
        upper.plot(curve.times[1:], np.maximum(curve.ways[1:], LEAST), color=SLIDES if curve.slides else STANDS, lw=1.3)
        upper.annotate(f"{curve.factor:g}", (curve.times[-1], max(curve.ways[-1], LEAST)), xytext=(4, 0),
                       textcoords="offset points", fontsize=8, va="center")
    upper.set_yscale("log")
    plain(upper)
    titled(upper, f"{title}: way that 1 % exceed, by the factor that divides the strength", "time [s]", "way [m]")
    upper.plot([], [], color=STANDS, label="stands")
    upper.plot([], [], color=SLIDES, label="slides")
    upper.legend(fontsize=8, frameon=False, loc="upper left")
    _section(figure, lower, slip)
    return save(figure, output, dpi)


def _section(figure, axes, slip):
    """Ways in the section, the slip surface and the line of slices."""
    order: NDArray[np.intp] = np.argsort(slip.ways)
    points = axes.scatter(*slip.points[order].T, c=slip.ways[order], s=min(AREA / len(slip.ways), 60.0), cmap="YlOrRd",
                          linewidths=0, vmax=float(np.quantile(slip.ways, 0.99)))
    axes.plot(*slip.surface.T, color=INK, lw=1.4, label="lower border of the slide")
    if slip.slices is not None:
        axes.plot(*slip.slices.T, color="#2457a4", lw=1.2, ls="--",
                  label=f"slices on circles (Bishop), factor {slip.slices_factor:.2f}")
    axes.set_aspect("equal")
    plain(axes)
    titled(axes, "the first that slides: ways, drawn where the material was", "x [m]", "z [m]")
    axes.legend(fontsize=8, frameon=False, loc="upper left")
    figure.colorbar(points, ax=axes, label="way [m]", shrink=0.8, pad=0.01)
