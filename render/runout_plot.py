"""Run-out by the cheapest models: the profile of the path with where each stops, and the routing over the ground."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LightSource
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.render.figure import check_ending, plain, save

COLOURS = ("#1d4f91", "#d9642a", "#3a7d44", "#7b4fa3", "#b8860b", "#c1121f", "#3f8fc8", "#8a5a44")
GROUND, SNOW = "#5b5048", "#11161c"


def render_runout(found: Any, ground: Any, output: PathLike, title: str, *, dpi: float = 130) -> Path:
    """Draw a `snowmpm.runout.models.Runout` on its `Ground` to a PNG, PDF or SVG; -> the path. Raises InputError for
    another ending."""
    check_ending(output)
    figure = Figure(figsize=(12.0, 6.4), dpi=dpi, layout="constrained")
    figure.suptitle(f"{title}: run-out by models without a flow", fontsize=13, fontweight="bold")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    colours = {one.model: COLOURS[k % len(COLOURS)] for k, one in enumerate(found.reaches)}
    _profile(left, found, colours)
    _map(right, found, ground, colours)
    figure.supxlabel("Results of models. No hazard assessment.", fontsize=7, color="0.3")
    return save(figure, output, dpi)


def _profile(axes, found, colours):
    profile = found.profile
    plain(axes)
    axes.plot(profile.s, profile.z, color=GROUND, lw=1.8)
    axes.fill_between(profile.s, profile.z, profile.z.min() - 20.0, color=GROUND, alpha=0.12, lw=0)
    for one in found.reaches:
        if one.s is None or "longest way" in one.model:  # no length along this path
            continue
        statistics = one.speed is None
        axes.plot(one.s, one.height, ls="", marker="v" if statistics else "o", ms=8, color=colours[one.model],
                  mec="white", zorder=5, label=f"{one.model}: {one.s:.0f} m")
        if statistics:
            axes.plot([0.0, one.s], [profile.z[0], one.height], color=colours[one.model], lw=0.8, ls=":")
    if found.statistics:
        axes.plot(found.statistics.beta_s, profile.at(found.statistics.beta_s)[1], ls="", marker="s", ms=7, color=SNOW,
                  mec="white", label=f"beta point: {found.statistics.beta_s:.0f} m, {found.statistics.beta:.1f}°")
    axes.set_xlabel("length in plan  [m]")
    axes.set_ylabel("height  [m]")
    axes.legend(fontsize=8, framealpha=0.9, edgecolor="none")


def _map(axes, found, ground, colours):
    reached = np.isfinite(found.routed.energy)
    cells = np.argwhere(reached)
    corners = np.vstack([ground.places(cells), found.profile.plan])
    low, high = corners.min(axis=0) - 100.0, corners.max(axis=0) + 100.0
    box = [ground.lower[0], ground.lower[0] + ground.cell * ground.z.shape[0],
           ground.lower[1], ground.lower[1] + ground.cell * ground.z.shape[1]]
    z = np.where(np.isfinite(ground.z), ground.z, np.nanmean(ground.z))
    shade = LightSource(315, 45).hillshade(z.T, dx=ground.cell, dy=ground.cell)
    axes.imshow(shade, cmap="gray", extent=box, origin="lower", vmin=-0.2, vmax=1.1)
    image = axes.imshow(np.sqrt(2.0 * 9.81 * found.routed.energy).T, cmap="viridis", extent=box, origin="lower",
                        alpha=0.8)
    axes.figure.colorbar(image, ax=axes, label=f"routing at {found.routing.angle:g}°: speed  [m/s]", shrink=0.8)
    axes.plot(*found.profile.plan.T, color=SNOW, lw=1.0, ls="--")
    for one in found.reaches:
        if one.place is not None:
            axes.plot(*one.place, marker="v" if one.speed is None else "o", ms=7, color=colours[one.model],
                      mec="white", zorder=5)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="east  [m]", ylabel="north  [m]")
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.tick_params(labelsize=7)
