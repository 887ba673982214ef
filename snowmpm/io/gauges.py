"""What flows past lines and points of a run: depth, speed, pressure, discharge over time, and the volume that passed.

With the vertical depth H, the velocity in plan w and the normal n of a line,

    discharge = integral of H w.n along the line [m3/s],   volume = integral of the discharge over time [m3]

Volume, what was largest, arrival and duration come from the maps of the run, which it keeps up between its frames; of
the volume these are the time integrals of H w, linear between the middles of map cells. Depth, speed, pressure and
discharge over time come from the frames, in the cells of the maps (`io.flow_maps`), and change linearly between them:
`gauge_frames`, the volume by the frames alone, says how well they resolve the passage.

A point is the map cell that it lies in; of a line those count that it runs through.
"""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.flow_maps import FlowMaps
from snowmpm.stages import counted

PER_CELL = 2.0
"""Points of a line in a map cell."""
MOST_POINTS = 200_000
"""Of all lines together."""
PEAKS = {"gauge_depth": "peak_depth", "gauge_speed": "peak_speed", "gauge_pressure": "peak_pressure",
         "gauge_momentum": "peak_momentum"}
"""Number of a gauge: map whose largest value on it that is."""
SERIES = ("depth", "speed", "pressure", "discharge", "volume")
PROFILE = ("peak_depth", "peak_speed", "peak_pressure", "peak_momentum", "arrival_time", "flow_duration")


@dataclass(frozen=True)
class Place:
    """name; corners (n, 2) of a line, or one point (1, 2), in map coordinates [m]."""

    name: str
    corners: np.ndarray

    @property
    def is_line(self):
        """Whether it is a line."""
        return len(self.corners) > 1


@dataclass(frozen=True)
class Gauge:
    """A `Place` with what a run did there. numbers: by name, as `snowmpm.quantities.table.GAUGES` defines them, None
    for what did not happen; series: arrays over time, `time` [s] and SERIES (of a point without discharge and volume);
    profile: arrays along a line, `s`, x, y [m] and PROFILE."""

    place: Place
    numbers: dict
    series: dict
    profile: dict


class _Points:
    """Points along a `Place`: places (k, 2) in map coordinates, s (k,) along it, steps (k,) [m], normals (k, 2), to the
    right of the line."""

    def __init__(self, place, cell):
        if not place.is_line:
            self.places, self.s, self.steps, self.normals = place.corners, np.zeros(1), np.zeros(1), np.zeros((1, 2))
            return
        a, b = place.corners[:-1], place.corners[1:]
        lengths = np.linalg.norm(b - a, axis=1)
        counts = np.maximum(1, np.ceil(PER_CELL * lengths / cell)).astype(int)
        part = np.repeat(np.arange(len(a)), counts)
        share = (np.concatenate([np.arange(n) for n in counts]) + 0.5) / counts[part]
        self.places = a[part] + share[:, None] * (b - a)[part]
        self.steps = (lengths / counts)[part]
        self.s = np.cumsum(self.steps) - 0.5 * self.steps
        along = (b - a) / np.maximum(lengths, 1e-12)[:, None]
        self.normals = np.column_stack([along[:, 1], -along[:, 0]])[part]


def gauges(run, places, where="--gauges"):
    """[`Gauge`] of a `Run` at `Place`s; where: they come from, for messages. Raises InputError for a run without maps
    or velocities, for a place that lies beside its maps, and for too many points."""
    if "peak_depth" not in run.maps or "velocity" not in run.field_names:
        raise InputError(f"{run.path}: no gauges: they need the maps of a run in three dimensions, made at its end, and"
                         " frames with velocity")
    if run.passed is None:
        raise InputError(f"{run.path}: no gauges: its maps were made by an older version; run the scene again")
    raster = run.maps["peak_depth"]
    _require_few(places, raster.cell, where)
    points = [_Points(one, raster.cell) for one in places]
    for place, one in zip(places, points, strict=True):
        if not raster.holds(one.places - run.origin[:2]).any():
            raise InputError(f"{where}: {place.name!r} lies beside the maps of {run.path}: is its coordinate system"
                             " right?")
    found, times = FlowMaps(run), np.asarray(run.times, float)
    density = _density(run)
    rows = [np.zeros((len(times), 4)) for _ in places]
    for i in counted(range(len(times)), "reading frames", "frames"):
        depth, speed, east, north = found.flow(i)
        deep = np.where(depth >= found.limit, speed, 0.0)
        for one, row in zip(points, rows, strict=True):
            plan = one.places - run.origin[:2]
            here, fast = (replace(raster, values=values).nearest(plan) for values in (depth, deep))
            u, v = (replace(raster, values=depth * values).between(plan) for values in (east, north))
            row[i] = (np.nanmax(here, initial=0.0), np.nanmax(fast, initial=0.0),
                      density * np.nanmax(fast, initial=0.0) ** 2,
                      (one.steps * (u * one.normals[:, 0] + v * one.normals[:, 1])).sum())
    return [_gauge(run, place, one, times, row) for place, one, row in zip(places, points, rows, strict=True)]


def _require_few(places, cell, where):
    """Raises InputError for more than MOST_POINTS points on lines, before they are made."""
    count = sum(len(one.corners) + PER_CELL * float(np.linalg.norm(np.diff(one.corners, axis=0), axis=1).sum()) / cell
                for one in places)
    if not count <= MOST_POINTS:
        raise InputError(f"{where}: lines with {count:.3g} points on maps with cells of {cell:g} m: at most"
                         f" {MOST_POINTS:g}; take shorter lines, with fewer corners")


def _density(run):
    """Density of the snow at the start [kg/m3]: the mean over the release."""
    numbers = run.hazard.get("numbers", {})
    volume = numbers.get("release_volume") or 0.0
    return numbers.get("release_mass", 0.0) / volume if volume > 0.0 else 0.0


def _gauge(run, place, points, times, rows):
    series = {"time": times, "depth": rows[:, 0], "speed": rows[:, 1], "pressure": rows[:, 2]}
    plan = points.places - run.origin[:2]
    profile = {"s": points.s, "x": points.places[:, 0], "y": points.places[:, 1],
               **{name: run.maps[name].nearest(plan) for name in PROFILE if name in run.maps}}
    numbers = {number: float(np.nanmax(profile[name], initial=0.0)) for number, name in PEAKS.items()
               if name in profile}
    arrival = profile.get("arrival_time", np.full(1, np.nan))
    reached = np.isfinite(arrival)
    numbers |= {"gauge_arrival": float(arrival[reached].min()) if reached.any() else None, "gauge_duration": None}
    if reached.any() and "flow_duration" in profile:
        until = arrival[reached] + profile["flow_duration"][reached]
        numbers["gauge_duration"] = float(until.max() - numbers["gauge_arrival"])
    if place.is_line:
        through = np.stack([one.between(plan) for one in run.passed], axis=1)
        passed = points.steps * (through * points.normals).sum(axis=1)
        side = -1.0 if passed.sum() < 0.0 else 1.0
        series |= {"discharge": side * rows[:, 3], "volume": _integral(times, side * rows[:, 3])}
        numbers |= {"gauge_discharge": float(max(0.0, series["discharge"].max())),
                    "gauge_volume": side * float(passed.sum()), "gauge_both_ways": float(np.abs(passed).sum()),
                    "gauge_frames": float(series["volume"][-1])}
    return Gauge(place, numbers, series, profile if place.is_line else {})


def _integral(times, values):
    """Integral over time up to each time, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum(0.5 * np.diff(times) * (values[1:] + values[:-1]))])
