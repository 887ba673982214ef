"""The view of a film camera on a run in three dimensions: `CinemaView`."""

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.errors import InputError
from snowmpm.render import light
from snowmpm.render.cinema.body import Body, clods, flow_body, snow_body
from snowmpm.render.cinema.landscape import build_landscape, sky_of
from snowmpm.render.cinema.shade import Air, FromAbove, ground_light, snow_light, solid_light
from snowmpm.render.cinema.solids import Solids
from snowmpm.render.cinema.studio import Lens, Part, Studio
from snowmpm.render.crumble import few_around
from snowmpm.render.framing import Stance
from snowmpm.render.overlay import Overlay
from snowmpm.render.shadow import Shadow
from snowmpm.render.sheet import FINE, sheet_points, sheet_raster
from snowmpm.render.snow import BALL, SNOW
from snowmpm.render.space_view import SpaceView
from snowmpm.render.view import particle_spacing, piled

SHOTS = 8
"""Of a picture."""

OPEN = 0.5
"""Share of the time between two pictures in which the shutter is open, as of film cameras."""

SLOWEST = 1.0 / 24.0
"""Time [s] between two pictures at most, for the shutter: frames that are farther apart do not blur more."""

MADE_UP = 0.3
"""Haze over ground that is made up, besides that of its distance."""

APERTURE = 0.0004
"""Radius of the lens, of the distance to the action: soft before and behind it, but only in close views."""

CLODS = 2.0
"""Pixels of a spacing from which on loose particles are clods; smaller ones are part of the surface."""

FEW = 40
"""Particles around one below which it is a clod by itself (`few_around`): fewer than at the edge of a heap."""

THINNEST = 0.03
"""Opacity of a sheet from which on it is drawn: thinner snow is that of the ground."""

FINER = 3
"""Vertices of the surface of a sheet for one of its places, each way."""

FINEST = 3.0
"""Longest edge of an obstacle's triangles, in cells of the relief, for the edges of shadows on it."""

BESIDE = 0.05
"""Of the sides of the picture: how far beside it the ground is still drawn, for the lens and for pixels."""


class CinemaView(SpaceView):
    """As `SpaceView`, lit like a photograph: haze, sky, depth of field, motion blur, light within the snow."""

    # Low, so that there is a horizon
    stance = Stance((3.0, 8.0, 14.0, 22.0), field_of_view=0.85, margins=(0.08, 0.08, 0.26, 0.08), whole=False,
                    usual=3.0)
    sun_at = (0.1, 24.0)  # a low sun from the side: its shadows show the relief

    def __init__(self, run, size, color=None, camera="auto", path=None, ground="auto", quality=None):
        super().__init__(run, size, color or "snow", camera, path=path, ground=ground, drawn=False, quality=quality)
        if self.relief is None:
            raise InputError.at("look", "cinematic", f"is of runs with ground; {run.path} has none")
        self.studio = Studio()
        self.lens_shots = 1 if self.quality.coarse > 1 else SHOTS

    @cached_property
    def landscape(self):
        return build_landscape(self.relief, self.terrain, self.sun, self.cover, self.quality.coarse)

    @cached_property
    def _seen_faces(self):
        """Triangles of the landscape before a camera that stands still."""
        x, y, depth = self.camera.project(self.landscape.vertices)
        width, height = self.size
        corners = [part[self.landscape.faces] for part in (x, y, depth)]
        aside = np.zeros(len(self.landscape.faces), bool)
        for part, most in zip(corners[:2], (width, height), strict=True):
            aside |= (part < -BESIDE * most).all(axis=1) | (part > (1.0 + BESIDE) * most).all(axis=1)
        behind = (corners[2] <= 0.0).all(axis=1) if self.camera.perspective else np.zeros(len(aside), bool)
        # Of what reaches behind the camera, the places on the picture mean nothing
        across = (corners[2] <= 0.0).any(axis=1) & self.camera.perspective
        return self.landscape.faces[~behind & (across | ~aside)]

    @cached_property
    def _at_first(self):
        """(numbers (n,), ascending, places (n, 3)) of the particles in the first frame that has any."""
        frame = self.run.frame(next(i for i in range(len(self.run)) if self.run.n_points(i)), ["id"])
        order = np.argsort(frame.fields["id"], kind="stable")
        return frame.fields["id"][order], frame.points[order]

    def _reference(self, points, identity):
        """Where particles (n, 3) with numbers (n,) were at first; where they are, for those that came later."""
        numbers, places = self._at_first
        at = np.searchsorted(numbers, identity).clip(0, len(numbers) - 1)
        return np.where((numbers[at] == identity)[:, None], places[at], points)

    def picture(self, i):
        """(height, width, 3) uint8 of frame `i`."""
        time = float(self.run.times[i])
        camera = self.camera if self.path is None else self.path.camera(time, self.size)
        seen = self.quality.camera(camera)
        middle = 0.5 * (self.action.points.min(axis=0) + self.action.points.max(axis=0))
        distance = float(abs((middle - camera.eye) @ camera.axes[2]))
        air = Air(seen, distance)
        body, albedo, points, radius = self._snow(i, seen)
        solids = self._solids.at(i, self.near)
        all_points = np.concatenate([points, *(solid.vertices for solid in solids)])
        shadow, above = Shadow.of(all_points, radius, self.sun), FromAbove.of(self.relief, points, radius)
        land = self.landscape
        faces = land.faces if self.path is not None else self._seen_faces
        bare = self._swept(time, points, radius)
        parts = {"ground": Part(land.vertices, faces,
                                air.before(ground_light(land, self.sun, shadow, above, bare), land.vertices,
                                           MADE_UP * land.made_up))}
        passing = [Part(body.vertices, body.faces, air.before(snow_light(body, albedo, self.sun, shadow, above),
                                                              body.vertices), body.velocity)]
        for solid in solids:
            lit = solid_light(solid, self.sun, shadow, above, 2.0 * radius)
            passing.append(Part(solid.vertices, solid.faces, air.before(lit, solid.vertices), None, solid.st,
                                solid.picture))
        lens = Lens(self.lens_shots, self._shutter(i), APERTURE * distance, self._focus(camera, points, distance))
        picture = light.encode(self.studio.shoot(parts, passing, seen, lens, sky_of(seen, self.sun)))
        overlay = Overlay(self.quality.enlarged(picture, camera.size))
        if not self.plain:
            self._legend(overlay, time, self.side)
        return overlay.picture()

    def _snow(self, i, camera):
        """(body, albedo (n, 3), points (k, 3), radius [m]) of frame `i`; a body as of `body.snow_body`."""
        extra = [name for name in ("velocity", "id", "depth") if name in self.run.field_names]
        names = dict.fromkeys([*([] if self.scale is None else [self.scale.field]), *extra])
        frame = self.run.frame(i, names)
        good = np.isfinite(frame.points).all(axis=1)
        thin = self.quality.share(self.most_points) if "depth" not in frame.fields else 1
        if thin > 1:
            good &= frame.fields.get("id", np.arange(len(good))) % thin == 0
        points, spacing = frame.points[good], particle_spacing(self.run, frame.time) * thin ** (1.0 / 3.0)
        velocity = frame.fields["velocity"][good] if "velocity" in frame.fields else np.zeros_like(points)
        identity = frame.fields["id"][good] if "id" in frame.fields else None
        colours = np.tile(SNOW, (len(points), 1))
        if self.scale is not None:
            share = np.nan_to_num(self.scale.share(self.scale.numbers(frame)[good]))
            colours = self.table[np.round(255 * share).astype(int)]
        if not len(points):
            return Body.of([]), colours, points, BALL * spacing
        if "depth" in frame.fields:
            return self._flow(frame.fields["depth"][good].ravel(), points, velocity, spacing, colours)
        pixels = spacing * float(np.median(camera.pixels_per_metre(camera.project(points)[2])))
        loose = few_around(points, spacing, FEW) & (pixels > CLODS)
        known = identity is not None
        reference = self._reference(points, identity) if known else points
        if known:  # The edges of a block that has not moved are no rubble
            loose &= np.linalg.norm(points - reference, axis=1) > spacing
        coarse = self.quality.coarse > 1
        bodies = [snow_body(points, velocity, spacing, reference, loose, pixels, coarse)]
        if loose.any():
            bodies.append(clods(points[loose], velocity[loose], spacing, identity[loose] if known else None, pixels))
        body = Body.of(bodies)
        return body, self._albedo(body, points, colours), points, BALL * spacing

    def _flow(self, depth, points, velocity, spacing, colours):
        """The same of columns of a depth-averaged flow, as one sheet."""
        depth = np.nan_to_num(depth)
        coarse = self.quality.coarse > 1
        sheet = sheet_raster(points, depth, spacing, colours, self.relief.height, 1 if coarse else FINE)
        if sheet is None:
            places, cell = piled(points, depth, spacing)[0], spacing
            body = snow_body(places, np.zeros_like(places), cell, places, size_px=4.0, coarse=coarse)
        else:
            places, cell, shade = sheet_points(sheet)
            places = places[shade[:, 3] > THINNEST]
            body = flow_body(sheet, self.relief.height, 1 if coarse else FINER)
        return body, self._albedo(body, points, colours), places, BALL * cell

    def _albedo(self, body, points, colours):
        if self.scale is None or not len(body.vertices):
            return SNOW
        return colours[cKDTree(points).query(body.vertices)[1]]

    def _swept(self, time, points, radius):
        """Share (n,) of the snow on the ground that is gone, at the vertices of the landscape."""
        if self.cover is None:
            return np.zeros(len(self.landscape.vertices), np.float32)
        bare = (self.landscape.when <= time).astype(np.float32)
        if len(points) and bare.any():
            row, column = self.cover.cells(self.landscape.vertices)
            bare *= 1.0 - self.cover.left(points, radius / BALL)[row, column]
        return bare

    @cached_property
    def _solids(self):
        return Solids(self.run, self.saw, min(FINEST * self.relief.cell, 1.5 * BALL * self.spacing))

    def _shutter(self, i):
        """Time [s] of the run for which the shutter is open in frame `i`."""
        if self.lens_shots == 1 or len(self.run) < 2:
            return 0.0
        apart = np.diff(self.run.times)[min(i, len(self.run) - 2)]
        return OPEN * min(float(apart), SLOWEST)

    def _focus(self, camera, points, distance):
        """Distance [m] along the view that is sharp: that of the snow in sight."""
        if not len(points):
            return distance
        x, y, depth = camera.project(points)
        there = (x > 0) & (x < camera.size[0]) & (y > 0) & (y < camera.size[1]) & (depth > 0)
        return float(np.median(depth[there])) if there.any() else distance
