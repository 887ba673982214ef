"""The picture of the ground: drawn once for a film, because camera and terrain stand still."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.camera import Camera
from snowmpm.render.raster import rasterise
from snowmpm.render.winter import SnowCover

OVERSAMPLING = 2
MEADOW = light.decode([0.62, 0.63, 0.54])
SCREE = light.decode([0.60, 0.57, 0.53])
ROCK = light.decode([0.47, 0.45, 0.45])
EARTH = light.decode([0.40, 0.34, 0.29])  # of the walls below the rim
BEDROCK = light.decode([0.30, 0.29, 0.30])
CONTOURS = 14  # about so many over the height of the picture
SNOW_RELIEF = 0.35  # of the roughness and contours of bare ground: snow fills what is small
RIM = 3  # px: width of the rim of a track
LEVEL = 1e-3  # rise over extent below which ground has no contours


@dataclass(frozen=True)
class Ground:
    """light (height, width, 3); depth (height, width) [m] along the view, inf where the sky is seen.

    camera: what it was drawn by
    bare   (height, width, 3): light of the same without its snow, None where it has none; cover: its `SnowCover`
    slack  (height, width): snow shows down to so many of its diameters behind the depth: 1, -1 where the ground is seen
           from below, as past the edge of an open surface, 0 on an obstacle
    """

    light: np.ndarray
    depth: np.ndarray
    slack: np.ndarray
    camera: Camera
    contour_interval: float = 0.0
    bare: np.ndarray | None = None
    cover: SnowCover | None = None

    def at(self, time, points=None, spacing=1.0):
        """The same at a time [s]: bare where the flow has swept its snow away, and left none of its own.

        points (n, 3) of the snow there then, a `spacing`, one or (n,), apart [m]; None: as if there were none
        """
        if self.bare is None:
            return self
        window, when, change = self._swept
        swept = (when <= time).astype(np.float32)
        if points is not None and swept.any():
            row, column = self._cells
            swept *= 1.0 - self.cover.left(points, spacing)[row, column]
        share = ndimage.uniform_filter(swept, RIM)
        picture = self.light.copy()
        picture[window] += share[..., None] * change
        return replace(self, light=picture, bare=None, cover=None)

    @cached_property
    def _swept(self):
        """(window, times, change): slices of the picture with all of the track, times [s] when it was swept, and what
        that adds to its light."""
        when = np.full(self.depth.shape, np.inf, np.float32)
        when[self.takes_sun] = self.cover.when(self.places)
        lines = [np.flatnonzero(np.isfinite(when).any(axis=axis)) for axis in (1, 0)]
        if not len(lines[0]):
            return (slice(0, 0), slice(0, 0)), when[:0, :0], self.light[:0, :0]
        window = tuple(slice(max(int(line[0]) - RIM, 0), int(line[-1]) + RIM + 1) for line in lines)
        return window, when[window], self.bare[window] - self.light[window]

    @cached_property
    def _cells(self):
        """(rows, columns) of the cover's raster that the pixels of the window show; anything where they show none."""
        window = self._swept[0]
        found = np.zeros((2, *self.depth.shape), np.int32)
        found[:, self.takes_sun] = self.cover.cells(self.places)
        return found[0][window], found[1][window]

    @cached_property
    def takes_sun(self):
        """Where (height, width) snow may take its sun: what is seen from below has none."""
        return np.isfinite(self.depth) & (self.slack >= 0.0)

    @cached_property
    def places(self):
        """Places (n, 3) [m] of the pixels that take sun."""
        return self.camera.places(self.depth, self.takes_sun)


def draw_ground(relief, camera, sun, sky=light.sky, cover=None):
    """The ground as `camera` sees it, lit from `sun` (3,), smoothed by drawing it larger; sky(size): what is behind;
    cover: `SnowCover` on it, or None."""
    backdrop = sky(camera.size)
    if relief is None:
        nothing = np.full(backdrop.shape[:2], np.inf, np.float32)
        return Ground(backdrop, nothing, np.ones(nothing.shape), camera)
    large = camera.enlarged(OVERSAMPLING)
    raster, depth, underside = seen_facets(relief, large)
    interval = contour_interval(relief.heights, relief.cell * max(relief.heights.shape))
    rows, columns = camera.size[1], camera.size[0]
    blocks = (rows, OVERSAMPLING, columns, OVERSAMPLING)
    smaller = []
    for shade in _shades(relief, raster, sun, interval, cover):
        picture = sky(large.size)
        picture[raster.hit] = shade
        smaller.append(picture.reshape(*blocks, 3).mean(axis=(1, 3)))
    underside &= raster.facet < relief.ground if relief.ground is not None else True
    slack = np.where(underside.reshape(blocks).any(axis=(1, 3)), -1.0, 1.0)
    bare, *covered = smaller
    return Ground(covered[0] if covered else bare, depth.reshape(blocks).min(axis=(1, 3)), slack, camera, interval,
                  bare if covered else None, cover)


def contour_interval(heights, extent):
    """A round distance in height [m] between contour lines, for about CONTOURS of them over ground of that extent [m]
    in plan; 0, none, on a level floor."""
    rise = float(np.nanmax(heights) - np.nanmin(heights))
    return _nice(rise / CONTOURS) if rise > LEVEL * extent else 0.0


def ground_colour(relief, vertices, sun, cover=None):
    """Light (n, 3) from the ground at vertices (n, 3) on it, lit from `sun`; with a cover, as it is at the end."""
    x, y = vertices[:, 0], vertices[:, 1]
    normal = relief.normal(x, y)
    sunlight = relief.sample(relief.sunlight(sun), x, y, 1.0).astype(np.float32)
    openness = relief.sample(relief.openness, x, y, 1.0).astype(np.float32)
    grain = ground_noise(vertices.astype(np.float32), relief.cell)
    albedo = bare_albedo(normal, grain)
    if cover is not None:
        bare = np.isfinite(cover.when(vertices))[:, None]
        albedo = np.where(bare, albedo, cover.over(albedo, grain, normal))
    return albedo * light.illuminate(normal, sun, softness=0.1, sunlight=sunlight, openness=openness)


def plan_colours(relief, cover, most):
    """(colours (rows, columns, 3) in linear light, lower, upper): the unlit ground in plan, row 0 in the south, at most
    so many pixels along its longer side, and the corners (2,) [m] of what it shows; with a `SnowCover` or None."""
    extent = relief.cell * (np.array(relief.heights.shape[::-1]) - 1.0)
    columns, rows = np.maximum(np.round(most * extent / extent.max()), 2).astype(int)
    low = np.array([relief.x0, relief.y0])
    y, x = (side.ravel() for side in np.meshgrid(low[1] + extent[1] * (np.arange(rows) + 0.5) / rows,
                                                 low[0] + extent[0] * (np.arange(columns) + 0.5) / columns,
                                                 indexing="ij"))
    normal = relief.normal(x, y)
    # Noise is in plan: the height counts for nothing
    point = np.column_stack([x, y, np.zeros(len(x))]).astype(np.float32)
    grain, rough = ground_noise(point, relief.cell), roughness(point, relief.cell)
    albedo, relieved = bare_albedo(normal, grain), 1.0
    if cover is not None:
        albedo, relieved = cover.over(albedo, grain, normal), SNOW_RELIEF
    albedo *= (1.0 + relieved * (rough - 1.0))[:, None]
    return albedo.reshape(rows, columns, 3), low, low + extent


def seen_facets(relief, camera):
    """Raster of facets, their depth [m] at each pixel, inf where there are none, and where they turn their back."""
    x, y, depth = camera.project(relief.vertices)
    nearest = 0.02 * float(np.median(depth))
    if camera.perspective:
        nearness = np.where(depth > nearest, 1.0 / np.maximum(depth, nearest), 0.0)
    else:
        nearness = depth.max() + 1.0 - depth
    raster = rasterise(x, y, nearness, relief.facets, camera.size, camera.perspective)
    seen = np.full(raster.facet.shape, np.inf, np.float32)
    seen[raster.hit] = raster.interpolate(depth, relief.facets)
    # Facets face up: seen from above they turn one way on the picture, from below the other.
    corners = np.stack([x, y], axis=1)[relief.facets]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turned = np.append(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0.0, False)
    return raster, seen, turned[raster.facet]


def _shades(relief, raster, sun, interval, cover):
    """Light (n, 3) from the bare ground at the pixels that show it, and with a cover, from the covered one."""
    point = raster.interpolate(relief.vertices, relief.facets).astype(np.float32)
    normal = raster.interpolate(relief.normals, relief.facets).astype(np.float32)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    sunlight = relief.sample(relief.sunlight(sun), point[:, 0], point[:, 1], 1.0).astype(np.float32)
    openness = relief.sample(relief.openness, point[:, 0], point[:, 1], 1.0).astype(np.float32)
    grain, lines = ground_noise(point, relief.cell), 0.4 * _contours(point, raster, interval)
    bare = bare_albedo(normal, grain)
    albedos = [bare, *([] if cover is None else [cover.over(bare, grain, normal)])]
    rough = roughness(point, relief.cell)
    if relief.ground is not None:
        wall = raster.facet[raster.hit] >= relief.ground
        strata, openness[wall] = _strata(point[wall], relief), 1.0
    shading = light.illuminate(normal, sun, softness=0.1, sunlight=sunlight, openness=openness)
    for albedo, relieved in zip(albedos, (1.0, SNOW_RELIEF), strict=False):
        albedo *= ((1.0 - relieved * lines) * (1.0 + relieved * (rough - 1.0)))[:, None]
        if relief.ground is not None:
            albedo[wall] = strata * rough[wall, None]
        yield albedo * shading


def _strata(point, relief):
    """Earth on rock, with faint layers that follow the ground."""
    heights = np.where(np.isfinite(relief.heights), relief.heights, ndimage.maximum_filter(
        np.nan_to_num(relief.heights, nan=-np.inf), 5))
    below = np.maximum(relief.sample(heights, point[:, 0], point[:, 1], 0.0) - point[:, 2], 0.0) / relief.cell
    share = np.clip(below / 18.0, 0.0, 1.0)[:, None].astype(np.float32)
    layers = 1.0 + 0.08 * np.sin(1.3 * below + 1.5 * np.sin(0.31 * below))[:, None]
    return ((EARTH + share * (BEDROCK - EARTH)) * layers).astype(np.float32)


def roughness(point, cell):
    """Brightness around 1 of stones and tufts smaller than the cells of the terrain, as if they rose and fell."""
    table = np.random.default_rng(11).random((256, 256)).astype(np.float32)
    total = np.ones(len(point), np.float32)
    for size, weight in ((1.6, 0.30), (0.55, 0.24)):
        at = np.stack([point[:, 1], point[:, 0]]) / (size * cell)
        here, there = (ndimage.map_coordinates(table, (at + k), order=1, mode="grid-wrap") for k in (0.0, 0.5))
        total += weight * (there - here)
    return total


def bare_albedo(normal, grain):
    """Meadow on gentle ground, scree above 30 degrees, rock above 45, with a grain (n,) that gives the eye a scale."""
    slope = np.degrees(np.arccos(np.clip(normal[:, 2], -1.0, 1.0)))
    steep = np.clip((slope + 10.0 * (grain - 0.5) - 18.0) / 16.0, 0.0, 1.0)[:, None]
    rock = np.clip((slope + 14.0 * (grain - 0.5) - 38.0) / 10.0, 0.0, 1.0)[:, None]
    colour = MEADOW + steep * (SCREE - MEADOW)
    colour = colour + rock * (ROCK - colour)
    return colour * (0.86 + 0.28 * grain[:, None])


def ground_noise(point, cell):
    """Fixed noise in [0, 1] over plan positions, from patches of the region down to single cells."""
    table = np.random.default_rng(7).random((256, 256)).astype(np.float32)
    total = np.zeros(len(point), np.float32)
    for size, weight in ((40.0, 0.25), (12.0, 0.25), (4.0, 0.3), (1.2, 0.2)):
        at = np.stack([point[:, 1], point[:, 0]]) / (size * cell)
        total += weight * ndimage.map_coordinates(table, at, order=1, mode="grid-wrap")
    return np.clip(0.5 + 1.6 * (total - 0.5), 0.0, 1.0)


def _contours(point, raster, interval):
    """Strength [0, 1] of a contour line at each pixel, one pixel and a half wide; every fifth is stronger."""
    if not interval:
        return np.zeros(len(point), np.float32)
    height = np.full(raster.facet.shape, np.nan, np.float32)
    height[raster.hit] = point[:, 2]
    change = np.zeros_like(height)
    for axis in (0, 1):
        change += np.abs(np.gradient(height, axis=axis))
    change = np.nan_to_num(change[raster.hit], nan=interval)
    number = point[:, 2] / interval
    off = np.abs(number - np.round(number)) * interval / np.maximum(change, 1e-9)
    line = np.clip(1.6 - off, 0.0, 1.0) * np.clip(2.0 - 12.0 * change / interval, 0.0, 1.0)
    return line * np.where(np.round(number) % 5 == 0, 1.0, 0.55)


def _nice(value):
    """1, 2 or 5 times a power of ten, at most `value` or little above."""
    power = 10.0 ** np.floor(np.log10(max(value, 1e-6)))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(np.log(step * power / max(value, 1e-6)))))
