"""Plane-strain runs: the side view, ground below its profile and every particle a small disc."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.blur import blur
from snowmpm.render.camera import Camera
from snowmpm.render.snow import SNOW, grain
from snowmpm.render.solid import draw_areas
from snowmpm.render.splat import splat_discs

TOP_SOIL = light.decode([0.46, 0.42, 0.38])
BEDROCK = light.decode([0.26, 0.25, 0.26])
GAP = 0.4  # spacings: gaps of twice this are closed, as the grid does not resolve them
DISC = 0.8  # radius in particle spacings: discs on a square lattice close, with a little to spare for shear


@dataclass(frozen=True)
class Profile:
    """The ground line: x (n,) ascending, z (n,) [m]."""

    x: np.ndarray
    z: np.ndarray

    @classmethod
    def of(cls, terrain):
        """From snowmpm.io.Terrain segments, or None."""
        if terrain is None:
            return None
        vertices = terrain.vertices[np.unique(terrain.facets)]
        order = np.argsort(vertices[:, 0], kind="stable")
        return cls(vertices[order, 0], vertices[order, 2])

    def height(self, x):
        """Ground height, NaN beyond the ends."""
        return np.interp(x, self.x, self.z, left=np.nan, right=np.nan)


def section_camera(centre, pixels_per_metre, size):
    """The view along +y, without perspective, of (x, z) `centre` in the middle of the picture."""
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    return Camera(np.array([centre[0], -1.0, centre[1]]), axes, float(pixels_per_metre), tuple(size), perspective=False)


def draw_section(profile, camera, points, spacing, colours=None, identity=None, solids=None):
    """Picture (height, width, 3) in linear light.

    points (n, 3) [m], spacing [m] between them; colours (n, 3) in linear light, or None for plain snow; identity (n,)
    whole numbers that stay with their particles, or None; solids: vertices (k, 3) [m] and segments (m, 2), or None
    """
    picture = light.sky(camera.size)
    if solids is not None:
        draw_areas(picture, camera, *solids)
    if profile is not None:
        _draw_ground(picture, profile, camera)
    x, y, _ = camera.project(points)
    apart = spacing * camera.scale
    # The soft rim of small discs, half a pixel wide, would let the sky shine through between four of them
    radius_px = max(0.9, DISC * apart, np.sqrt(0.5) * apart + 0.5)
    discs = splat_discs(x, y, radius_px, camera.size)
    number, cover = _closed(*discs, x, y, radius_px, GAP * apart)
    hit = number >= 0
    if not hit.any():
        return picture
    lit = np.zeros_like(picture)
    seen = number[hit]
    lit[hit] = np.broadcast_to(SNOW, (len(seen), 3)) if colours is None else colours[seen]
    if identity is not None:
        lit[hit] *= grain(identity[seen])[:, None]
    lit *= _relief(cover, radius_px)[..., None]
    shadow = 1.0 - 0.25 * blur(cover, 3.0 + radius_px)[..., None]
    return picture * shadow * (1.0 - cover[..., None]) + lit * cover[..., None]


def _closed(number, cover, x, y, radius_px, gap):
    """As of `splat_discs`, without gaps of up to twice a `gap` [px] between discs.

    Discs are widened by it and the outline of all is drawn back as far: a body that is drawn out stays whole.
    """
    wide, _ = splat_discs(x, y, radius_px + gap, number.shape[::-1])
    # What goes on beyond the picture has no outline there
    inside = ndimage.distance_transform_edt(np.pad(wide >= 0, 1, mode="edge"))[1:-1, 1:-1] - gap - 0.5
    return (np.where((number < 0) & (inside > 0.0), wide, number),
            np.maximum(cover, np.clip(inside, 0.0, 1.0)).astype(np.float32))


def _relief(cover, radius_px):
    """Brightness as if the snow were a rounded body lit from above: brighter upper edge, bluer and darker lower one."""
    body = blur(cover, 2.0 + 1.5 * radius_px)
    upward = np.gradient(body, axis=0) * (2.0 + 1.5 * radius_px)
    return np.clip(0.93 + 0.35 * upward, 0.7, 1.05).astype(np.float32)


def _draw_ground(picture, profile, camera):
    height, width = picture.shape[:2]
    x = camera.eye[0] + (np.arange(width) + 0.5 - 0.5 * width) / camera.scale
    z = camera.eye[2] + (0.5 * height - np.arange(height) - 0.5) / camera.scale
    ground = profile.height(x)
    steepness = np.gradient(ground, x)
    below = (ground[None, :] - z[:, None]) / np.sqrt(1.0 + np.nan_to_num(steepness) ** 2) * camera.scale
    below = np.nan_to_num(below, nan=-1e9).astype(np.float32)  # px, normal to the ground
    cover = np.clip(below + 0.5, 0.0, 1.0)[..., None]
    depth = 1.0 - np.exp(-np.maximum(below, 0.0) / (0.22 * height))[..., None]
    colour = (TOP_SOIL + depth * (BEDROCK - TOP_SOIL)) * (0.9 + 0.2 * _stones(x, z, camera.scale)[..., None])
    rim = np.clip(2.5 - np.abs(below - 1.5), 0.0, 1.0)[..., None]
    colour = colour * (1.0 - 0.45 * rim)
    picture[:] = picture * (1.0 - cover) + colour * cover


def _stones(x, z, scale):
    """Noise in [0, 1] that stays with the ground, so that a moving view is seen to move."""
    table = np.random.default_rng(5).random((128, 128)).astype(np.float32)
    total = np.zeros((len(z), len(x)), np.float32)
    for size, weight in ((60.0, 0.5), (18.0, 0.5)):
        length = 2.0 ** np.round(np.log2(size / scale))  # m: a power of two, the same for neighbouring scales
        at = np.meshgrid(z / length, x / length, indexing="ij")
        total += weight * ndimage.map_coordinates(table, at, order=1, mode="grid-wrap")
    return total
