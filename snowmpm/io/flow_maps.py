"""Depth and speed of the snow in plan at a time of a run, from its frame, in the cells of its maps.

    particles   depth: volume at the density of the start over a cell by its area; speed: mean over the volume in it
    columns     means over the columns in a cell: of their depth, made vertical by the slope of the ground, and of speed

Particles of a run without the fields volume and J count as equally large, so that a cell differs from the maps that the
run made of itself: by 3 % of the depth (root mean square) on avalanche_on_raster, by 8 to 13 % with columns.
"""

from functools import cached_property

import numpy as np

from snowmpm.errors import InputError

NAMES = ("momentary_depth", "momentary_speed")
MOST = 40
"""Times of a run that are drawn or written at most."""

LEAST_INTERVAL = 2.0
"""Seconds about which two of them are apart at least: QGIS keeps whole seconds, and rounding must not join them."""


def first_volumes(run, frame):
    """Volume [m3] of each particle (n,) at the density of the start."""
    if {"volume", "J"} <= frame.fields.keys():
        return np.asarray(frame.fields["volume"] / frame.fields["J"], float).ravel()
    return np.full(len(frame), run.provenance["particle_spacing"] ** 3)


def moments(run, most=MOST):
    """[(number of the frame, its time [s], until [s])] of about evenly spaced frames of a run, the first and the last
    among them, about `LEAST_INTERVAL` apart or more. A moment lasts until the next one; the last, as the one before.

    Raises InputError for a run without maps, velocities, or a second frame.
    """
    if "peak_depth" not in run.maps or "velocity" not in run.field_names or len(run) < 2:
        raise InputError(f"{run.path}: no maps over time: they need the maps of a run in three dimensions, made at its"
                         " end, and frames with velocity")
    times = np.asarray(run.times, float)
    span = times[-1] - times[0]
    count = int(np.clip(np.floor(span / LEAST_INTERVAL) + 1, 2, min(most, len(times))))
    wanted = np.linspace(times[0], times[-1], count)
    chosen = np.unique([int(np.abs(times - time).argmin()) for time in wanted])
    until = np.append(times[chosen[1:]], 2.0 * times[chosen[-1]] - times[chosen[-2]])
    return [(int(i), float(times[i]), float(end)) for i, end in zip(chosen, until, strict=True)]


class FlowMaps:
    """The maps of the frames of a `Run` by NAMES, in the cells of its map peak_depth (rows, columns)."""

    def __init__(self, run):
        self._run, self._raster = run, run.maps["peak_depth"]
        self.limit = run.hazard.get("numbers", {}).get("flow_depth") or 0.0

    def at(self, i):
        """Values of frame `i`: depth [m], NaN where no snow is, and speed [m/s], NaN where it is thinner than the flow
        depth of the run."""
        depth, speed, *_ = self.flow(i)
        there = depth > 0.0
        found = np.where(there, depth, np.nan), np.where(there & (depth >= self.limit), speed, np.nan)
        return dict(zip(NAMES, found, strict=True))

    def flow(self, i):
        """Depth [m], speed, and velocity to the east and to the north [m/s] in frame `i`; 0 where no snow is."""
        raster, frame = self._raster, self._run.frame(i)
        plan = np.asarray(frame.points, float)[:, :2]
        own = np.asarray(frame.fields.get("depth", 0.0), float).ravel()
        wide = float(self._run.provenance.get("dx") or 0.0)
        if own.any() and wide > 1.01 * raster.cell:  # each row stands for several map cells
            return self._spread(*self._binned(frame, plan, own, plan[0] - 0.5 * wide, wide), plan[0], wide)
        return self._binned(frame, plan, own, np.array([raster.x0, raster.y0]) - 0.5 * raster.cell, raster.cell,
                            raster.values.shape)[0]

    def _spread(self, found, first, place, wide):
        """Arrays `found` in cells of side `wide` [m], of which the one at `place` (2,) has the numbers -first (2,), in
        the cells of the maps."""
        raster = self._raster
        row, column = np.indices(raster.values.shape)
        at = np.stack([raster.x0 + raster.cell * column, raster.y0 + raster.cell * row], axis=-1)
        column, row = np.moveaxis(np.floor((at - place) / wide + 0.5).astype(int) - first, -1, 0)
        rows, columns = found[0].shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return tuple(np.where(inside, one[row.clip(0, rows - 1), column.clip(0, columns - 1)], 0.0) for one in found)

    def _binned(self, frame, plan, own, low, side, shape=None):
        """Those of `flow` in cells of this side [m] from the corner low (2,), and the number (2,) of the first cell;
        shape (rows, columns), around all of the snow when missing."""
        column, row = np.floor((plan - low) / side).astype(np.int64).T
        first = np.zeros(2, np.int64) if shape else np.array([column.min(), row.min()])
        column, row = column - first[0], row - first[1]
        rows, columns = shape or (int(row.max()) + 1, int(column.max()) + 1)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        cell = (row * columns + column)[inside]
        velocity = np.asarray(frame.fields["velocity"], float)[inside]
        speed = np.linalg.norm(velocity, axis=1)

        def total(weights=None):
            return np.bincount(cell, weights, minlength=rows * columns)

        if own.any():
            weight = (own / self._upright(plan))[inside]
            depth = total(weight) / np.maximum(total(), 1)
        else:
            weight = first_volumes(self._run, frame)[inside]
            depth = total(weight) / side**2
        held = np.maximum(total(weight), 1e-300)
        means = (total(weight * one) / held for one in (speed, velocity[:, 0], velocity[:, 1]))
        return tuple(one.reshape(rows, columns) for one in (depth, *means)), first

    def _upright(self, plan):
        """Cosine (n,) of the slope of the ground under places (n, 2): of the nearest facet."""
        tree, cosines = self._facets
        return cosines[tree.query(plan)[1]]

    @cached_property
    def _facets(self):
        from scipy.spatial import cKDTree

        ground = self._run.terrain
        corners = ground.vertices[ground.facets].astype(float)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        wide = np.abs(normal[:, 2]) > 1e-12
        cosines = np.abs(normal[wide, 2]) / np.linalg.norm(normal[wide], axis=1)
        return cKDTree(corners[wide].mean(axis=1)[:, :2]), cosines
