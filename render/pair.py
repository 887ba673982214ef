"""Two runs side by side in one film: the same camera, the same colours, the same time."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.floor import ground_of
from snowmpm.render.framing import Action, sample_action
from snowmpm.render.run_film import PREPARING, check_drawable, checked_wishes, nearest_frame, write_pictures
from snowmpm.render.section import Profile
from snowmpm.render.section_view import SectionView
from snowmpm.render.space_view import SpaceView
from snowmpm.render.timing import Timing
from snowmpm.render.tracking import joint_track, plan_track
from snowmpm.render.upright import upright
from snowmpm.render.view import particle_spacing
from snowmpm.stages import stage

GAP = 4  # px of white between the two


class PairView:
    """The view of two runs of one dimension whose `picture(i)` shows them at time i of the one that lasts longer.

    Sections stand one above the other, views in space beside each other; size is that of both together. Colours and
    limits are those that hold both runs.
    """

    def __init__(self, first, second, size, color=None, camera=None, cutaway=False):
        if first.dimension != second.dimension:
            raise InputError(f"{second.path}: is in {second.dimension} dimensions, {first.path} in {first.dimension}:"
                             " side by side go runs of the same")
        self.runs = (upright(first), upright(second))
        self.times = first.times if first.times[-1] >= second.times[-1] else second.times
        for run in self.runs:
            check_drawable(run)
        above = first.dimension == 2
        width, height = size
        self._axis, part = (0, (width, (height - GAP) // 2)) if above else (1, ((width - GAP) // 2, height))
        self.size = size
        self.views = (_sections if above else _spaces)(self.runs, part, color, camera or "auto", cutaway)
        _share_scale(self.views)
        for view, title in zip(self.views, _titles(*self.runs), strict=True):
            view.title = title

    @property
    def pace(self):
        """Simulated seconds in a second of film, None of a single picture."""
        return self.views[0].pace

    @pace.setter
    def pace(self, pace):
        for view in self.views:
            view.pace = pace

    @property
    def most_points(self):
        """Particles of the fullest frame of either run."""
        return max(view.most_points for view in self.views)

    def picture(self, i):
        """(height, width, 3) uint8 at time number `i` of `times`."""
        pictures = [view.picture(nearest_frame(run, self.times[i]))
                    for view, run in zip(self.views, self.runs, strict=True)]
        whole = np.full((self.size[1], self.size[0], 3), 255, np.uint8)
        start = 0
        for picture in pictures:
            part = whole[start:] if self._axis == 0 else whole[:, start:]
            part[: picture.shape[0], : picture.shape[1]] = picture
            start += picture.shape[self._axis] + GAP
        return whole


def render_pair(first: Run, second: Run, output: PathLike, *, color: str | None = None, camera: str | None = None,
                time: float | None = None, size: tuple[int, int] = (1920, 720), fps: float = 25, cutaway: bool = False,
                progress: Callable[[int, int], object] | None = None, timing: Timing | None = None,
                plain: bool = False) -> Path:
    """Draw two `snowmpm.io.Run`s side by side to a film or picture; -> its path. The rest as of `render_run`.

    Frames are those of the run that lasts longer; the other shows its nearest frame, at last its end.
    """
    longer = max(first, second, key=lambda run: run.times[-1] if len(run) else 0.0)
    timing = timing or Timing(fps)
    size = checked_wishes(output, size, time, timing, longer)
    with stage(PREPARING):
        view = PairView(first, second, size, color, camera, cutaway)
    for part in view.views:
        part.plain = plain
    return write_pictures(view, view.times, output, time, timing, progress)


def _spaces(runs, size, color, camera, cutaway):
    actions = [sample_action(run) for run in runs]
    if not _same_place(actions, runs[1].origin - runs[0].origin):
        return tuple(SpaceView(run, size, color, camera, cutaway, action=action)
                     for run, action in zip(runs, actions, strict=True))
    # The runs are relative to origins of their own
    shift = runs[1].origin - runs[0].origin
    points = np.concatenate([actions[0].points, actions[1].points + shift])
    both = Action(points, actions[0].direction)
    moved = Action(points - shift, actions[0].direction)
    first = SpaceView(runs[0], size, color, camera, cutaway, action=both)
    # What hides the snow may differ a little: the direction that suits the first run serves for both
    camera = first.camera.bearing_and_elevation() if camera == "auto" else camera
    return first, SpaceView(runs[1], size, color, camera, cutaway, action=moved)


def _same_place(actions, shift):
    """Whether the middle of each of two actions lies in the plan box of the other; else each has a view of its own."""
    boxes = [(action.points[:, :2] + offset[:2]) for action, offset in zip(actions, (np.zeros(3), shift), strict=True)]
    low, high = ([f(box, axis=0) for box in boxes] for f in (np.min, np.max))
    return all((low[1 - k] <= boxes[k].mean(axis=0)).all() and (boxes[k].mean(axis=0) <= high[1 - k]).all()
               for k in (0, 1))


def _sections(runs, size, color, camera, cutaway):
    if cutaway:
        raise InputError(f"{runs[0].path}: a cutaway is of runs in three dimensions")
    tracks = [plan_track(run, Profile.of(ground_of(run)), particle_spacing(run), size, close=camera == "auto")
              for run in runs]
    shift = (runs[1].origin - runs[0].origin)[[0, 2]]
    joint = joint_track(*tracks, shift)
    frames = [nearest_frame(runs[0], time) for time in runs[1].times]
    second = replace(joint, centres=joint.centres[frames] - shift, low=joint.low - shift, high=joint.high - shift)
    return (SectionView(runs[0], size, color, camera, track=joint),
            SectionView(runs[1], size, color, camera, track=second))


def _share_scale(views):
    """Give both views the limits that hold both."""
    first, second = (view.scale for view in views)
    if first is None or second is None or first.names:
        return
    low, high = min(first.low, second.low), max(first.high, second.high)
    for view in views:
        view.scale = replace(view.scale, low=low, high=high, colormap=first.colormap)


def _titles(first, second):
    """What tells the runs apart: scene names, or else names of their folders, or else of the folders above."""
    names = [run.name for run in (first, second)]
    if names[0] != names[1]:
        return names
    folders = [run.path.resolve().parent for run in (first, second)]
    while folders[0].name == folders[1].name and folders[0] != folders[1]:
        folders = [folder.parent for folder in folders]
    return [folder.name for folder in folders]
