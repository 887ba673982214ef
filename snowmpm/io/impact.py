"""Impact on an obstacle: early peak and steady part of the force, and of the pressure on the wetted area.

    force = F . d,   pressure = force / wetted area

d: horizontal, in the direction of the total impulse; vertical if most of the impulse is vertical (a roof).
Arrival and end: when `ARRIVED` and 1 - `ARRIVED` of the impulse have been given. Peak: largest mean over a `WINDOW` of
the time between them; of a depth-averaged flow, whose load has no noise, the largest of the record. Steady: mean force
between the times at which a quarter and three quarters of the impulse have been given. Wetted area: the part of the
face that snow touches (`snowmpm.io.wetted`), from the frames, interpolated linearly; of columns that
over which they bear (`snowmpm.io.bearing`). The names of the numbers are defined in `snowmpm.quantities.table.IMPACT`.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.io.bearing import bearing_areas, bearing_depth
from snowmpm.io.wetted import Face
from snowmpm.quantities.quantity import written
from snowmpm.quantities.table import quantity

ARRIVED = 0.01
WINDOW = 0.02

MOST_FRAMES = 60
"""Largest number of frames used for the wetted area, spread over the time of the load."""


@dataclass(frozen=True)
class Impact:
    """direction (3,); numbers: by name, SI, per metre of width in 2-D, without the pressures where no frame shows snow
    on the face; time, wetted (k,): wetted area [m2] at frames; width: "/m" in 2-D."""

    direction: np.ndarray
    numbers: dict
    time: np.ndarray
    wetted: np.ndarray
    width: str = ""

    def units(self):
        """Unit of each number that is per metre of width."""
        forces = {name: f"N{' s' * (name == 'impact_impulse')}/m" for name in
                  ("impact_peak_force", "impact_steady_force", "impact_impulse")}
        return {**forces, "wetted_area": "m", "face_area": "m"} if self.width else {}

    def texts(self):
        """Numbers in words and units, by quantity name."""
        units = self.units()
        return {name: written(value, units.get(name, quantity(name).unit)) for name, value in self.numbers.items()}

    def wetted_at(self, time):
        """Wetted area [m2] at times [s]."""
        return np.interp(time, self.time, self.wetted) if len(self.time) else np.zeros_like(time)


def impacts(run):
    """`Impact` by name, for the loaded obstacles of a `Run`. Reads frames for their wetted areas."""
    in_plan = _in_plan(run)
    found = {name: loaded(obstacle, 0.0 if in_plan else WINDOW) for name, obstacle in run.obstacles.items()}
    found = {name: load for name, load in found.items() if load}
    spacing, dx = (float(run.provenance.get(name) or 0.0) for name in ("particle_spacing", "dx"))
    drawn = {name: one for name, one in run.obstacles.items()
             if name in found and len(one.vertices) and np.isfinite(one.vertices).all()}
    faces = {name: Face(one.vertices, one.facets, found[name].direction, spacing or np.inf)
             for name, one in drawn.items()}
    wet = {name: ([], []) for name in found}
    frames = {name: set(_frames(run.times, load)) for name, load in found.items()} if spacing > 0.0 else {}
    for i in sorted(set().union(*frames.values())):
        frame = run.frame(i, ["depth"] if in_plan else [])
        particles = frame.points
        for name in found:
            if i in frames[name] and name in faces and i < len(run.obstacles[name].rotation):
                obstacle, face = run.obstacles[name], faces[name]
                centres = face.centres @ obstacle.rotation[i].T + obstacle.translation[i]
                wet[name][0].append(float(run.times[i]))
                wet[name][1].append(bearing_depth(obstacle.placed(i), particles, frame.fields["depth"], dx) if in_plan
                                    else face.wet(centres, found[name].direction, particles, spacing))
    if in_plan:
        wet = {name: bearing_areas(run.obstacles[name], found[name].direction, *values) for name, values in wet.items()}
    return {name: _impact(load, faces.get(name), *map(np.array, wet[name]), run.dimension)
            for name, load in found.items()}


def _in_plan(run):
    """Whether the snow of a run is columns."""
    if "depth" not in run.field_names or not len(run.times):
        return False
    return bool((run.frame(0, ["depth"]).fields["depth"] > 0.0).any())


@dataclass(frozen=True)
class Load:
    """direction (3,); impulse along it [N s]; arrival, end, peak_time, window [s]; quarters: times (2,) [s] between
    which the steady part lies; peak, steady [N]."""

    direction: np.ndarray
    impulse: float
    arrival: float
    end: float
    peak: float
    peak_time: float
    window: float
    steady: float
    quarters: tuple


def loaded(obstacle, share=WINDOW):
    """The `Load` on an obstacle of a run (`snowmpm.io.Obstacle`); None if it was never loaded. share: of its time that
    the peak is a mean over, at least from one row of the record to the next."""
    if not len(obstacle.time):
        return None
    total = obstacle.impulse[-1].copy()
    total[[2] if np.hypot(*total[:2]) >= abs(total[2]) else [0, 1]] = 0.0
    size = float(np.linalg.norm(total))
    if size == 0.0:
        return None
    direction = total / size
    time = np.concatenate([[0.0], obstacle.time])
    given = np.maximum.accumulate(np.concatenate([[0.0], obstacle.impulse @ direction]))
    start, quarter, most, end = np.interp(np.array([ARRIVED, 0.25, 0.75, 1.0 - ARRIVED]) * size, given, time)
    window = max(share * (end - start), float(np.diff(time).min()))
    force = (np.interp(time + window, time, given) - given) / window
    first = int(np.argmax(force))
    steady = 0.5 * size / max(most - quarter, window)
    return Load(direction, size, float(start), float(end), float(force[first]), float(time[first]), float(window),
                float(steady), (float(quarter), float(most)))


def _frames(times, load):
    """Numbers of the frames that show the load: those while it acts, one before, one after; spread evenly, with the
    two beside the peak."""
    if not len(times):
        return []
    first, last = np.searchsorted(times, load.arrival) - 1, np.searchsorted(times, load.end)
    first, last = max(int(first), 0), min(int(last), len(times) - 1)
    chosen = np.unique(np.linspace(first, last, min(MOST_FRAMES, last - first + 1)).round().astype(int))
    peak = int(np.searchsorted(times, load.peak_time))
    return sorted({*chosen.tolist(), *(i for i in (peak - 1, peak) if first <= i <= last)})


def _impact(load, face, time, wetted, dimension):
    numbers = {"impact_arrival": load.arrival, "impact_peak_force": load.peak, "impact_peak_time": load.peak_time,
               "impact_steady_force": load.steady, "impact_impulse": load.impulse}
    if face is not None:
        numbers["face_area"] = face.area
    if len(wetted) and wetted.max() > 0.0:
        numbers["wetted_area"] = float(wetted.max())
        # A load that comes and goes between two frames: use the largest wetted area
        at_peak = float(np.interp(load.peak_time + 0.5 * load.window, time, wetted)) or float(wetted.max())
        span = np.linspace(*load.quarters, 101)
        steady = float(np.interp(span, time, wetted).mean()) or float(wetted.max())
        numbers["impact_peak_pressure"] = load.peak / at_peak
        numbers["impact_steady_pressure"] = load.steady / steady
    return Impact(load.direction, numbers, time, wetted, "/m" if dimension == 2 else "")
