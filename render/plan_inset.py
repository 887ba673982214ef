"""The map in a corner of a picture, where the terrain is much larger than what the camera shows."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render.framing import moving_samples
from snowmpm.render.overlay import EDGE, bands, ticks, unit_of
from snowmpm.render.plan_map import VIEW, PlanMap, in_picture
from snowmpm.render.winter import SnowCover

WISHES = ("auto", "on", "off")
LARGE = 0.25
"""Share of the terrain's area in plan that the camera shows, below which a map comes by itself."""

FACETS = 50
"""Triangles of a terrain below which it is a plane, on which a map shows no way."""

MOST = 8.0
"""Sides of the map over the extent of the action: on a larger one it would be a dot."""

SIDES = (0.30, 0.42)
"""Of the picture's width and height that the map takes at most."""

AREA = 0.08
"""Of the picture's area that it takes at most."""

SMALLER = (1.0, 0.8, 0.64)
"""Sizes that are tried, where a larger one hides snow."""

HIDDEN = 0.002
"""Share of the moving snow in the picture, at any time, that it may hide."""

SAMPLED = 20_000
"""Facets of the terrain that are asked whether the camera shows them."""


@dataclass(frozen=True)
class PlanInset:
    """plan: its `PlanMap`; position: (left, top) [px]; lower, upper (2,): plan box of the ground that is drawn [m]."""

    plan: PlanMap
    position: tuple[int, int]
    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def of(cls, view, wish):
        """The inset of a `SpaceView`, or None. wish: one of WISHES; "auto" is where the camera shows less than
        LARGE of the terrain, and where it hides no moving snow.

        Raises InputError for "on" without terrain.
        """
        terrain = view.terrain
        if wish == "off" or (wish == "auto" and (terrain is None or len(terrain.facets) < FACETS)):
            return None
        if terrain is None or view.relief is None:
            raise InputError.at("inset", wish, f"{view.run.path}: has no terrain, of which a map could be")
        seen = _seen(view)
        box = view.action.box()
        if wish == "auto" and not share_shown(terrain, [camera for camera, _ in seen], *box) < LARGE:
            return None
        lower, upper = _map_box(terrain, view.action.points[:, :2])
        largest = _pixels_per_metre(view.size, upper - lower)
        for smaller in SMALLER:
            scale = smaller * largest
            shape = tuple(np.maximum(np.ceil(scale * (upper - lower)).astype(int), 2).tolist())
            hidden, position = _corner(view.size, shape, seen)
            if hidden <= HIDDEN:
                break
        if hidden > HIDDEN and wish == "auto":
            return None
        cover = view.cover or SnowCover.of(view.run, view.relief, view.spacing)
        plan = PlanMap.of(terrain, cover, lower, shape, 1.0 / scale, view.spacing)
        return None if plan is None else cls(plan, position, *box)

    def draw(self, overlay, time, points, camera):
        """Put the map at a time [s] on an `Overlay`, with snow at `points` (n, 3) and what `camera` shows."""
        picture = self.plan.picture(time, points, self.plan.shown(camera, self.lower, self.upper))
        overlay.inset(picture, self.position)
        rows, columns = picture.shape[:2]
        left, top = self.position
        row, column, inside = self.plan.pixels(camera.eye[0], camera.eye[1])
        if inside and camera.perspective:
            x, y, r = left + int(column), top + rows - 1 - int(row), overlay.px(4)
            overlay.draw.ellipse([x - r, y - r, x + r, y + r], fill=VIEW, outline=(255, 255, 255))
        rim, size = overlay.px(7), overlay.px(8)
        x, y = left + columns - rim - size, top + rim
        overlay.draw.polygon([(x, y), (x - size // 2, y + size), (x + size // 2, y + size)], fill=(24, 34, 46))
        overlay.text((x, y + size), "N", 12, "ma", bold=True)
        length = ticks(0.0, 0.4 * columns * self.plan.cell)[1]
        end, foot = left + rim + length / self.plan.cell, top + rows - rim
        overlay.draw.line([left + rim, foot, end, foot], (255, 255, 255), overlay.px(5))
        overlay.draw.line([left + rim, foot, end, foot], (24, 34, 46), overlay.px(2))
        words = f"{length:g} m" if length < 1000.0 else f"{length / 1000.0:g} km"
        overlay.text((left + rim, foot - overlay.px(4)), words, 12, "ls")


def share_shown(terrain, cameras, lower, upper):
    """Share of the area in plan of `snowmpm.io.Terrain` that a camera shows, of the part in a plan box that is drawn:
    the median of some `cameras`."""
    facets = terrain.facets[:: max(1, len(terrain.facets) // SAMPLED)]
    corners = np.asarray(terrain.vertices, float)[facets]
    a, b = (corners[:, k, :2] - corners[:, 0, :2] for k in (1, 2))
    area, middle = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), corners.mean(axis=1)
    drawn = ((middle[:, :2] >= lower) & (middle[:, :2] <= upper)).all(axis=1)
    shown = [area[drawn & in_picture(camera, middle)].sum() for camera in cameras]
    return float(np.median(shown) / max(area.sum(), 1e-30))


def _seen(view):
    """[(camera, points (n, 3))]: what a film shows of the moving snow, and of obstacles near it."""
    if view.path is None:
        return [(view.camera, view.action.points)]
    return [(view.path.camera(time, view.size), points) for time, points in moving_samples(view.run)]


def _map_box(terrain, plan):
    """Plan corners (2,) of the terrain, no further than MOST extents of the action at `plan` (n, 2)."""
    low, high = plan.min(axis=0), plan.max(axis=0)
    half = 0.5 * MOST * float(np.max(high - low))
    ground = np.asarray(terrain.vertices, float)[:, :2]
    middle = 0.5 * (low + high)
    return np.maximum(ground.min(axis=0), middle - half), np.minimum(ground.max(axis=0), middle + half)


def _pixels_per_metre(size, extent):
    width, height = size
    return float(min(SIDES[0] * width / extent[0], SIDES[1] * height / extent[1],
                     np.sqrt(AREA * width * height / (extent[0] * extent[1]))))


def _corner(size, shape, seen):
    """(share of the moving snow that a map of `shape` hides at most, position) of the corner where it hides least."""
    width, height = size
    rim, (above, below) = round(EDGE * unit_of(size)), bands(size)
    right, low = width - rim - shape[0], round(height * (1.0 - below)) - rim - shape[1]
    corners = [(right, rim), (right, low), (rim, low), (rim, round(height * above) + 2 * rim)]
    return min(((_hides(seen, corner, shape, rim // 2), corner) for corner in corners), key=lambda found: found[0])


def _hides(seen, corner, shape, margin):
    shares = []
    for camera, points in seen:
        x, y, _ = camera.project(points)
        inside = ((x > corner[0] - margin) & (x < corner[0] + shape[0] + margin)
                  & (y > corner[1] - margin) & (y < corner[1] + shape[1] + margin))
        shares.append(inside.sum() / max(in_picture(camera, points).sum(), 1))
    return float(max(shares))
