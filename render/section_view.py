"""Pictures of a run in plane strain."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render import light
from snowmpm.render.overlay import Overlay
from snowmpm.render.section import Profile, draw_section
from snowmpm.render.tracking import plan_track
from snowmpm.render.view import View

INSET = 0.30  # of the picture's sides


class SectionView(View):
    """Plane-strain runs: the section, and an inset with the whole of it when the view is close."""

    def __init__(self, run, size, color, camera, track=None, quality=None, inset="auto"):
        """track: the moving view, by default that of the run (`tracking.plan_track`); quality: a `Quality`; inset:
        whether the whole section stands in a corner, "on", "off" or, where the view is close, "auto"."""
        super().__init__(run, size, color)
        self.quality = quality or self.quality
        if camera not in ("auto", "side"):
            raise InputError.at("camera", camera, "must be auto or side for a run in two dimensions")
        self.profile = Profile.of(self.terrain)
        self.track = track or plan_track(run, self.profile, self.spacing, size, close=camera == "auto")
        self.inset = inset == "on" or (inset == "auto" and self.track.close)

    def picture(self, i):
        """(height, width, 3) uint8 of frame `i`."""
        time, snow = self._frame(i)
        camera, snow = self.track.camera(i), (*snow, self.solids(i))
        overlay = Overlay(self._section(camera, snow))
        if self.plain:
            return overlay.picture()
        # A saw comes from the left
        side = "right" if self.track.falls_left or self.saw else "left"
        if self.inset:
            self._inset(overlay, camera, snow)
        self._point_at_saw(overlay, camera, time)
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
