"""Light at the vertices of snow, ground and obstacles: sun, sky, what stands around, and what goes through snow."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.cinema.landscape import HAZE
from snowmpm.render.snow_surface import neighbour_means

SNOW_SOFT = 0.30
"""How far round the edge of its shade the sun lights snow (`light.illuminate`)."""

SPREAD = np.array([0.22, 0.33, 0.45], np.float32)
"""Share of the light of red, green and blue that goes from a place in snow to those around it, in each of PASSES: blue
goes farthest, since ice takes it up least."""

PASSES = 1
BOUNCE = np.array([0.10, 0.115, 0.13], np.float32)
"""Light that snow sends back to snow in its shade."""

SUN, SKY = 1.8 * light.SUN, 0.5 * light.SKY
"""Harder light than on diagrams: a low sun in clear air."""

EXPOSURE = 0.73
HOLLOWS = ((1.5, 0.35), (4.0, 0.30), (12.0, 0.20))
"""Widths in cells of the raster of what is seen from above, and how much of the sky a hollow of that width loses."""

SHADE = 0.75
"""Of the light that a hollow in snow loses: the rest comes through the snow."""

FROM_SNOW = np.array([0.34, 0.38, 0.44], np.float32)
"""Light that snow on the ground sends to what looks down on it."""

GROUND_SHADE = 0.5
"""Of what hollows take from the ground beside snow: all of it would outline the snow."""

CLEAR, HAZY = 2.5, 20.0
"""Distance, in that of the action, from which there is haze, and over which it takes two thirds of the light."""


@dataclass(frozen=True)
class Air:
    """Haze between a `Camera` and what it shows; distance [m] to the action."""

    camera: object
    distance: float

    def before(self, seen, places, more=0.0):
        """Light (n, 3) of places (n, 3) as it comes through the air; more (n,): haze that is there besides."""
        apart = np.linalg.norm(places - self.camera.eye.astype(np.float32), axis=1)
        path = np.maximum(apart / self.distance - CLEAR, 0.0) / HAZY
        share = 1.0 - (1.0 - np.asarray(more, np.float32)) * np.exp(-path)
        return (seen + share[:, None] * (HAZE - seen)).astype(np.float32)


@dataclass(frozen=True)
class FromAbove:
    """Heights (rows, columns) [m] of all that is seen from above, on the raster of a relief."""

    relief: object
    heights: np.ndarray

    @classmethod
    def of(cls, relief, points, radius):
        """Of the ground and balls of `radius` [m] at points (n, 3)."""
        ground = np.where(np.isfinite(relief.heights), relief.heights, np.nanmin(relief.heights))
        heights = ground.copy()
        row = np.round((points[:, 1] - relief.y0) / relief.cell).astype(int)
        column = np.round((points[:, 0] - relief.x0) / relief.cell).astype(int)
        inside = (row >= 0) & (row < heights.shape[0]) & (column >= 0) & (column < heights.shape[1])
        np.maximum.at(heights, (row[inside], column[inside]), points[inside, 2] + radius)
        reach = int(np.ceil(radius / relief.cell))
        if reach:
            snow = np.where(heights > ground, heights, -np.inf)
            heights = np.maximum(heights, ndimage.maximum_filter(snow, 2 * reach + 1))
        return cls(relief, heights)

    def openness(self, places):
        """Share [0.25, 1] of the sky that places (n, 3) see."""
        total = np.ones(len(places), np.float32)
        for width, most in HOLLOWS:
            around = self.relief.sample(ndimage.gaussian_filter(self.heights, width), places[:, 0], places[:, 1],
                                        np.nan)
            below = np.nan_to_num(around - places[:, 2], nan=0.0)
            total -= most * np.clip(below / (1.2 * width * self.relief.cell), 0.0, 1.0)
        return np.maximum(total, 0.25).astype(np.float32)


def snow_light(body, albedo, sun, shadow, above):
    """Light (n, 3) that a body of snow (vertices, faces, normals, ...) sends out, lit through itself in part."""
    if not len(body.vertices):
        return np.zeros((0, 3), np.float32)
    raised = body.vertices + body.lift[:, None] * sun.astype(np.float32)
    openness = above.openness(body.vertices + body.lift[:, None] * np.array([0.0, 0.0, 1.0], np.float32))
    lit = illuminate(body.normals, sun, SNOW_SOFT, 1.0 if shadow is None else shadow.lit(raised), openness)
    lit *= (1.0 - SHADE * (1.0 - openness))[:, None]
    lit = through(lit, body.faces)
    lit += BOUNCE * (1.0 - np.minimum(lit, 1.0))
    return EXPOSURE * albedo * lit


def illuminate(normals, sun, softness, sunlight, openness):
    """Light (n, 3) on surfaces with unit `normals` (n, 3), as of `light.illuminate`."""
    towards = np.einsum("ni,i->n", normals, sun.astype(np.float32))
    facing = np.clip((towards + softness) / (1.0 + softness), 0.0, None) * sunlight
    up = 0.5 + 0.5 * normals[:, 2]
    return facing[:, None] * SUN + (up * openness)[:, None] * SKY + (1.0 - up)[:, None] * light.GROUND_BOUNCE


def through(lit, faces):
    """Light (n, 3) at vertices after it went on in the snow below, along the edges of faces (m, 3)."""
    mean = neighbour_means(faces, len(lit))
    for _ in range(PASSES):
        lit = lit + SPREAD * (mean @ lit - lit)
    return lit.astype(np.float32)


def ground_light(land, sun, shadow, above, bare):
    """Light (n, 3) of a `Landscape` with the shadow of the snow on it; bare (n,): share of its snow that is gone."""
    near = land.made_up <= 0.0
    places = land.vertices[near]
    sunlight, openness = land.sunlight.copy(), land.openness.copy()
    if shadow is not None:
        sunlight[near] *= shadow.lit(places)
    openness[near] *= 1.0 + land.within[near] * GROUND_SHADE * (above.openness(places) - 1.0)
    albedo = land.covered + bare[:, None] * (land.bare - land.covered)
    lit = illuminate(land.normals, sun, 0.12, sunlight, openness)
    lit += 0.6 * BOUNCE * (1.0 - bare)[:, None] * (1.0 - np.minimum(lit, 1.0))
    return (EXPOSURE * albedo * lit).astype(np.float32)


def solid_light(solid, sun, shadow, above, lift):
    """Light (n, 3) of a `solids.Solid`; lift [m]: how far its own faces stay out of its shadow."""
    raised = solid.vertices + np.float32(lift) * (solid.normals + sun.astype(np.float32))
    sunlight = 1.0 if shadow is None else shadow.lit(raised)
    lit = illuminate(solid.normals, sun, 0.05, sunlight, above.openness(solid.vertices))
    lit += (1.0 - 0.5 * (1.0 + solid.normals[:, 2:])) * FROM_SNOW
    return (EXPOSURE * solid.albedo * lit).astype(np.float32)
