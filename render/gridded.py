"""Fields of a frame on a regular grid of `pyvista.ImageData`, for slices, arrows, streamlines, values along lines."""

from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.colour import scalar
from snowmpm.render.view import particle_spacing, piled

CELLS = 2.0
"""Side of a cell in particle spacings: eight particles in a full one."""

MOST = 4_000_000
"""Cells at most; of a larger box, they are larger."""

COUNT = "particles"
"""Data of the cells: how many particles lie in each. Cells without any hold NaN."""


def gridded(run: Any, i: int, names: list[str]) -> Any:
    """`pyvista.ImageData` of frame `i` of a run in 3-D, with the mean of each field in each cell as cell data, vectors
    as they are, and COUNT.

    Lengths [m] from the run's origin. Raises InputError for a field that the run does not have, a frame without
    particles and a run in two dimensions.
    """
    import pyvista as pv

    if run.dimension != 3:
        raise InputError(f"{run.path}: slices, arrows, streamlines and lines are of runs in three dimensions")
    for name in names:
        if name not in run.field_names:
            raise InputError.not_in("color", name, run.field_names, file=run.path)
    in_plan = "depth" in run.field_names
    frame = run.frame(i, dict.fromkeys([*names, *(["depth"] if in_plan else [])]))
    good = np.isfinite(frame.points).all(axis=1)
    if not good.any():
        raise InputError(f"{run.path}: no particles at {frame.time:g} s")
    points, values = frame.points[good].astype(float), [frame.fields[name][good] for name in names]
    spacing = particle_spacing(run, frame.time)
    if in_plan:
        points, *values = piled(points, frame.fields["depth"][good].ravel(), spacing, *values)
    # Particles of a lattice then lie within cells, not on their borders
    low = points.min(axis=0) - 0.5 * spacing
    extent = points.max(axis=0) - low
    side = CELLS * spacing
    while np.prod(np.floor(extent / side) + 1.0) > MOST:
        side *= 1.25
    shape = (np.floor(extent / side) + 1.0).astype(int)
    cell = np.minimum(((points - low) / side).astype(int), shape - 1)
    number = np.ravel_multi_index(tuple(cell.T), shape, order="F")
    counts = np.bincount(number, minlength=int(np.prod(shape)))
    grid = pv.ImageData(dimensions=shape + 1, spacing=(side,) * 3, origin=low)
    grid.cell_data[COUNT] = counts
    for name, value in zip(names, values, strict=True):
        columns = value.reshape(len(points), -1)
        sums = np.stack([np.bincount(number, column, len(counts)) for column in columns.T], axis=1)
        mean = (sums / np.where(counts, counts, np.nan)[:, None]).astype(np.float32)
        grid.cell_data[name] = mean if value.ndim == 2 else mean[:, 0]
    return grid


def numbers_of(values):
    """One number a cell of a field (n,) or (n, k), NaN where it has none: itself, a length, a pressure."""
    return scalar(np.asarray(values))


def along_line(run, i, name, begin, end, count=200):
    """(distance (k,) [m], values (k,)) of a field of frame `i` along the line from `begin` to `end` (3,) [m] from the
    run's origin, NaN outside of the snow; the mean of the cell that each place lies in."""
    import pyvista as pv

    grid = gridded(run, i, [name])
    grid.cell_data["value"] = numbers_of(grid.cell_data[name])
    line = pv.Line(begin, end, resolution=count - 1)
    cells = grid.find_containing_cell(line.points)
    values = np.where(cells >= 0, np.asarray(grid.cell_data["value"])[cells], np.nan)
    return np.linalg.norm(line.points - np.asarray(begin), axis=1), values
