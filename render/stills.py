"""Stills of a run on one sheet: moments evenly over time, row by row."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from snowmpm.annotations import PathLike
from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.run_film import checked_size, nearest_frame, view_of

KINDS = (".jpg", ".png")
MOST = 36
QUALITY = 88  # of a JPEG
GAP = 4  # px of white between two stills


def render_stills(run: Run, output: PathLike, count: int = 6, *, size: tuple[int, int] = (1920, 1080),
                  begin: float | None = None, end: float | None = None,
                  progress: Callable[[int, int], object] | None = None, **choices: object) -> Path:
    """Draw `count` frames of a run, evenly from `begin` to `end` [s], to a .jpg or .png of `size`; -> its path.

    As many columns as rows, or one more. progress(done, total) as of `render_run`; choices: its color, camera, cutaway,
    ground, quality and inset. Raises InputError for another ending, more than MOST stills, times outside of the run,
    and as `render_run`.
    """
    path, size = Path(output), checked_size(size, even=False)
    if path.suffix.lower() not in KINDS:
        raise InputError.at("output", str(output), f"a sheet of stills ends in {' or '.join(KINDS)}")
    if not 1 <= count <= MOST:
        raise InputError.at("stills", count, f"must be from 1 to {MOST}")
    columns = int(np.ceil(np.sqrt(count)))
    rows = -(-count // columns)
    cell = tuple((side - GAP * (n - 1)) // n for side, n in zip(size, (columns, rows), strict=True))
    view = view_of(run, checked_size(cell, even=False), **choices)
    first, last = _span(run, begin, end)
    times = np.linspace(first, last, count)
    sheet = Image.new("RGB", (columns * (cell[0] + GAP) - GAP, rows * (cell[1] + GAP) - GAP), (255, 255, 255))
    for k, time in enumerate(times):
        if progress:
            progress(k, count)
        still = Image.fromarray(view.picture(nearest_frame(run, time)))
        sheet.paste(still, (k % columns * (cell[0] + GAP), k // columns * (cell[1] + GAP)))
    with draft(path) as part:
        sheet.save(part, "JPEG" if path.suffix.lower() == ".jpg" else "PNG", quality=QUALITY, optimize=True)
    return path


def _span(run, begin, end):
    last = float(run.times[-1])
    for key, value in (("from", begin), ("to", end)):
        if value is not None and not 0.0 <= value <= last * (1.0 + 1e-9):
            raise InputError.at(key, value, f"{run.path} goes from 0 to {last:g} s")
    begin, end = float(run.times[0]) if begin is None else begin, last if end is None else end
    if begin > end:
        raise InputError.at("from", begin, f"must be before to = {end:g}")
    return begin, end
