"""Where to stand: the camera that shows all the snow over the whole run, free of ridges in between."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.camera import FIELD_OF_VIEW, MARGINS, fit_camera
from snowmpm.render.colour import scalar

NAMES = ("auto", "top", "side", "front")
SAMPLED_FRAMES = 16
SAMPLED_POINTS = 4000
MOVING = 0.02  # share of the largest speed, and of the sample: less counts as rest
RIM = (0.03, 0.03, 0.04, 0.04)  # of the picture around the ground, where all of it is shown
CLOSER = 0.8  # size of the action on the picture, of the one without all the ground, that is worth showing it
ROOM = 1.25  # what is kept free around the action there: as without the ground
GRAZING = 0.3  # sine of the angle between view and ground below which snow on it is a streak
SURROUNDINGS = 0.6  # of the action's extent, drawn on each side of it


@dataclass(frozen=True)
class Action:
    """What happens in a run, sampled: where the particles go and which way.

    points (n, 3): a sample over all frames of what moves, without strays; direction (2,): the way in plan of their mean
    """

    points: np.ndarray
    direction: np.ndarray

    def showing(self, more):
        """The same with further points (k, 3) to be kept in sight."""
        return Action(np.concatenate([self.points, more]), self.direction)

    def size_in(self, camera):
        """Pixels that a metre of it has in a picture, halfway from its front to its back."""
        return float(np.median(camera.pixels_per_metre(camera.project(self.points)[2])))

    def box(self):
        """(lower, upper) plan box of the action with its surroundings."""
        plan = self.points[:, :2]
        margin = SURROUNDINGS * float(np.ptp(plan, axis=0).max()) + 1e-6
        return plan.min(axis=0) - margin, plan.max(axis=0) + margin


def sample_action(run):
    """Sample the motion of a run: the particles that move, or all where nothing does.

    Raises InputError when no frame has a particle.
    """
    moving = [points for _, points in moving_samples(run)]
    points = np.concatenate(moving)
    way = (moving[-1].mean(axis=0) - moving[0].mean(axis=0))[:2]
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    if np.linalg.norm(way) < 0.02 * extent:
        way = downhill(points)
    length = np.linalg.norm(way)
    return Action(points, way / length if length > 0.0 else np.array([1.0, 0.0]))


def moving_samples(run):
    """[(time [s], points (k, 3))] of some frames: the particles that move, or all where nothing does.

    Raises InputError when no frame has a particle.
    """
    rng = np.random.default_rng(0)
    frames = np.unique(np.linspace(0, len(run) - 1, SAMPLED_FRAMES).round()).astype(int)
    sampled = [(float(run.times[i]), *_sample(run, int(i), rng)) for i in frames]
    sampled = [(time, points, speed) for time, points, speed in sampled if len(points)]
    if not sampled:
        raise InputError(f"{run.path}: no frame with particles to draw")
    fastest = max(float(np.quantile(speed, 0.99)) for _, _, speed in sampled)
    moving = [(time, points[speed > MOVING * fastest]) for time, points, speed in sampled]
    # Snow that stays where it lies, on the whole slope perhaps, is not what the film is about.
    moving = [(time, points) for time, points in moving if len(points) > MOVING * SAMPLED_POINTS]
    return moving if len(moving) >= 2 else [(time, points) for time, points, _ in sampled]


def _sample(run, i, rng):
    """(points (k, 3), speed (k,)) of some particles of frame `i`, without the strays."""
    names = ["velocity"] if "velocity" in run.field_names else []
    frame = run.frame(i, names)
    some = slice(None, None, max(1, len(frame.points) // (10 * SAMPLED_POINTS)))
    points = frame.points[some].astype(float)
    speed = scalar(frame.fields["velocity"][some]) if names else np.ones(len(points))
    good = np.isfinite(points).all(axis=1) & np.isfinite(speed)
    if good.sum() > 2000:
        # A few that fly off, a thousandth on each side, must not make the rest small.
        low, high = np.quantile(points[good], [0.001, 0.999], axis=0)
        good &= ((points >= low) & (points <= high)).all(axis=1)
    chosen = rng.permutation(np.flatnonzero(good))[:SAMPLED_POINTS]
    return points[chosen], speed[chosen]


def downhill(points):
    """Plan direction in which the particles lie lower: the way snow at rest would go."""
    plan = np.column_stack([points[:, :2] - points[:, :2].mean(axis=0), np.ones(len(points))])
    slope = np.linalg.lstsq(plan, points[:, 2], rcond=None)[0][:2]
    return -slope


@dataclass(frozen=True)
class Stance:
    """How a camera stands that is chosen: elevations [degrees] above the horizon that it may have, field of view of the
    longer side [rad], margins of the picture (left, right, top, bottom), whether all the ground is shown where that
    costs little, and the elevation [degrees] from which it departs unwillingly."""

    elevations: tuple[float, ...] = (24.0, 34.0, 46.0, 60.0)
    field_of_view: float = FIELD_OF_VIEW
    margins: tuple[float, ...] = MARGINS
    whole: bool = True
    usual: float = 32.0

    def fit(self, action, bearing, elevation, size):
        """The camera from that direction [rad] that shows all of an `Action`."""
        return fit_camera(action.points, bearing, elevation, size, margins=self.margins,
                          field_of_view=self.field_of_view)


def choose_camera(name, action, relief, size, stance=None):
    """Camera for a name of NAMES or "BEARING,ELEVATION" in degrees (where it stands, seen from the snow); stance:
    a `Stance`.

    auto: obliquely from the front side, the way that hides least behind the terrain and shows most.
    """
    along, stance = float(np.arctan2(action.direction[0], action.direction[1])), stance or Stance()
    if name == "top":
        # North up, as on a map.
        return fit_camera(action.points, np.pi, 0.5 * np.pi, size, perspective=False)
    if name == "side":
        return stance.fit(action, along + 0.5 * np.pi, np.radians(12.0), size)
    if name == "front":
        return stance.fit(action, along, np.radians(22.0), size)
    if name != "auto":
        bearing, elevation = _angles(name)
        return stance.fit(action, bearing, elevation, size)
    candidates = [
        stance.fit(action, along + np.radians(side), np.radians(elevation), size)
        for elevation in stance.elevations
        for side in (52.0, -52.0, 75.0, -75.0, 28.0, -28.0)
    ]
    best = max(candidates, key=lambda camera: _merit(camera, action, relief, along, stance.usual))
    return _with_ground(best, action, relief) if stance.whole else best


def _with_ground(camera, action, relief):
    """The same view from as far as brings all the ground into the picture, where that is little farther."""
    if relief is None:
        return camera
    bearing, elevation = bearing_and_elevation(camera)
    middle = 0.5 * (action.points.min(axis=0) + action.points.max(axis=0))
    everything = np.concatenate([middle + ROOM * (action.points - middle), relief.vertices])
    whole = fit_camera(everything, bearing, elevation, camera.size, margins=RIM)
    return whole if CLOSER < action.size_in(whole) / action.size_in(camera) < 1.0 else camera


def _merit(camera, action, relief, along, usual):
    """Share of the action in sight, and not edge-on, less what departs from the usual stance, plus how large it is and
    how much picture it fills."""
    points = action.points[:: max(1, len(action.points) // 1500)]
    seen = 1.0
    if relief is not None:
        facing = relief.facing(points, camera.eye) / GRAZING
        seen = float((relief.visible(points, camera.eye, clearance=0.5 * relief.cell) * facing.clip(0.0, 1.0)).mean())
    x, y, _ = camera.project(action.points)
    filled = np.zeros((24, 40), bool)
    column = np.clip(40 * x / camera.size[0], 0, 39).astype(int)
    row = np.clip(24 * y / camera.size[1], 0, 23).astype(int)
    filled[row, column] = True
    out = -camera.axes[2]
    elevation = np.degrees(np.arcsin(out[2]))
    turn = np.degrees(abs((np.arctan2(out[0], out[1]) - along + np.pi) % (2.0 * np.pi) - np.pi))
    large = 0.6 * np.log(action.size_in(camera)) + 1.5 * filled.mean()
    return 3.0 * min(seen, 0.97) + large - 0.010 * abs(elevation - usual) - 0.004 * abs(turn - 52.0)


def emptier_side(camera, action):
    """ "left" or "right": the lower corner of the picture where fewer of the action's points are."""
    x, y, _ = camera.project(action.points)
    low = y > 0.75 * camera.size[1]
    left, right = ((low & there).sum() for there in (x < 0.33 * camera.size[0], x > 0.67 * camera.size[0]))
    return "left" if left < right else "right"


def bearing_and_elevation(camera):
    """Where a camera stands as seen from what it shows [rad]."""
    return _angles(camera.bearing_and_elevation())


def _angles(name):
    try:
        bearing, elevation = (float(part) for part in str(name).split(","))
    except ValueError:
        bearing, elevation = np.nan, np.nan
    if not (np.isfinite(bearing) and -89.0 <= elevation <= 90.0):
        more = ", orbit, follow, or BEARING,ELEVATION in degrees such as 200,30"
        raise InputError.not_in("camera", name, NAMES, more=more)
    return np.radians(bearing), np.radians(elevation)
