"""Flow through the pores of a sample: a slice along each axis of the flow, ice and speeds."""

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import Numbers, PathLike
from snowmpm.render.figure import check_ending, save, titled


def render_flow(ice: Numbers, speeds: dict[int, Numbers], voxel_size: float, output: PathLike, title: str = "",
                note: str = "") -> Path:
    """Draw the middle slice of a sample for each flow. Returns the path.

    ice (nx, ny, nz): True where there is ice; speeds: {axis of the flow: |u| (nx, ny, nz)}, any unit; voxel_size [m];
    note: below the picture.
    """
    check_ending(output)
    figure = Figure(figsize=(4.6 * max(1, len(speeds)), 4.6), layout="constrained")
    if note:
        figure.supxlabel(textwrap.fill(note, 64 * max(1, len(speeds))), fontsize=8)
    for place, (axis, speed) in enumerate(sorted(speeds.items()), 1):
        across = (axis + 1) % 3  # the slice holds the axis of the flow, drawn upwards
        other = 3 - axis - across
        middle = ice.shape[across] // 2
        shown = [np.moveaxis(values, (other, axis, across), (1, 0, 2))[:, :, middle] for values in (ice, speed)]
        extent = (0.0, 1e3 * voxel_size * ice.shape[other], 0.0, 1e3 * voxel_size * ice.shape[axis])
        panel = figure.add_subplot(1, len(speeds), place)
        mean = float(speed[~ice].mean()) or 1.0
        image = panel.imshow(np.where(shown[0], np.nan, shown[1] / mean), origin="lower", extent=extent, vmin=0.0,
                             vmax=max(1.0, float(np.quantile(speed[~ice] / mean, 0.995))), cmap="viridis")
        panel.set_facecolor("0.85")
        titled(panel, f"{title}: flow along {'xyz'[axis]}".lstrip(": "), f"{'xyz'[other]} [mm]", f"{'xyz'[axis]} [mm]")
        figure.colorbar(image, ax=panel, label="speed over its mean in the pores; grey: ice", shrink=0.8)
    return save(figure, output, 110)
