"""A field of the snow along a line, as a curve and as a table."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.draft import write_table
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.colour import WORDS
from snowmpm.render.figure import check_ending, plain, save, titled
from snowmpm.render.gridded import along_line
from snowmpm.render.run_film import nearest_frame


def render_line(run: Run, output: PathLike, begin: Sequence[float], end: Sequence[float], *, field: str = "velocity",
                time: float | None = None) -> list[Path]:
    """Draw a field of a run in 3-D along the line from `begin` to `end` (3,) [m], in the scene's coordinates, at the
    frame nearest to a time [s], by default the last; beside it a table of the same name, .csv: distance [m] and value,
    empty where there is no snow. Returns both paths.

    Values are means over cells of two particle spacings; a vector is its length, a tensor its pressure. Raises
    InputError for a run in two dimensions, an unknown field, and a line without length.
    """
    check_ending(output)
    first, last = np.asarray(begin, float), np.asarray(end, float)
    if first.shape != (3,) or last.shape != (3,) or not np.isfinite([first, last]).all() or np.allclose(first, last):
        raise InputError("--line: must be two places x,y,z apart from each other")
    i = len(run) - 1 if time is None else nearest_frame(run, time)
    distance, values = along_line(run, i, field, first - run.origin, last - run.origin)
    if not np.isfinite(values).any():
        raise InputError(f"--line: no snow along it at {run.times[i]:g} s")
    unit = run.units.get(field, "")
    label = WORDS.get(field, field.replace("_", " ")) + (f" [{unit}]" if unit not in ("", "1") else "")
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(distance, values, color="C0")
    titled(axes, f"{run.name.replace('_', ' ')}, {run.times[i]:g} s", "distance along the line [m]", label)
    plain(axes)
    path = save(figure, output, 130)
    rows = [[f"{s:.6g}", "" if np.isnan(value) else f"{value:.6g}"] for s, value in zip(distance, values, strict=True)]
    return [path, write_table(path.with_suffix(".csv"), ["distance_m", field], rows)]
