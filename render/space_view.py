"""Pictures of a run in three dimensions."""

import copy

import numpy as np

from snowmpm.render import light
from snowmpm.render.camera_path import MOVING, path_of
from snowmpm.render.credit import attribution
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.fracture import Cutaway, WeakLayer
from snowmpm.render.framing import Stance, choose_camera, emptier_side, sample_action
from snowmpm.render.ground import draw_ground
from snowmpm.render.overlay import Overlay
from snowmpm.render.passes import sky_of, with_alpha
from snowmpm.render.plan_inset import PlanInset
from snowmpm.render.relief import build_relief
from snowmpm.render.snow import draw_snow, seen_snow
from snowmpm.render.solid import draw_solids, nearby
from snowmpm.render.view import View
from snowmpm.render.winter import snow_cover


class SpaceView(View):
    """Three-dimensional runs: the ground is drawn once, or for each frame where the camera moves, the snow over it."""

    stance = Stance()
    """Of a camera that is chosen."""

    sun_at = (0.44, 38.0)
    """How far behind the camera the sun is, and its elevation (`light.sun_direction`)."""

    def __init__(self, run, size, color, camera, cutaway=False, action=None, path=None, ground="auto",
                 drawn=True, quality=None, inset="off"):
        """action: what the camera has to show, by default that of the run (`framing.sample_action`); path: `CameraPath`
        of one that moves; ground: as of `winter.snow_cover`; drawn: as of `view_of`; quality: a `Quality`; inset: a
        map, as of `PlanInset.of`."""
        super().__init__(run, size, color)
        self.quality = quality or self.quality
        action = action or sample_action(run)
        action = action.showing(nearby(run, action.points.min(axis=0), action.points.max(axis=0)))
        relief = None if self.terrain is None else build_relief(self.terrain, *action.box())
        self.action, self.relief, self.as_sheet = action, relief, relief is not None
        self.camera = choose_camera("auto" if camera in MOVING else camera, action, relief, size, self.stance)
        self.path = path_of(camera, self.camera, run, action.points) if camera in MOVING else path
        facing = np.array([0.0, 0.0, 1.0]) if relief is None else relief.normals.mean(axis=0)
        self.sun = light.sun_direction(self.camera.axes, facing, *self.sun_at)
        self.side = emptier_side(self.camera, action)
        self.cover = snow_cover(run, relief, self.spacing, ground)
        # Half of the time of a page would go into a picture of the ground that it does not show
        self.ground = self._drawn_ground(self.quality.camera(self.camera)) if drawn else None
        if cutaway:
            self.cut = Cutaway.of(run, self.layer or WeakLayer.of(run), self.camera)
        self.inset = PlanInset.of(self, inset)

    def picture(self, i):
        """Frame `i`: (height, width, 3) uint8, with alpha (height, width, 4) of the pass "transparent", float32
        (height, width) of the pass "depth"."""
        time, snow = self._frame(i)
        camera = self.camera if self.path is None else self.path.camera(time, self.size)
        if self.layer_drawn == "depth":
            behind = self._behind(i, camera, snow)
            return np.minimum(seen_snow(behind, camera, *snow[:2])[1], behind.depth).astype(np.float32)
        if self.layer_drawn == "transparent":
            return with_alpha(*(draw_snow(self._behind(i, camera, snow, sky_of(brightness)), camera, self.sun, *snow)
                                for brightness in (0.0, 1.0)))
        seen = self.quality.camera(camera)
        ground = self._behind(i, seen, snow)
        picture = light.encode(draw_snow(ground, seen, self.sun, *snow, in_crumbs=self.quality.crumbs))
        overlay = Overlay(self.quality.enlarged(picture, camera.size))
        if self.plain:
            return overlay.picture()
        if self.inset:
            self.inset.draw(overlay, time, snow[0], camera)
        self._point_at_saw(overlay, camera, time)
        self._legend(overlay, time, self.side)
        other = "left" if self.side == "right" else "right"
        if not camera.perspective:
            overlay.length_scale(camera.scale, other)
        elif ground.contour_interval and not self.saw:
            words = [f"contours every {ground.contour_interval:g} m", attribution(self.run.provenance)]
            overlay.note("; ".join(filter(None, words)), other)
        else:
            overlay.length_scale(self.action.size_in(camera), other, about=True)
        return overlay.picture()

    def cut_away(self):
        """The same view with the weak layer by its damage, and what lies over it on the near side left out. Raises
        InputError for a run without a weak layer, or with nothing over it."""
        other = copy.copy(self)
        other.colour_by(FRACTURE)
        other.cut = Cutaway.of(self.run, other.layer, self.camera)
        return other

    @property
    def near(self):
        """The side (1, -1) of y that the camera stands on, and the handle of a saw."""
        return 1.0 if -self.camera.axes[2, 1] >= 0.0 else -1.0

    def _behind(self, i, camera, snow, sky=light.sky):
        """`Ground` with the solids of frame `i`, as a camera sees them, below its snow as of `_frame`."""
        known = self.path is None and sky is light.sky
        ground = self.ground if known else self._drawn_ground(camera, sky)
        points, spacing, colours, _ = snow
        if colours is not None and colours.shape[1] == 4:  # a sheet shows by itself how thick it is
            points = None
        return draw_solids(ground.at(self.run.times[i], points, spacing), camera, self.sun, *self.solids(i))

    def whole_relief(self):
        """`Relief` of all the terrain, not only of what the picture shows; None without."""
        if self.terrain is None:
            return None
        plan = np.asarray(self.terrain.vertices)[np.unique(self.terrain.facets), :2]
        return build_relief(self.terrain, plan.min(axis=0), plan.max(axis=0))

    def _drawn_ground(self, camera, sky=light.sky):
        return draw_ground(self.relief, camera, self.sun, sky, self.cover)
