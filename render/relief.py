"""The ground of a run, ready to draw: cut to the region of interest, with smooth normals and a raster of heights."""

import weakref
from collections import deque
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.raster import rasterise

WALL = 0.04  # height of the walls at the rim, as a share of the region
CELLS = 360  # of the height raster, along its longer side
NORTH_WEST = np.array([-0.58, 0.58, 0.58])  # light on maps
FLAT = 1e-4  # determinant of the places around a cell, in squares of the width, below which they make no plane
EDGE_SHARE = 1.0 / 40.0  # longest facet edge allowed, as a share of the region
_REMEMBERED: deque[Any] = deque(maxlen=2)


@dataclass(frozen=True)
class Relief:
    """Ground in a box in plan.

    vertices (n, 3), normals (n, 3) upward, facets (m, 3); from facet number `ground` on they are walls below the rim,
             with normals outward, which show that the ground was cut there
    heights  (rows, columns) [m], NaN in holes; row i at y0 + i cell, column j at x0 + j cell
    """

    vertices: np.ndarray
    normals: np.ndarray
    facets: np.ndarray
    heights: np.ndarray
    x0: float
    y0: float
    cell: float
    ground: int | None = None

    def height(self, x, y, outside=-np.inf):
        """Ground height at plan positions, `outside` beyond the box and in holes."""
        return self.sample(self.heights, x, y, outside)

    def normal(self, x, y):
        """Unit normals (n, 3) float32 of the ground at plan positions (n,)."""
        ground = np.where(np.isfinite(self.heights), self.heights, np.nanmean(self.heights))
        rise_y, rise_x = (self.sample(rise, x, y, 0.0) for rise in np.gradient(ground, self.cell))
        normal = np.column_stack([-rise_x, -rise_y, np.ones(len(rise_x))])
        return (normal / np.linalg.norm(normal, axis=1, keepdims=True)).astype(np.float32)

    def sample(self, raster, x, y, outside):
        """A raster of the relief's shape at plan positions, bilinear."""
        at = np.stack([(np.asarray(y) - self.y0) / self.cell, (np.asarray(x) - self.x0) / self.cell])
        found = ndimage.map_coordinates(raster, at, order=1, mode="constant", cval=np.nan)
        return np.where(np.isfinite(found), found, outside)

    def visible(self, points, eye, steps=96, clearance=0.0):
        """Whether each of `points` (n, 3) sees `eye` (3,) over the ground; `clearance` [m] lifts the points."""
        points = points + np.array([0.0, 0.0, clearance])
        free = np.ones(len(points), bool)
        for share in np.linspace(0.0, 1.0, steps + 1)[1:] ** 1.5:
            between = points + share * (eye - points)
            free &= self.height(between[:, 0], between[:, 1]) <= between[:, 2]
        return free

    def facing(self, points, eye):
        """Cosine (n,) of the angle between the ground's normal at `points` (n, 3) and their way to `eye` (3,)."""
        rise_y, rise_x = (self.sample(rise, points[:, 0], points[:, 1], 0.0)
                          for rise in np.gradient(self.heights, self.cell))
        normal = np.column_stack([-rise_x, -rise_y, np.ones(len(points))])
        way = np.asarray(eye) - points
        return (normal * way).sum(axis=1) / (np.linalg.norm(normal, axis=1) * np.linalg.norm(way, axis=1))

    def sunlight(self, sun):
        """Raster in [0, 1]: share of the sun's disc, blurred a little, above the ground in direction `sun` (3,)."""
        rows, columns = np.indices(self.heights.shape)
        ground = np.where(np.isfinite(self.heights), self.heights, np.nanmin(self.heights))
        rise = sun[2] / np.hypot(sun[0], sun[1])
        clear = np.ones(ground.shape)
        reach = int(min(max(ground.shape), np.ptp(ground) / max(rise * self.cell, 1e-9) + 2))
        for step in np.unique(np.round(np.linspace(1, reach, min(reach, 120)))):
            shift = step * np.array([sun[1], sun[0]]) / np.hypot(sun[0], sun[1])
            there = ndimage.map_coordinates(ground, [rows + shift[0], columns + shift[1]], order=1, mode="nearest")
            above = (ground + rise * step * self.cell - there) / (0.04 * step * self.cell + 0.3 * self.cell)
            clear = np.minimum(clear, np.clip(0.5 + 0.5 * above, 0.0, 1.0))
        return ndimage.gaussian_filter(clear, 0.8)

    @cached_property
    def openness(self):
        """Raster 1 on planes up to their rim, below it in gullies and above it on ridges: how much sky the ground
        sees; 1 in holes."""
        total = np.ones(self.heights.shape)
        for width in (2.0, 6.0, 18.0):
            hollow = (plane_around(self.heights, width) - self.heights) / (width * self.cell)
            total -= 0.9 * np.clip(np.nan_to_num(hollow), -0.15, 0.3)
        return total


def plane_around(heights, width):
    """At each cell of a raster of heights (rows, columns), NaN in holes, the height there of the plane that fits those
    around it best, by weights of a Gaussian of `width` [cells]: away from rims and holes the Gaussian mean itself."""
    known = np.isfinite(heights)
    values = np.where(known, heights, 0.0)
    row, column = np.indices(heights.shape, dtype=float)
    ones = known.astype(float)

    def mean(weights):
        return ndimage.gaussian_filter(weights, width, mode="constant")

    # Moments about each cell from those about the corner of the raster
    share, rise = mean(ones), mean(values)
    about = {}
    for name, at in (("r", row), ("c", column)):
        about[name], about["h" + name] = mean(ones * at) - at * share, mean(values * at) - at * rise
    for name, a, b in (("rr", row, row), ("rc", row, column), ("cc", column, column)):
        about[name] = mean(ones * a * b) - a * mean(ones * b) - b * mean(ones * a) + a * b * share
    # By Cramer's rule; where the heights lie on a line or in a point, their mean
    r, c, rr, rc, cc = (about[name] for name in ("r", "c", "rr", "rc", "cc"))
    minor = rr * cc - rc**2, r * cc - c * rc, r * rc - c * rr
    whole = share * minor[0] - r * minor[1] + c * minor[2]
    fitted = rise * minor[0] - about["hr"] * minor[1] + about["hc"] * minor[2]
    flat = whole > FLAT * width**4 * share**3
    found = np.where(flat, fitted / np.where(flat, whole, 1.0), rise / np.maximum(share, 1e-30))
    return np.where(known, found, np.nan)


def build_relief(terrain, lower, upper):
    """The part of `terrain` (snowmpm.io.Terrain, triangles) within the plan box `lower`, `upper` (2,), or None."""
    vertices = np.asarray(terrain.vertices, np.float64)
    facets, normals = _upward(vertices, terrain.facets)
    facets = facets[_touching(vertices, facets, lower, upper)]
    vertices, normals, facets = _split(vertices, normals, facets, lower, upper)
    if not len(facets):
        return None
    used, renumbered = np.unique(facets, return_inverse=True)
    vertices, normals, facets = vertices[used], normals[used], renumbered.reshape(facets.shape)
    cell = float(max(np.subtract(upper, lower))) / CELLS
    shape = np.ceil(np.subtract(upper, lower) / cell).astype(int) + 1
    heights = height_raster(vertices, facets, lower, cell, tuple(shape))
    if heights is None:
        return None
    relief = Relief(vertices, normals, facets, heights, float(lower[0]), float(lower[1]), cell, len(facets))
    return with_walls(relief, WALL * float(np.ptp(vertices[:, :2], axis=0).max()))


def heights_within(terrain, lower, upper):
    """(heights (rows, columns) [m], NaN in holes, cell [m]) of a terrain in a box as of `build_relief`, or None; those
    asked for last are remembered, since all maps of a run show the same ground."""
    box = (*map(float, lower), *map(float, upper))
    for known, at, found in _REMEMBERED:
        if known() is terrain and at == box:
            return found
    vertices = np.asarray(terrain.vertices, np.float64)
    facets = terrain.facets[_touching(vertices, terrain.facets, lower, upper)]
    cell = float(max(np.subtract(upper, lower))) / CELLS
    shape = np.ceil(np.subtract(upper, lower) / cell).astype(int) + 1
    heights = height_raster(vertices, facets, lower, cell, tuple(shape)) if len(facets) else None
    found = None if heights is None else (heights, cell)
    _REMEMBERED.append((weakref.ref(terrain), box, found))
    return found


def height_raster(vertices, facets, lower, cell, shape):
    """Heights [m] of triangles, (rows, columns) = reversed `shape`, NaN in holes; row i at lower[1] + i cell, column j
    at lower[0] + j cell; None where no facet has an area in plan."""
    x, y = (vertices[:, 0] - lower[0]) / cell + 0.5, (vertices[:, 1] - lower[1]) / cell + 0.5
    raster = rasterise(x, y, vertices[:, 2] - vertices[:, 2].min() + 1.0, facets, shape)
    if not raster.hit.any():
        return None
    heights = np.full(raster.facet.shape, np.nan)
    heights[raster.hit] = raster.interpolate(vertices[:, 2], facets)
    return heights


def map_shade(heights, cell):
    """Light (rows, columns) on a raster of heights [m] from the north-west, as on maps; NaN in holes."""
    slope_north, slope_east = np.gradient(heights, cell)
    normal = np.stack([-slope_east, -slope_north, np.ones_like(slope_east)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return 0.85 * light.illuminate(normal.astype(np.float32), NORTH_WEST, softness=0.2).mean(axis=-1)


def _upward(vertices, facets):
    """Facets turned to face up, and vertex normals weighted by facet area."""
    a, b, c = (vertices[facets[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    down = cross[:, 2] < 0.0
    facets = np.where(down[:, None], facets[:, ::-1], facets)
    cross[down] *= -1.0
    normals = np.empty_like(vertices)
    for axis in range(3):
        weights = np.repeat(cross[:, axis], 3)
        normals[:, axis] = np.bincount(facets.ravel(), weights=weights, minlength=len(vertices))
    return facets, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def with_walls(relief, height):
    """The same with walls of a `height` [m] below the rim of the ground."""
    vertices, normals, facets = relief.vertices, relief.normals, relief.facets
    edges = np.concatenate([facets[:, [k, (k + 1) % 3]] for k in range(3)])
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    a, b = edges[first[count == 1]].T
    # An edge runs with the ground on its left, so out is on its right
    along = vertices[b] - vertices[a]
    out = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(a))])
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    # Facets of several sizes meet at edges of several lengths: with ground on both sides they are no rim
    beside = 0.5 * (vertices[a] + vertices[b]) + 1.5 * relief.cell * out
    rim = np.isneginf(relief.height(beside[:, 0], beside[:, 1]))
    a, b, out = a[rim], b[rim], out[rim]
    if not len(a):
        return relief
    below = [vertices[end] - [0.0, 0.0, height] for end in (a, b)]
    n, m = len(vertices), len(a)
    top_a, top_b, low_a, low_b = (n + k * m + np.arange(m) for k in range(4))
    walls = np.concatenate([np.column_stack([top_a, low_a, top_b]), np.column_stack([top_b, low_a, low_b])])
    return replace(relief, vertices=np.concatenate([vertices, vertices[a], vertices[b], *below]),
                   normals=np.concatenate([normals, *[out] * 4]), facets=np.concatenate([facets, walls]))


def _touching(vertices, facets, lower, upper):
    plan = vertices[facets][:, :, :2]
    return ((plan.max(axis=1) >= lower) & (plan.min(axis=1) <= upper)).all(axis=1)


def _split(vertices, normals, facets, lower, upper):
    """Quarter the facets that are long against the box, dropping what falls outside: a plane of two triangles that
    reaches far behind the camera becomes one that can be cut there."""
    longest = EDGE_SHARE * float(max(np.subtract(upper, lower)))
    for _ in range(20):
        corners = vertices[facets][:, :, :2]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        long = edges > longest
        if not long.any():
            break
        old = facets[long]
        middle = [0.5 * (vertices[old[:, i]] + vertices[old[:, (i + 1) % 3]]) for i in range(3)]
        tilt = [normals[old[:, i]] + normals[old[:, (i + 1) % 3]] for i in range(3)]
        n, m = len(vertices), len(old)
        p, q, r = (n + k * m + np.arange(m) for k in range(3))
        a, b, c = old.T
        new = np.concatenate([np.stack(t, axis=1) for t in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))])
        vertices = np.concatenate([vertices, *middle])
        tilt = np.concatenate(tilt)
        normals = np.concatenate([normals, tilt / np.maximum(np.linalg.norm(tilt, axis=1, keepdims=True), 1e-12)])
        new = new[_touching(vertices, new, lower, upper)]
        facets = np.concatenate([facets[~long], new])
    return vertices, normals, facets
