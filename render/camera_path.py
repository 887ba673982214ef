"""A camera that moves through a film: along a path of one's own, round the action, or with it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d

from snowmpm.errors import InputError
from snowmpm.reading.number_table import read_number_table
from snowmpm.render.camera import FIELD_OF_VIEW, fit_camera, look_at
from snowmpm.render.framing import bearing_and_elevation, moving_samples

MOVING = ("orbit", "follow")
"""Names of cameras that move by themselves."""

ORBIT = np.radians(70.0)
"""Way of an orbit from the start to the end of a run, half of it to each side of the usual view."""

KEYS = 33
"""Places of the eye on the way of an orbit."""

STEADY = 1.5
"""Width of the Gaussian over the samples of a run with which a camera follows."""

WIDEST = 0.35
"""Least distance of a camera that follows, over that of the one that shows the whole run: near enough for clods, far
enough for what surrounds them."""

AROUND = (0.18, 0.18, 0.22, 0.18)
"""Share of the picture that stays free on each side of what is followed."""

COLUMNS = ("eye_x", "eye_y", "eye_z", "target_x", "target_y", "target_z")
ANGLE = "field_of_view"


@dataclass(frozen=True)
class CameraPath:
    """Where the eye is and what it looks at, over time.

    times (k,) [s], rising; eyes, targets (k, 3) [m], relative to the origin of the run; angles (k,): field of view of
    the longer side [rad]. In between they follow cubic Hermite splines that do not overshoot (Fritsch and Carlson 1980,
    doi:10.1137/0717021); before and after, they stay.
    """

    times: np.ndarray
    eyes: np.ndarray
    targets: np.ndarray
    angles: np.ndarray

    @cached_property
    def _splines(self):
        from scipy.interpolate import PchipInterpolator  # slow to import, and few cameras move

        return [PchipInterpolator(self.times, values) for values in (self.eyes, self.targets, self.angles)]

    def camera(self, time, size):
        """The view (`Camera`) of `size` pixels at a time [s]."""
        at = float(np.clip(time, self.times[0], self.times[-1]))
        eye, target, angle = (spline(at) for spline in self._splines)
        return look_at(eye, target, float(angle), size)

    @classmethod
    def read(cls, path, origin):
        """A path from a CSV file: columns time [s], eye_x, eye_y, eye_z, target_x, target_y, target_z [m] in the
        scene's coordinates and, if wanted, field_of_view [deg]; origin (3,) of the run [m].

        Raises InputError for a table that is none, times that do not rise, an eye that is its own target, and angles
        outside 1 to 120 degrees.
        """
        columns, lines = read_number_table(path, {"time": "s", **dict.fromkeys(COLUMNS, "m"), ANGLE: "degrees"})
        if missing := [name for name in ("time", *COLUMNS) if name not in columns]:
            raise InputError(f"{path}: has no column {missing[0]}; a camera path has time, {', '.join(COLUMNS)} and, if"
                             f" wanted, {ANGLE}")
        eyes, targets = (np.column_stack([columns[name] for name in part]) for part in (COLUMNS[:3], COLUMNS[3:]))
        angles = columns.get(ANGLE, np.full(len(lines), np.degrees(FIELD_OF_VIEW)))
        bad = {"the time must rise from line to line": np.append(True, np.diff(columns["time"]) > 0.0),
               "eye and target must be apart": np.linalg.norm(eyes - targets, axis=1) > 0.0,
               f"{ANGLE} must be from 1 to 120 degrees": (angles >= 1.0) & (angles <= 120.0)}
        for why, good in bad.items():
            if not good.all():
                raise InputError(f"{path}: line {lines[np.argmin(good)]}: {why}")
        return cls(columns["time"], eyes - origin, targets - origin, np.radians(angles))

    @classmethod
    def round(cls, camera, points, times):
        """From one side of a view (`Camera`) to the other, round what it shows, `points` (n, 3), between two `times`
        [s]."""
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0)).astype(float)
        target = camera.eye + ((middle - camera.eye) @ camera.axes[2]) * camera.axes[2]
        turns = np.linspace(-0.5 * ORBIT, 0.5 * ORBIT, KEYS)
        c, s, out = np.cos(turns), np.sin(turns), camera.eye - target
        eyes = target + np.column_stack([c * out[0] - s * out[1], s * out[0] + c * out[1], np.full(KEYS, out[2])])
        return cls(np.linspace(*times, KEYS), eyes, np.tile(target, (KEYS, 1)), np.full(KEYS, FIELD_OF_VIEW))

    @classmethod
    def following(cls, camera, run):
        """What moves in a run, from the direction of a view (`Camera`) that shows the whole of it."""
        samples = moving_samples(run)
        if len(samples) < 2:
            return None
        bearing, elevation = bearing_and_elevation(camera)
        views = [fit_camera(points, bearing, elevation, camera.size, margins=AROUND) for _, points in samples]
        middles = np.array([0.5 * (points.min(axis=0) + points.max(axis=0)) for _, points in samples])
        whole = np.concatenate([points for _, points in samples])
        farthest = float(np.linalg.norm(0.5 * (whole.min(axis=0) + whole.max(axis=0)) - camera.eye))
        ahead = np.array([(middle - view.eye) @ view.axes[2] for middle, view in zip(middles, views, strict=True)])
        targets = np.array([view.eye + d * view.axes[2] for view, d in zip(views, ahead, strict=True)])
        # What comes must fit in before it comes: the farther of two neighbours, then smoothly
        wide = np.maximum(ahead, WIDEST * farthest)
        wide = np.maximum(wide, np.maximum(np.append(wide[1:], 0.0), np.append(0.0, wide[:-1])))
        targets, wide = (gaussian_filter1d(values, STEADY, axis=0, mode="nearest") for values in (targets, wide))
        times = np.array([time for time, _ in samples])
        return cls(times, targets - wide[:, None] * camera.axes[2], targets, np.full(len(times), FIELD_OF_VIEW))


def path_of(name, camera, run, points):
    """The path of a camera that moves by itself, one of MOVING, from the view (`Camera`) that shows the whole of a
    run, whose action is at `points` (n, 3); None where nothing moves."""
    if name == "orbit":
        return CameraPath.round(camera, points, (run.times[0], max(run.times[-1], run.times[0] + 1e-9)))
    return CameraPath.following(camera, run)

