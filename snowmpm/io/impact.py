"""What hits an obstacle: early peak and steady part of its load.

    pressure = F . n / A,   A: area of the obstacle seen along n

n: horizontal, in the direction of the whole impulse; straight down or up where most of the impulse is (a roof).
A load cell that the flow covers reads the pressure; of an obstacle that stands out of the flow it is a mean over all of
its front. Arrival and end: when `ARRIVED` and 1 - `ARRIVED` of the impulse have been given. Peak: largest mean over a
`WINDOW` of the time between them. Steady: mean force between the times at which a quarter and three quarters of the
impulse have been given.
"""

from dataclasses import dataclass

import numpy as np

ARRIVED = 0.01
WINDOW = 0.02


@dataclass(frozen=True)
class Impact:
    """direction (3,), area [m2], impulse along the direction [N s]; arrival, peak_time [s]; peak, steady: pressures
    [Pa]. In 2-D area [m] and impulse are per metre of width."""

    direction: np.ndarray
    area: float
    impulse: float
    arrival: float
    peak: float
    peak_time: float
    steady: float


def impact(obstacle):
    """The `Impact` on an obstacle of a run (`snowmpm.io.Obstacle`); None when nothing has pressed on it."""
    if not len(obstacle.time):
        return None
    total = obstacle.impulse[-1].copy()
    total[[2] if np.hypot(*total[:2]) >= abs(total[2]) else [0, 1]] = 0.0
    size = float(np.linalg.norm(total))
    if size == 0.0:
        return None
    direction = total / size
    area = frontal_area(obstacle.vertices, obstacle.facets, direction)
    time = np.concatenate([[0.0], obstacle.time])
    given = np.maximum.accumulate(np.concatenate([[0.0], obstacle.impulse @ direction]))
    start, quarter, most, end = np.interp(np.array([ARRIVED, 0.25, 0.75, 1.0 - ARRIVED]) * size, given, time)
    window = max(WINDOW * (end - start), float(np.diff(time).min()))
    force = (np.interp(time + window, time, given) - given) / window
    first = int(np.argmax(force))
    steady = 0.5 * size / max(most - quarter, window)
    return Impact(direction, area, size, float(start), float(force[first]) / area, float(time[first]), steady / area)


def frontal_area(vertices, facets, direction):
    """Area [m2] of a convex body seen along `direction` (3,), from its facets: half of the sum of |n . d| over the
    triangles (m, 3); over the segments (m, 2) of a section in the plane (x, z), per metre of width."""
    corner = vertices[facets]
    if facets.shape[1] == 3:
        areas = 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    else:
        along = corner[:, 1] - corner[:, 0]
        areas = np.column_stack([-along[:, 2], np.zeros(len(along)), along[:, 0]])
    return 0.5 * float(np.abs(areas @ direction).sum())
