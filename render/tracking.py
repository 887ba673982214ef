"""The moving view of a plane-strain run: whole if that shows the snow, else near the motion with an overview inset."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from snowmpm.render.colour import scalar
from snowmpm.render.overlay import bands
from snowmpm.render.section import section_camera
from snowmpm.render.solid import nearby

THINNEST = 10.0  # px: a layer drawn thinner than this asks for a closer view
CLOSE_UP = 24.0  # px: thickness of the layer in the closer view
SMOOTHING = 0.06  # of the number of frames: the view moves steadily
MARGINS = (0.06, 0.06, 0.16, 0.14)  # left, right, top, bottom of the picture that stay free, if words need no more


@dataclass(frozen=True)
class Track:
    """A camera for each frame, and one for the overview.

    close       the frames show only a part
    falls_left  the ground falls towards the left: room for an inset is there
    """

    centres: np.ndarray
    scale: float
    size: tuple[int, int]
    close: bool
    low: np.ndarray
    high: np.ndarray
    falls_left: bool = False

    def camera(self, i):
        """The view of frame `i`."""
        return section_camera(self.centres[i], self.scale, self.size)

    def overview(self, size):
        """The whole run within `size` (width, height) pixels."""
        scale, centre = _whole(self.low, self.high, size, (0.04, 0.04, 0.08, 0.12))
        return section_camera(centre, scale, size)


def plan_track(run, profile, spacing, size, close=True):
    """Views for all frames of `run`. `close` False keeps the whole run in sight however thin the snow."""
    low, high, focus, thickness, slope = _survey(run, spacing)
    in_sight = np.concatenate([[low, high], nearby(run, low, high)])
    low, high = in_sight.min(axis=0), in_sight.max(axis=0)
    if profile is not None:
        ground = profile.height(np.linspace(low[0], high[0], 200))
        ground = ground[np.isfinite(ground)]
        if len(ground):
            low[1], high[1] = min(low[1], ground.min()), max(high[1], ground.max())
    scale, centre = _whole(low, high, size, _margins(size))
    falls_left = slope > 0.0
    if not close or thickness * scale >= THINNEST:
        return Track(np.tile(centre, (len(run), 1)), scale, tuple(size), False, low, high, falls_left)
    scale = max(scale, min(CLOSE_UP / thickness, 6.0 * scale))
    steady = ndimage.gaussian_filter1d(focus, max(SMOOTHING * len(run), 0.5), axis=0, mode="nearest")
    return Track(steady, scale, tuple(size), True, low, high, falls_left)


def joint_track(first, second, shift):
    """The track that shows both of two runs with the frames of the first; shift (2,): origin of the second to that of
    the first [m]."""
    low, high = np.minimum(first.low, second.low + shift), np.maximum(first.high, second.high + shift)
    if first.close:
        return replace(first, low=low, high=high, scale=min(first.scale, second.scale) if second.close else first.scale)
    scale, centre = _whole(low, high, first.size, _margins(first.size))
    return replace(first, centres=np.tile(centre, (len(first.centres), 1)), scale=scale, low=low, high=high)


def _survey(run, spacing):
    """Box (lower, upper) of the snow in (x, z), where it moves in each frame; its thickness and rise at first."""
    names = ["velocity"] if "velocity" in run.field_names else []
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    focus, thickness, slope = np.full((len(run), 2), np.nan), spacing, 0.0
    for i in range(len(run)):
        frame = run.frame(i, names)
        good = np.isfinite(frame.points).all(axis=1)
        plane = frame.points[good][:, [0, 2]].astype(float)
        if not len(plane):
            continue
        inner = np.quantile(plane, [0.002, 0.998], axis=0)
        low, high = np.minimum(low, inner[0]), np.maximum(high, inner[1])
        speed = np.nan_to_num(scalar(frame.fields["velocity"])[good]) if names else np.ones(len(plane))
        weight = speed + 0.02 * speed.max(initial=0.0) + 1e-6
        focus[i] = (weight[:, None] * plane).sum(axis=0) / weight.sum()
        if not np.isfinite(focus[:i]).any():
            length = float(np.linalg.norm(inner[1] - inner[0])) + spacing
            slope = float(np.cov(plane.T)[0, 1]) if len(plane) > 1 else 0.0
            thickness = max(len(plane) * spacing**2 / length, spacing)
    return low, high, _filled(focus), thickness, slope


def _filled(rows):
    """Rows of NaN take the value of the nearest row that has one."""
    known = np.flatnonzero(np.isfinite(rows[:, 0]))
    nearest = known[np.abs(np.arange(len(rows))[:, None] - known).argmin(axis=1)]
    return rows[nearest]


def _margins(size):
    """Of a whole view: on a low picture heading and colour scale want more than their share of a high one."""
    top, bottom = bands(size)
    return *MARGINS[:2], max(MARGINS[2], top), max(MARGINS[3], bottom)


def _whole(low, high, size, margins):
    left, right, top, bottom = margins
    room = np.array([size[0] * (1.0 - left - right), size[1] * (1.0 - top - bottom)])
    scale = float(np.min(room / np.maximum(high - low, 1e-3)))
    shift = np.array([0.5 * (right - left) * size[0], 0.5 * (top - bottom) * size[1]]) / scale
    return scale, 0.5 * (low + high) + shift
