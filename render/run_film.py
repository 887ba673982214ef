"""From a run to a film or a picture: `render_run`."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.annotations import Floats, PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.parameters import methods_of
from snowmpm.io.status import cautions
from snowmpm.render import light
from snowmpm.render.camera_path import MOVING, CameraPath, path_of
from snowmpm.render.colour import choose_scale
from snowmpm.render.credit import attribution
from snowmpm.render.film import PICTURES, open_film, output_kind
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.fracture import Cutaway, WeakLayer
from snowmpm.render.framing import choose_camera, emptier_side, sample_action
from snowmpm.render.ground import draw_ground
from snowmpm.render.overlay import Overlay
from snowmpm.render.passes import checked_pass, sky_of, with_alpha
from snowmpm.render.quality import Quality
from snowmpm.render.relief import build_relief
from snowmpm.render.section import Profile, draw_section
from snowmpm.render.sheet import sheet_of
from snowmpm.render.snow import SNOW, draw_snow, seen_snow
from snowmpm.render.solid import draw_solids, nearby, placed
from snowmpm.render.timing import Timing, pace_in_words
from snowmpm.render.tracking import plan_track
from snowmpm.render.winter import GROUNDS, snow_cover
from snowmpm.render.workers import drawn, worker_count
from snowmpm.stages import stage

PREPARING = "choosing colours and camera, lighting the ground"
SIZES = (64, 8192)
INSET = 0.30  # of the picture's sides


def render_run(
    run_path: PathLike | Run, output: PathLike, *, color: str | None = None, camera: str | None = None,
    time: float | None = None, size: tuple[int, int] = (1280, 720), fps: float = 25, cutaway: bool = False,
    progress: Callable[[int, int], object] | None = None, timing: Timing | None = None, plain: bool = False,
    camera_path: PathLike | None = None, layer: str = "picture", ground: str = "auto", quality: str = "full"
) -> Path:
    """Draw a run; needs no display and no graphics library. Returns the path written.

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
    layer      for compositing, in 3-D and without words: "transparent", the sky is see-through (.png, folder); "depth",
               metres along the view as 32-bit numbers, inf where there is sky (.tif, folder)
    ground     of runs in 3-D: "winter", under snow, which the flow sweeps away; "summer"; by default "auto": winter
               where snow moves on a slope
    quality    "full", or "preview": a fifth of the time, with a third of the pixels each way and, in 3-D, a quarter of
               the particles, for a look at time, colours and camera
    The clock of a film says how much faster than real time it is. Raises InputError for a run without frames, an
    unknown field or camera, another ending of `output`.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    timing = timing or Timing(fps)
    size = checked_wishes(output, size, time, timing, run)
    checked_pass(layer, output_kind(output), run.dimension)
    if quality != "full" and layer != "picture":
        raise InputError.at("quality", quality, f'goes without pass = "{layer}", which is for compositing')
    with stage(PREPARING):
        view = view_of(run, size, color, camera, cutaway, camera_path, ground, quality=quality)
    view.plain, view.layer_drawn = plain, layer
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
            quality="full"):
    """The view of a run whose `picture(i)` draws its frame i; drawn False: with its colours and camera, but without
    pictures; other arguments and errors as of `render_run`."""
    check_drawable(run)
    quality = Quality.named(quality)
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
        return SectionView(run, size, color, camera or "auto", quality=quality)
    path = None if camera_path is None else CameraPath.read(Path(camera_path), run.origin)
    return SpaceView(run, size, color, camera or "auto", cutaway, path=path, ground=ground, drawn=drawn,
                     quality=quality)


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


class _View:
    """What the pictures of one film share: colours, particle size, words."""

    def __init__(self, run, size, color):
        self.run, self.size = run, size
        self.layer = WeakLayer.of(run) if color == FRACTURE else None
        self.cut = None
        self.scale = self.layer.scale() if self.layer else choose_scale(run, color)
        self.table = None if self.scale is None else light.decode(self.scale.table())
        self.spacing = particle_spacing(run)
        self.title, self.cautions = run.name, cautions(run)
        self.pace, self.plain, self.layer_drawn = None, False, "picture"
        self.quality, self.as_sheet = Quality(), False

    @property
    def most_points(self):
        """Particles of the fullest frame."""
        return max(self.run.n_points(i) for i in range(len(self.run)))

    def fields_of(self, i):
        """Frame `i` with the fields that its colours need."""
        names = [] if self.scale is None else [self.scale.field]
        names += ["material"] if self.layer or self.cut else []
        names += ["depth"] if "depth" in self.run.field_names else []
        known = "id" in self.run.field_names
        return self.run.frame(i, dict.fromkeys([*names, *(["id"] if known else [])]))

    def _frame(self, i):
        """(time, what the drawing functions take of frame `i`: points, spacing, colours, identity)."""
        frame = self.fields_of(i)
        good = np.isfinite(frame.points).all(axis=1)
        thin = 1 if "depth" in frame.fields or self.run.dimension == 2 else self.quality.share(self.most_points)
        if thin > 1:
            # The same ones in every frame, where they are known
            good &= frame.fields.get("id", np.arange(len(good))) % thin == 0
        if self.cut:
            good &= self.cut.shown(frame)
        colours = None
        if self.layer:
            colours = self.layer.colours(frame, self.table, SNOW)[good]
        elif self.scale is not None:
            share = np.nan_to_num(self.scale.share(self.scale.numbers(frame)[good]))
            colours = self.table[np.round(255 * share).astype(int)]
        identity = frame.fields["id"][good] if "id" in frame.fields else None
        points = frame.points[good]
        spacing = particle_spacing(self.run, frame.time) * thin ** (1.0 / 3.0)
        if "depth" in frame.fields and len(points):
            depth, fine = frame.fields["depth"][good], self.run.provenance.get("zone_spacing")
            # Particles in three dimensions, before or after a hand-over, have a depth of zero
            if self.as_sheet and fine is None and np.mean(depth > 0.0) > 0.5:
                shown = np.tile(SNOW, (len(points), 1)) if colours is None else colours
                sheet = sheet_of(points, np.nan_to_num(depth.ravel()), spacing, shown, self.relief.height)
                if sheet is not None:
                    return frame.time, (*sheet, None)
            each = None if fine is None else np.where(depth.ravel() > 0.0, spacing, min(spacing, fine))
            points, colours, identity, each = piled(points, depth, spacing, colours, identity, each)
            spacing = spacing if each is None else each
        return frame.time, (points, spacing, colours, identity)

    def _legend(self, overlay, time, side="right"):
        overlay.heading(self.title.replace("_", " "), time, float(self.run.times[-1]), pace_in_words(self.pace))
        if time == self.run.times[-1]:
            overlay.warnings(self.cautions)
        if self.scale is not None:
            overlay.colour_scale(self.scale, side)


class SpaceView(_View):
    """Three-dimensional runs: the ground is drawn once, or for each frame where the camera moves, the snow over it."""

    def __init__(self, run, size, color, camera, cutaway=False, action=None, path=None, ground="auto",
                 drawn=True, quality=None):
        """action: what the camera has to show, by default that of the run (`framing.sample_action`); path: `CameraPath`
        of one that moves; ground: as of `winter.snow_cover`; drawn: as of `view_of`;
        quality: a `Quality`."""
        super().__init__(run, size, color)
        self.quality = quality or self.quality
        action = action or sample_action(run)
        action = action.showing(nearby(run, action.points.min(axis=0), action.points.max(axis=0)))
        relief = None if run.terrain is None else build_relief(run.terrain, *action.box())
        self.action, self.relief, self.as_sheet = action, relief, relief is not None
        self.camera = choose_camera("auto" if camera in MOVING else camera, action, relief, size)
        self.path = path_of(camera, self.camera, run, action.points) if camera in MOVING else path
        facing = np.array([0.0, 0.0, 1.0]) if relief is None else relief.normals.mean(axis=0)
        self.sun = light.sun_direction(self.camera.axes, facing)
        self.side = emptier_side(self.camera, action)
        self.cover = snow_cover(run, relief, self.spacing, ground)
        # Half of the time of a page would go into a picture of the ground that it does not show
        self.ground = self._drawn_ground(self.quality.camera(self.camera)) if drawn else None
        if cutaway:
            self.cut = Cutaway.of(run, self.layer or WeakLayer.of(run), self.camera)

    def picture(self, i):
        """Frame `i`: (height, width, 3) uint8, with alpha (height, width, 4) of the pass "transparent", float32
        (height, width) of the pass "depth"."""
        time, snow = self._frame(i)
        camera = self.camera if self.path is None else self.path.camera(time, self.size)
        if self.layer_drawn == "depth":
            behind = self._behind(i, camera)
            return np.minimum(seen_snow(behind, camera, *snow[:2])[1], behind.depth).astype(np.float32)
        if self.layer_drawn == "transparent":
            return with_alpha(*(draw_snow(self._behind(i, camera, sky_of(brightness)), camera, self.sun, *snow)
                                for brightness in (0.0, 1.0)))
        seen = self.quality.camera(camera)
        ground = self._behind(i, seen)
        picture = light.encode(draw_snow(ground, seen, self.sun, *snow, in_crumbs=self.quality.crumbs))
        overlay = Overlay(self.quality.enlarged(picture, camera.size))
        if self.plain:
            return overlay.picture()
        self._legend(overlay, time, self.side)
        other = "left" if self.side == "right" else "right"
        if not camera.perspective:
            overlay.length_scale(camera.scale, other)
        elif ground.contour_interval:
            words = [f"contours every {ground.contour_interval:g} m", attribution(self.run.provenance)]
            overlay.note("; ".join(filter(None, words)), other)
        else:
            overlay.length_scale(self.action.size_in(camera), other, about=True)
        return overlay.picture()

    def _behind(self, i, camera, sky=light.sky):
        """`Ground` with the solids of frame `i`, as a camera sees them."""
        known = self.path is None and sky is light.sky
        ground = self.ground if known else self._drawn_ground(camera, sky)
        return draw_solids(ground.at(self.run.times[i]), camera, self.sun, *placed(self.run, i))

    def _drawn_ground(self, camera, sky=light.sky):
        return draw_ground(self.relief, camera, self.sun, sky, self.cover)


class SectionView(_View):
    """Plane-strain runs: the section, and an inset with the whole of it when the view is close."""

    def __init__(self, run, size, color, camera, track=None, quality=None):
        """track: the moving view, by default that of the run (`tracking.plan_track`); quality: a `Quality`."""
        super().__init__(run, size, color)
        self.quality = quality or self.quality
        if camera not in ("auto", "side"):
            raise InputError.at("camera", camera, "must be auto or side for a run in two dimensions")
        self.profile = Profile.of(run.terrain)
        self.track = track or plan_track(run, self.profile, self.spacing, size, close=camera == "auto")

    def picture(self, i):
        """(height, width, 3) uint8 of frame `i`."""
        time, snow = self._frame(i)
        camera, snow = self.track.camera(i), (*snow, placed(self.run, i))
        overlay = Overlay(self._section(camera, snow))
        if self.plain:
            return overlay.picture()
        side = "right" if self.track.falls_left else "left"
        if self.track.close:
            self._inset(overlay, camera, snow)
        self._legend(overlay, time, side)
        overlay.length_scale(camera.scale, side, beside=self.scale is not None)
        return overlay.picture()

    def _inset(self, overlay, camera, snow):
        """The whole section, with a frame around what the picture shows, in the upper corner over lower ground."""
        width, height = (int(INSET * side) for side in self.size)
        whole = self.track.overview((width, height))
        top = overlay.px(20)
        left = self.size[0] // 2 - width // 2 if self.track.falls_left else self.size[0] - width - top
        overlay.inset(self._section(whole, snow), (left, top))
        half = 0.5 * np.array(self.size) / camera.scale
        x, y, _ = whole.project(camera.eye + np.array([[-half[0], 0.0, half[1]], [half[0], 0.0, -half[1]]]))
        x, y = np.clip(x, 1, width - 2) + left, np.clip(y, 1, height - 2) + top
        overlay.rectangle([x[0], y[0], x[1], y[1]])

    def _section(self, camera, snow):
        picture = draw_section(self.profile, self.quality.camera(camera), *snow)
        return self.quality.enlarged(light.encode(picture), camera.size)


def piled(points, depth, spacing, *others):
    """Columns of snow as piles of points: points (n, 3) at half their depth (n,) [m], in layers at most `spacing` [m]
    apart from the ground to the surface; -> (points, others), each layer with all rows of the others.

    Depths are normal to the ground, of which a frame does not know the slope: they are drawn upwards.
    """
    layers = 1 + int(np.ceil(np.nan_to_num(depth).max(initial=0.0) / spacing))
    if layers == 1:
        return points, *others
    at = np.linspace(-0.5, 0.5, layers)
    piles = np.tile(points.astype(float), (layers, 1))
    piles[:, 2] += (at[:, None] * np.nan_to_num(depth)).ravel()
    return piles, *(None if other is None else np.concatenate([other] * layers) for other in others)


def particle_spacing(run, time=0.0):
    """Distance [m] between particles: what the run says of itself, of its method at a time [s], or from the field
    `volume`, or between neighbours in the first frame that has any."""
    noted = run.provenance.get("particle_spacing")
    for record in methods_of(run):
        if record["time"] < time:
            noted = record["particle_spacing"]
    if isinstance(noted, int | float) and noted > 0.0:
        return float(noted)
    i = next(i for i in range(len(run)) if run.n_points(i))
    if "volume" in run.field_names:
        volume = float(np.median(run.frame(i, ["volume"]).fields["volume"]))
        if volume > 0.0:
            return volume ** (1.0 / run.dimension)
    points = run.frame(i, []).points
    points = points[np.isfinite(points).all(axis=1)]
    sample = points[np.random.default_rng(0).permutation(len(points))[:2000]]
    nearest = cKDTree(points).query(sample, k=2)[0][:, 1] if len(points) > 1 else np.array([1.0])
    nearest = nearest[np.isfinite(nearest) & (nearest > 0.0)]
    return float(np.median(nearest)) if len(nearest) else 1.0
