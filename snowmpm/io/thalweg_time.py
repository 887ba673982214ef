"""Depth and speed of a run along its thalweg over time, from its frames.

Every place in plan belongs to the s of the nearest point of the thalweg (`snowmpm.results.hazard`); the value there is
the largest across it, as in the thalweg-time diagrams of AvaFrame and of avalanche radars (Fischer, Fromm, Gauer and
Sovilla 2014, doi:10.1016/j.coldregions.2014.01.004).

    columns     their own depth, and speed
    particles   depth: volume over a map cell by its area; speed: mean over the volume in it
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.flow_maps import first_volumes

LEAST_DEPTH = 0.01
"""Depth [m] below which nothing counts as flow in runs without a flow depth of their own."""

MOST_CELLS = 10_000_000
"""Cells of a box around the snow that are counted one by one."""


@dataclass(frozen=True)
class ThalwegTime:
    """s (k,) [m] along the thalweg in plan; time (t,) [s]; depth [m] and speed [m/s] (t, k), NaN where no snow flows or
    lies; front (t,): furthest s that is at least `flow_depth` [m] deep, NaN before there is any."""

    s: np.ndarray
    time: np.ndarray
    depth: np.ndarray
    speed: np.ndarray
    front: np.ndarray
    flow_depth: float

    @classmethod
    def of(cls, run):
        """Of a `snowmpm.io.Run`. InputError: a run without a thalweg, or without velocities in its frames."""
        profile = run.hazard.get("profile") or {}
        if not profile.get("x"):
            raise InputError(f"{run.path}: no thalweg: the run is two-dimensional, not yet at its end, or nothing"
                             " moved")
        if "velocity" not in run.field_names:
            raise InputError(f"{run.path}: frames hold no velocity: run the scene with velocity in output.fields")
        points, s = np.column_stack([profile["x"], profile["y"]]), np.array(profile["s"], float)
        flow_depth = run.hazard["numbers"].get("flow_depth") or LEAST_DEPTH
        depth, speed = np.full((2, len(run), len(s)), np.nan)
        fields = [name for name in ("velocity", "depth", "volume", "J") if name in run.field_names]
        for i in range(len(run)):
            depth[i], speed[i] = _across(run, run.frame(i, fields), points, flow_depth)
        reached = np.where(np.nan_to_num(depth) >= flow_depth, s, -np.inf).max(axis=1)
        return cls(s, np.asarray(run.times, float), depth, speed, np.where(np.isfinite(reached), reached, np.nan),
                   flow_depth)

    @property
    def front_speed(self):
        """Largest speed of the front between frames [m/s], 0 where there is none."""
        known = np.isfinite(self.front)
        if known.sum() < 2:
            return 0.0
        return float(max(0.0, (np.diff(self.front[known]) / np.diff(self.time[known])).max()))


def _across(run, frame, points, flow_depth):
    """Largest depth and speed at each point of the thalweg (k,) each, NaN where there is no snow."""
    from scipy.spatial import cKDTree

    plan = np.asarray(frame.points, float)[:, :2] + run.origin[:2]
    speed = np.linalg.norm(np.asarray(frame.fields["velocity"], float), axis=1)
    depth = np.asarray(frame.fields["depth"], float).ravel() if "depth" in frame.fields else np.zeros(len(plan))
    if not depth.any() and len(plan):
        plan, depth, speed = _over_cells(run, frame, plan, speed)
    found = np.full((2, len(points)), -np.inf)
    if len(plan):
        station = cKDTree(points).query(plan)[1]
        np.maximum.at(found[0], station, depth)
        deep = depth >= flow_depth
        np.maximum.at(found[1], station[deep], speed[deep])
    return np.where(np.isfinite(found), found, np.nan)


def _over_cells(run, frame, plan, speed):
    """Middles (m, 2) of the map cells with particles, depth and mean speed over them."""
    cell = run.maps["peak_depth"].cell
    volume = first_volumes(run, frame)
    cells = np.floor(plan / cell).astype(np.int64)
    first, last = cells.min(axis=0), cells.max(axis=0)
    columns, rows = (int(b) - int(a) + 1 for a, b in zip(first, last, strict=True))
    if columns * rows < MOST_CELLS:
        where = (cells[:, 0] - first[0]) * rows + cells[:, 1] - first[1]
        there = np.flatnonzero(np.bincount(where))
        number = first + np.column_stack(np.divmod(there, rows))
    else:  # one of them is far away
        number, where = np.unique(cells, axis=0, return_inverse=True)
        where, there = where.reshape(-1), slice(None)
    held, moved = (np.bincount(where, weights)[there] for weights in (volume, volume * speed))
    return (number + 0.5) * cell, held / cell**2, moved / held
