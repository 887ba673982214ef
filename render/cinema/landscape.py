"""The ground of a film to the horizon: the terrain as it is, and beyond its edge ground that is made up and hazy."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.ground import ROCK, bare_albedo, ground_noise, roughness
from snowmpm.render.relief import build_relief

FINE = 2
"""Vertices of the ground for one cell of the relief, each way, where the action is."""

GROWTH = 1.09
"""Of the cells from one to the next, away from the action."""

FAR = 14.0
"""Extents of the action up to which there is ground."""

ONWARDS = 0.3
"""Extents of the terrain over which its slope goes on beyond its edge, until it is level."""

HILLS = 0.06
"""Height of made-up hills, of their distance from the edge."""

RIM = 40.0
"""Cells along the edge of the terrain over which it passes into what is made up."""

DRIFT, DRIFTS = 1.6, 0.08
"""Size of small drifts in cells of the relief, and their slope."""

BRIGHTER = 1.12
"""Snow cover, compared with that of diagrams, where it must be told from the flow by its colour alone."""

SNOW_ROUGH = 0.25
"""Of the roughness of bare ground, under snow."""


@dataclass(frozen=True)
class Landscape:
    """vertices (n, 3), faces (m, 3), normals (n, 3); bare, covered (n, 3): albedo without and with snow, the same where
    there is none; when (n,): time [s] at which the flow swept a place; openness, sunlight (n,) in [0, 1]; rows, columns
    of the grid; made_up (n,): 0 on the terrain, 1 far from it; within (n,): 0 at its edge and beyond, 1 well within."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    bare: np.ndarray
    covered: np.ndarray
    when: np.ndarray
    openness: np.ndarray
    sunlight: np.ndarray
    made_up: np.ndarray
    within: np.ndarray
    shape: tuple[int, int]


def build_landscape(relief, terrain, sun, cover, coarse=1):
    """The `Landscape` around a `Relief`, of an `snowmpm.io.Terrain`; cover: `SnowCover` or None; coarse: fewer
    vertices, each way."""
    plan = np.asarray(terrain.vertices)[np.unique(terrain.facets), :2]
    whole = build_relief(terrain, plan.min(axis=0), plan.max(axis=0))
    whole = whole if whole is not None else relief
    step = relief.cell * coarse / FINE
    x, y = (_axis(low, step, cells * relief.cell, far) for low, cells, far in zip(
        (relief.x0, relief.y0), (relief.heights.shape[1] - 1, relief.heights.shape[0] - 1),
        [FAR * relief.cell * max(relief.heights.shape)] * 2, strict=True))
    grid = tuple(part.ravel() for part in np.meshgrid(y, x, indexing="ij"))[::-1]
    height, made_up = _heights(relief, whole, *grid)
    shape = (len(y), len(x))
    surface = _evened(height.reshape(shape), made_up.reshape(shape) > 0.0)
    height = surface.ravel()
    rise_y, rise_x = (np.gradient(surface, along, axis=axis) for axis, along in ((0, y), (1, x)))
    normals = np.stack([-rise_x, -rise_y, np.ones(shape)], axis=-1).reshape(-1, 3)
    vertices = np.column_stack([*grid, height]).astype(np.float32)
    noise = ground_noise(vertices, relief.cell)
    even = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    bare = bare_albedo(even, noise)
    normals[:, :2] += DRIFTS * (1.0 - 0.7 * made_up[:, None]) * _drifts(np.column_stack(grid) / (DRIFT * relief.cell))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    rough = (roughness(vertices, relief.cell) - 1.0)[:, None] * (1.0 - made_up[:, None])
    covered, when = bare, np.full(len(vertices), np.inf, np.float32)
    if cover is not None:
        covered, when = cover.over(bare, noise, even), np.where(made_up > 0.0, np.inf, cover.when(vertices))
        covered = np.minimum(BRIGHTER * covered * (1.0 + SNOW_ROUGH * rough), 0.97)
    else:
        # Bare ground far away is dark and rough, as forest and rock are
        bare = bare + made_up[:, None] * (ROCK - bare) * 0.5
        covered = bare
    openness, sunlight = np.ones(len(vertices), np.float32), np.ones(len(vertices), np.float32)
    # Coarse light for all of the terrain, fine light for what the action is on
    for part in (whole, relief):
        there = part.height(*grid) > -np.inf
        at = grid[0][there], grid[1][there]
        openness[there], sunlight[there] = (part.sample(raster, *at, 1.0) for raster in
                                            (part.openness, part.sunlight(sun)))
    # Rasters know nothing beyond their rim: there, the ground is taken to be open to sun and sky
    within = np.clip(ndimage.distance_transform_edt(made_up.reshape(shape) <= 0.0) / RIM, 0.0, 1.0).ravel()
    openness, sunlight = 1.0 + within * (openness - 1.0), 1.0 + within * (sunlight - 1.0)
    return Landscape(vertices, _faces(shape), normals, (bare * (1.0 + rough)).astype(np.float32),
                     covered.astype(np.float32), when.astype(np.float32), openness, sunlight,
                     made_up.astype(np.float32), within.astype(np.float32), shape)


def _axis(low, step, extent, far):
    """Places along one axis: evenly where the action is, then ever farther apart."""
    even = low + step * np.arange(int(np.ceil(extent / step)) + 1)
    steps = int(np.ceil(np.log(1.0 + far * (GROWTH - 1.0) / step) / np.log(GROWTH)))
    out = step * (GROWTH ** np.arange(1, steps + 1) - 1.0) * GROWTH / (GROWTH - 1.0)
    return np.concatenate([even[0] - out[::-1], even, even[-1] + out])


def _heights(relief, whole, x, y):
    """Heights (n,) at places in plan, and how far they are made up (n,), in [0, 1]."""
    known = np.isfinite(whole.heights)
    nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    filled = whole.heights[tuple(nearest)]
    extent = whole.cell * np.array([filled.shape[1] - 1, filled.shape[0] - 1])
    low = np.array([whole.x0, whole.y0])
    plan = np.column_stack([x, y])
    # A hair within, where the raster is known
    edge = np.clip(plan, low + 1e-6 * whole.cell, low + extent - 1e-6 * whole.cell)
    away = plan - np.clip(plan, low, low + extent)
    distance = np.linalg.norm(away, axis=1)
    size = float(extent.max())
    # Farther from the edge, its own ups and downs count less
    height = np.zeros(len(plan))
    smooth = [filled, *(_smoothed(filled, width) for width in (6.0, 25.0))]
    share = 1.0 - np.exp(-((distance / (0.2 * size)) ** 2))
    for raster, weight in zip(smooth, (np.clip(1.0 - 2.0 * share, 0.0, 1.0), 1.0 - np.abs(2.0 * share - 1.0),
                                       np.clip(2.0 * share - 1.0, 0.0, 1.0)), strict=True):
        height += weight * whole.sample(raster, edge[:, 0], edge[:, 1], float(np.nanmean(filled)))
    rises = [whole.sample(rise, edge[:, 0], edge[:, 1], 0.0) for rise in np.gradient(smooth[2], whole.cell)]
    onwards = ONWARDS * size
    damped = onwards * (1.0 - np.exp(-distance / onwards)) / np.maximum(distance, 1e-9)
    height += damped * (away[:, 0] * rises[1] + away[:, 1] * rises[0])
    height += HILLS * distance * _hills(plan / size)
    own = relief.height(x, y)
    inside = own > -np.inf
    height[inside] = own[inside]
    beyond = 1.0 - np.exp(-((distance / (0.15 * size)) ** 2))
    return height, beyond


def _smoothed(raster, width):
    """A raster without what is finer than `width` cells, which goes on beyond its edge with the slope that it has."""
    pad = int(np.ceil(3.0 * width))
    wide = np.pad(raster, pad, mode="reflect", reflect_type="odd")
    return ndimage.gaussian_filter(wide, width, mode="nearest")[pad:-pad, pad:-pad]


def _evened(surface, beyond):
    """Heights (rows, columns) without a crease along the edge of the terrain, `beyond` which they are made up."""
    near = np.minimum(ndimage.distance_transform_edt(beyond), RIM) + np.minimum(ndimage.distance_transform_edt(~beyond),
                                                                                RIM) - 1.0
    share = np.clip(1.0 - near / RIM, 0.0, 1.0) ** 2
    if not beyond.any():
        return surface
    for width in (4.0, 12.0):
        surface = surface + share * (ndimage.gaussian_filter(surface, width, mode="nearest") - surface)
    return surface


def _drifts(places):
    """Slopes (n, 2) of small drifts on snow, over places (n, 2)."""
    table = np.random.default_rng(29).normal(size=(256, 256, 2))
    total = np.zeros((len(places), 2))
    for size, weight in ((6.0, 0.5), (2.0, 0.35), (0.7, 0.25)):
        for axis in (0, 1):
            total[:, axis] += weight * ndimage.map_coordinates(table[..., axis], (places / size).T, order=1,
                                                               mode="grid-wrap")
    return total


def _hills(places):
    """Noise around zero (n,) of several sizes, over places (n, 2) in extents of the terrain."""
    table = np.random.default_rng(3).uniform(-1.0, 1.0, (128, 128))
    total = np.zeros(len(places))
    for size, weight in ((2.3, 0.6), (0.9, 0.3), (0.35, 0.12)):
        total += weight * ndimage.map_coordinates(table, (places / size).T, order=3, mode="grid-wrap")
    return total


def _faces(shape):
    """Two triangles for each cell of a grid (rows, columns), (m, 3) int32."""
    number = np.arange(shape[0] * shape[1], dtype=np.int32).reshape(shape)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def sky_of(camera, sun):
    """(height, width, 3) in linear light: the sky in the direction of each pixel, brighter at the horizon and around
    the sun."""
    width, height = camera.size
    if not camera.perspective:
        return light.sky(camera.size)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    local = camera.local(columns, rows, np.ones(columns.shape)).astype(np.float32)
    way = np.einsum("...i,ij->...j", local, camera.axes.astype(np.float32))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    up = np.clip(way[..., 2:], 0.0, 1.0) ** 0.45
    colour = HAZE + up * (DEEP - HAZE)
    glow = np.clip(np.einsum("...i,i->...", way, sun.astype(np.float32)), 0.0, 1.0)[..., None] ** 8
    return (colour + 0.25 * glow * (1.0 - colour)).astype(np.float32)


HAZE = light.decode([0.80, 0.86, 0.92])
DEEP = light.decode([0.26, 0.44, 0.68])
"""Colours of the sky at the horizon and high up."""
