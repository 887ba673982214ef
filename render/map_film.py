"""The map of an avalanche while it flows: depth or speed in plan over time, as an MP4 or GIF."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.flow_maps import NAMES, FlowMaps, moments
from snowmpm.io.ground_maps import Map
from snowmpm.quantities.table import quantity
from snowmpm.render.film import FILMS, open_film, output_kind
from snowmpm.render.map_frame import draw_frame, draw_terrain, figure_size
from snowmpm.render.peak_map import OPACITY, draw_built, draw_raster, map_box, shown_values


def render_map_film(run_path: PathLike | Run, name: str, output: PathLike, *, fps: float = 5.0, dpi: float = 90,
                    progress: Callable[[int, int], object] | None = None) -> Path:
    """Draw `name`, "momentary_depth" or "momentary_speed", over the terrain at some 40 times of a run; -> the path.

    Classes, colours and frame as of `render_map`; snow thinner than the run's `flow_depth` is pale. output: .mp4 or
    .gif; progress(done, total) is called after each picture.
    Raises InputError for another name or ending, or a run without maps or velocities.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    if name not in NAMES:
        raise InputError.not_in("map", name, NAMES, file=run.path)
    if output_kind(output) not in FILMS:
        raise InputError.at("output", str(output), f"must end in {' or '.join(FILMS)}")
    times, raster = moments(run), run.maps["peak_depth"]
    maps = FlowMaps(run)
    found = [maps.at(i) for i, *_ in times]
    values = [shown_values(one[name], name) for one in found]
    largest = max((float(np.nanmax(one)) for one in values if np.isfinite(one).any()), default=0.0)
    if not largest > 0.0:
        raise InputError(f"{run.path}: {name} has no values to draw")
    limit = run.hazard.get("numbers", {}).get("flow_depth") or 0.0
    pale = [~(one["momentary_depth"] >= limit) for one in found]
    lower, upper = map_box(run)
    figure = Figure(figsize=figure_size(lower, upper), dpi=dpi, layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    _draw_ground(axes, run, lower, upper)
    first = Map(values[0], raster.x0, raster.y0, raster.cell, quantity(name).unit)
    image, _ = draw_raster(figure, axes, run, first, name, pale[0], largest)
    draw_built(axes, run)
    title = f"{run.name}: {quantity(name).label}".replace("_", " ")
    draw_frame(axes, run, title, lower, upper)
    canvas, digits = FigureCanvasAgg(figure), 0 if times[-1][1] >= 100.0 else 1
    with open_film(output, fps) as show:
        for done, ((_, time, _), now, thin) in enumerate(zip(times, values, pale, strict=True), 1):
            image.set_data(now)
            image.set_alpha(np.where(thin, *OPACITY))
            axes.set_title(f"{title}, t = {time:.{digits}f} s", parse_math=False)
            canvas.draw()
            figure.set_layout_engine("none")  # the same place for all pictures
            picture = np.asarray(canvas.buffer_rgba())[..., :3]
            # H.264 wants even sides
            show(picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2].copy())
            if progress:
                progress(done, len(times))
    return Path(output)


def _draw_ground(axes, run, lower, upper):
    if run.terrain is not None and run.terrain.facets.shape[1] == 3:
        draw_terrain(axes, run, lower, upper)
