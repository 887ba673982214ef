"""From a run to a film or a picture: `render_run`."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.annotations import Floats, PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.camera_path import CameraPath
from snowmpm.render.field_view import LOOKS as FIELD_LOOKS
from snowmpm.render.field_view import FieldView
from snowmpm.render.film import PICTURES, open_film, output_kind
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.passes import checked_pass
from snowmpm.render.plan_inset import WISHES
from snowmpm.render.quality import Quality
from snowmpm.render.section_view import SectionView
from snowmpm.render.space_view import SpaceView
from snowmpm.render.timing import Timing
from snowmpm.render.upright import upright
from snowmpm.render.winter import GROUNDS
from snowmpm.render.workers import drawn, worker_count
from snowmpm.stages import stage

PREPARING = "choosing colours and camera, lighting the ground"
SIZES = (64, 8192)
LOOKS = ("diagram", "cinematic", *FIELD_LOOKS)


def render_run(
    run_path: PathLike | Run, output: PathLike, *, color: str | None = None, camera: str | None = None,
    time: float | None = None, size: tuple[int, int] = (1280, 720), fps: float = 25, cutaway: bool = False,
    progress: Callable[[int, int], object] | None = None, timing: Timing | None = None, plain: bool = False,
    camera_path: PathLike | None = None, layer: str = "picture", ground: str = "auto", quality: str = "full",
    inset: str = "auto", look: str = "diagram", at: str | None = None
) -> Path:
    """Draw a run without a display; looks other than "diagram" need OpenGL. Returns the path written.

    run_path   folder or file of the run, or a `snowmpm.io.Run`
    output     .mp4 or .gif: every frame of the run at `fps`, or those of `timing`; a folder: the same as PNGs; .png:
               one frame
    color      name of a field; "snow" for plain white; "fracture": the weak layer by its damage, all else white; by
               default the speed, on a map whose low end is snow white
    camera     "auto" (default), "top", "side", "front" or "BEARING,ELEVATION" [deg]; "orbit" goes round the action,
               "follow" stays with what moves; in 2-D "auto" or "side" (whole)
    camera_path  CSV file of places of the eye and the target over time (`camera_path.CameraPath.read`), in 3-D
    time       [s], for .png only: the frame nearest to it, by default the last
    cutaway    leave out, on the side of the camera, what lies over the weak layer: its damage is seen as it spreads
    size       (width, height) [px];  progress(done, total) is called before the first picture and after each
    timing     `timing.Timing` of a film: which frames, at which speed; instead of fps
    plain      no words, scales and insets
    inset      the whole in a corner, "on", "off" or "auto": in 3-D a map of the terrain with the track so far, the snow
               and what the camera shows, by itself where that is less than a quarter of the terrain; of a section all
               of it, by itself where the view is close
    layer      for compositing, in 3-D and without words: "transparent", the sky is see-through (.png, folder); "depth",
               metres along the view as 32-bit numbers, inf where there is sky (.tif, folder)
    ground     of runs in 3-D: "winter", under snow, which the flow sweeps away; "summer"; by default "auto": winter
               where snow moves on a slope
    quality    "full", or "preview": a fifth of the time, with a third of the pixels each way and, in 3-D, a quarter of
               the particles, for a look at time, colours and camera
    look       "diagram"; or by PyVista with OpenGL, in 3-D: "cinematic", snow without colours by default, no words,
               sun, haze, motion blur and depth of field (`cinema`); a field within the snow on a "slice", or its
               velocity as "arrows" or "streamlines" (`field_view`)
    at         place of a slice, "x=12", "y=..." or "z=..." in the scene's coordinates [m]
    The clock of a film says how much faster than real time it is. Raises InputError for a run without frames, an
    unknown field or camera, another ending of `output`.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    timing = timing or Timing(fps)
    size = checked_wishes(output, size, time, timing, run)
    checked_pass(layer, output_kind(output), run.dimension)
    if look != "diagram" and layer != "picture":
        raise InputError.at("look", look, f'goes without pass = "{layer}", which is of diagrams')
    if quality != "full" and layer != "picture":
        raise InputError.at("quality", quality, f'goes without pass = "{layer}", which is for compositing')
    with stage(PREPARING):
        view = view_of(run, size, color, camera, cutaway, camera_path, ground, quality=quality, look=look, at=at,
                       inset="off" if inset in WISHES and (plain or layer != "picture") else inset)
    view.plain, view.layer_drawn = plain or look == "cinematic", layer
    return write_pictures(view, run.times, output, time, timing, progress)


def checked_wishes(output, size, time, timing, run):
    """The size [px] to draw in. Raises InputError for what does not go together, before anything is drawn; run: the
    `Run` that has to reach `time`."""
    kind = output_kind(output)
    timing.check(run.path, run.times)
    if timing.chosen and kind in PICTURES:
        raise InputError("--speed, --from, --to and --every are of films and folders of pictures; --time chooses the"
                         " frame of a .png")
    if time is not None and kind not in PICTURES:
        raise InputError.at("time", time, "goes with a .png only: a film shows every frame")
    if time is not None and len(run) and not 0.0 <= time <= run.times[-1] * (1.0 + 1e-9):
        raise InputError.at("time", time, f"{run.path} goes from 0 to {run.times[-1]:g} s")
    return checked_size(size, even=kind == ".mp4")


def write_pictures(view: Any, times: Floats, output: PathLike, time: float | None = None,
                   timing: Timing | None = None, progress: Callable[[int, int], object] | None = None) -> Path:
    """The pictures of a view of `times`, several drawn at a time (`workers`); -> the path.

    output, time, timing, progress as of `render_run`.
    """
    timing = timing or Timing()
    if output_kind(output) in PICTURES:
        frames = np.array([len(times) - 1 if time is None else int(np.abs(times - time).argmin())])
    else:
        frames = timing.frames(times)
        view.pace = timing.pace(times)
    # A frame that comes several times is drawn once
    first = np.flatnonzero(np.diff(frames, prepend=-1))
    often = np.diff(first, append=len(frames))
    workers = worker_count(view.size, view.most_points, len(first))
    if progress:
        progress(0, len(first))
    begun = drawn(view.picture, frames[first].tolist(), workers)
    with open_film(output, timing.fps) as show, closing(begun) as pictures:
        for done, (picture, count) in enumerate(zip(pictures, often, strict=True), 1):
            for _ in range(count):
                show(picture)
            if progress:
                progress(done, len(first))
    return Path(output)


def check_drawable(run):
    """Raises InputError for a run without anything to draw."""
    if not any(run.n_points(i) for i in range(len(run))):
        raise InputError(f"{run.path}: no frame with particles to draw")


def view_of(run, size, color=None, camera=None, cutaway=False, camera_path=None, ground="auto", drawn=True,
            quality="full", inset="auto", look="diagram", at=None):
    """The view of a run whose `picture(i)` draws its frame i; drawn False: with its colours and camera, but without
    pictures; other arguments and errors as of `render_run`."""
    check_drawable(run)
    run = upright(run)
    quality = Quality.named(quality)
    if inset not in WISHES:
        raise InputError.not_in("inset", inset, WISHES)
    if look not in LOOKS:
        raise InputError.not_in("look", look, LOOKS)
    if at is not None and look != "slice":
        raise InputError.at("at", at, 'goes with look = "slice" only')
    if look != "diagram" and run.dimension == 2:
        raise InputError.at("look", look, "is of runs in three dimensions; a section is a diagram")
    if cutaway and run.dimension == 2:
        raise InputError(f"{run.path}: a cutaway is of a run in three dimensions; of a section, the colour {FRACTURE}"
                         " shows the weak layer")
    color = FRACTURE if cutaway and color is None else color
    if camera_path is not None and (run.dimension == 2 or camera is not None):
        raise InputError.at("camera_path", str(camera_path), "is of a run in three dimensions" if run.dimension == 2
                            else f'goes without camera = "{camera}"')
    if run.dimension == 2:
        if ground not in GROUNDS:
            raise InputError.not_in("ground", ground, GROUNDS)
        return SectionView(run, size, color, camera or "auto", quality=quality, inset=inset)
    path = None if camera_path is None else CameraPath.read(Path(camera_path), run.origin)
    if look != "diagram" and cutaway:
        raise InputError.at("look", look, "goes without a cutaway, which is of diagrams")
    if look in FIELD_LOOKS:
        return FieldView(run, size, look, color, camera or "auto", path=path, at=at, quality=quality)
    if look == "cinematic":
        from snowmpm.render.cinema.view import CinemaView  # slow to import

        return CinemaView(run, size, color, camera or "auto", path=path, ground=ground, quality=quality)
    return SpaceView(run, size, color, camera or "auto", cutaway, path=path, ground=ground, drawn=drawn,
                     quality=quality, inset=inset if drawn else "off")


def nearest_frame(run, time):
    """Number of the frame nearest to a time [s]."""
    return int(np.abs(run.times - time).argmin())


def checked_size(size, even):
    """Width and height [px] as whole numbers, even ones if asked. Raises InputError for sizes that cannot be drawn."""
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError):
        width = height = 0
    low, high = SIZES
    if not (low <= width <= high and low <= height <= high):
        raise InputError.at("size", size, f"must be width, height, each {low} to {high}")
    # H.264 wants even sides; one pixel is not worth an error.
    return (width - width % 2, height - height % 2) if even else (width, height)
