"""Pressure of the snow over the face of an obstacle, panel by panel and in time, as a run file holds it.

Rows of panels go up, columns to the left as seen along the direction of the push; in 2-D there is one column, of a
metre of width. A pressure is a mean over the panel and over the time since the row before, positive where the snow
pushes along the direction: peaks of shorter times and smaller places are higher.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.errors import InputError

SERIES = "face_pressure"
"""Kind of record (`snowmpm.io.series`)."""
FARTHEST = 1e9
"""Largest coordinate [m]."""
HEAD = ("obstacle", "row", "column", "x_m", "y_m", "z_m", "width_m", "height_m", "peak_pressure_Pa", "peak_time_s",
        "impulse_Pa_s", "pressure_at_peak_force_Pa")


@dataclass(frozen=True)
class Panels:
    """direction, up: unit vectors (dim,), across too, None in 2-D; front: of the face along direction [m]; first:
    corner of the face along across and up [m]; edges: of a panel along them [m]; interval: that was asked for [s].
    time (k,) [s]: ends of the means; pressure (k, rows, columns) [Pa]; force_beside (k,) [N], 2-D [N/m]: along the
    direction, on the rest of the obstacle. Coordinates are those of the scene."""

    name: str
    direction: Floats
    up: Floats
    across: Floats | None
    front: float
    first: Floats
    edges: Floats
    interval: float
    time: Floats
    pressure: Floats
    force_beside: Floats

    @cached_property
    def spans(self) -> Floats:
        """Time over which each row is a mean (k,) [s]."""
        return np.diff(np.concatenate([[0.0], self.time]))

    @property
    def area(self) -> float:
        """Of a panel [m2]."""
        return float(np.prod(self.edges))

    @property
    def force(self) -> Floats:
        """On the face, along the direction (k,) [N], 2-D [N/m]."""
        return self.pressure.sum(axis=(1, 2)) * self.area

    @property
    def peak(self) -> Floats:
        """Largest pressure of each panel (rows, columns) [Pa]."""
        return self.pressure.max(axis=0)

    @property
    def impulse(self) -> Floats:
        """Impulse of each panel over its area (rows, columns) [Pa s]."""
        return np.tensordot(self.spans, self.pressure, 1)

    def middles(self, k: int) -> Floats:
        """Middles of the panels along across (k = 0) or up (k = 1), from the corner of the face [m]."""
        return (np.arange(self.pressure.shape[2 - k]) + 0.5) * self.edges[k]

    def centres(self) -> Floats:
        """Middles of the panels on the plane of the foremost point of the obstacle, (rows, columns, dim) [m]."""
        up = self.first[1] + self.middles(1)
        found = self.front * self.direction + up[:, None, None] * self.up
        if self.across is None:
            return found
        return found + (self.first[0] + self.middles(0))[:, None] * self.across

    def row_at(self, time: float | None = None) -> int:
        """Of the mean that holds a time [s], by default of the greatest force. Raises InputError for a time that the
        record does not hold."""
        if time is None:
            return int(np.argmax(self.force))
        if not 0.0 <= time <= self.time[-1]:
            raise InputError(f"time = {time:g}: must be from 0 to {self.time[-1]:g}, the end of the record on"
                             f" {self.name}")
        return int(np.searchsorted(self.time, time))


def has_panels(run: Any) -> bool:
    """Whether a `Run` holds rows of panels."""
    return any(len(series.time) for series in run.series.get(SERIES, {}).values())


def panels_of(run: Any) -> dict[str, Panels]:
    """`Panels` of a `Run` by obstacle; those that have no row yet are left out. Raises InputError for a run without
    panels, or a file whose tables do not fit."""
    found = {}
    for name, series in run.series.get(SERIES, {}).items():
        about, where = series.about, f"{run.path}: panels of {name}"
        try:
            axes = [None if about[key] is None else np.array(about[key], float)
                    for key in ("direction", "up", "across")]
            first, edges = np.array(about["first"], float), np.array(about["edges"], float)
            front, interval = float(about["front"]), float(about["interval"])
            pressure, beside = series.columns["pressure"], series.columns["force_beside"]
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{where}: not readable") from None
        fits = (pressure.ndim == 3 and pressure.size > 0 and beside.ndim == 1 and first.shape == edges.shape == (2,)
                and axes[0] is not None and axes[1] is not None and (axes[2] is None) == (run.dimension == 2)
                and all(axis is None or (axis.shape == (run.dimension,) and abs(np.linalg.norm(axis) - 1.0) < 1e-6)
                        for axis in axes)
                and np.abs([*first, *edges, front]).max() < FARTHEST and (edges > 0.0).all()
                and np.isfinite(pressure).all() and np.isfinite(beside).all())
        if len(series.time) and not fits:
            raise InputError(f"{where}: its tables do not fit each other")
        if len(series.time):
            direction, up, across = axes
            found[name] = Panels(name, direction, up, across, front, first, edges, interval, series.time,
                                 np.asarray(pressure, float), beside)
    if not found:
        raise InputError(f"{run.path}: no pressure panels: give an obstacle of the scene a table panels")
    return found


def panel_rows(run: Any) -> list[list[Any]]:
    """A row a panel, as HEAD says."""
    rows = []
    for name, one in panels_of(run).items():
        centres, peak, impulse = one.centres(), one.peak, one.impulse
        times, at_peak = one.time[one.pressure.argmax(axis=0)], one.pressure[one.row_at()]
        for i, j in np.ndindex(peak.shape):
            place = centres[i, j] if run.dimension == 3 else (centres[i, j, 0], 0.0, centres[i, j, 1])
            rows.append([name, i, j, *map(float, place), *map(float, one.edges), float(peak[i, j]), float(times[i, j]),
                         float(impulse[i, j]), float(at_peak[i, j])])
    return rows
