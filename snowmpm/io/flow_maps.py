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
        rows, columns = raster.values.shape
        plan = np.asarray(frame.points, float)[:, :2]
        column = np.floor((plan[:, 0] - raster.x0) / raster.cell + 0.5)
        row = np.floor((plan[:, 1] - raster.y0) / raster.cell + 0.5)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        cell = (row * columns + column)[inside].astype(np.int64)
        velocity = np.asarray(frame.fields["velocity"], float)[inside]
        speed = np.linalg.norm(velocity, axis=1)
        own = np.asarray(frame.fields.get("depth", 0.0), float).ravel()

        def total(weights=None):
            return np.bincount(cell, weights, minlength=rows * columns)

        if own.any():
            weight = (own / self._upright(plan))[inside]
            depth = total(weight) / np.maximum(total(), 1)
        else:
            weight = first_volumes(self._run, frame)[inside]
            depth = total(weight) / raster.cell**2
        held = np.maximum(total(weight), 1e-300)
        means = (total(weight * one) / held for one in (speed, velocity[:, 0], velocity[:, 1]))
        return tuple(one.reshape(rows, columns) for one in (depth, *means))

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
