"""Shadows that snow casts on itself and on the ground: a depth map as the sun sees it, compared around each place."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage

from snowmpm.render.blur import TRUNCATE, blur
from snowmpm.render.camera import Camera
from snowmpm.render.splat import splat_balls

LARGEST = 2048  # px a side of the sun's picture
STRAYS = 0.001  # share of the particles on each side that the sun's picture may leave out
SOFT = 2.0  # px: radius over which the edge of a shadow fades
BIAS = 3.0  # ball radii: what lies less deep below the lit surface is the surface itself, smoothed
TAPS = 12
BLOCK = 8  # px a side of the squares whose nearest and farthest snow tell most places without taps; more than SOFT


@dataclass(frozen=True)
class Shadow:
    """The snow as seen from the sun: an orthographic camera, and the depth [m] of the nearest snow at each pixel."""

    camera: Camera
    front: np.ndarray
    bias: float

    @cached_property
    def _limits(self):
        """Depth [m] of the nearest and the farthest snow in the square of BLOCK pixels around each pixel and in the
        squares beside it, those beyond the picture included; inf where there is none."""
        rows, columns = (-(-side // BLOCK) for side in self.front.shape)
        squares = np.full((rows * BLOCK, columns * BLOCK), np.inf, np.float32)
        squares[: self.front.shape[0], : self.front.shape[1]] = self.front
        squares = squares.reshape(rows, BLOCK, columns, BLOCK)
        return [find_around(np.pad(find(squares, axis=(1, 3)), 2, constant_values=np.inf), 3)
                for find, find_around in ((np.min, ndimage.minimum_filter), (np.max, ndimage.maximum_filter))]

    @classmethod
    def of(cls, points, radius, sun):
        """Of balls of `radius` [m] around `points` (n, 3), lit from `sun` (3,), a unit vector; None without points."""
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return None
        right = np.cross([0.0, 0.0, 1.0], sun)
        right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else np.array([1.0, 0.0, 0.0])
        axes = np.stack([right, np.cross(sun, right), -sun])
        local = np.einsum("ni,ji->nj", points[:: max(1, len(points) // 50000)], axes)
        low, high = np.quantile(local, [STRAYS, 1.0 - STRAYS], axis=0)
        extent = high - low + 8.0 * radius
        scale = min(1.0 / radius, LARGEST / float(extent[:2].max()))
        size = tuple(int(np.ceil(side)) + 1 for side in scale * extent[:2])
        middle = 0.5 * (low + high)
        eye = middle[0] * axes[0] + middle[1] * axes[1] + (local[:, 2].min() - 100.0 * radius) * axes[2]
        camera = Camera(eye, axes, scale, size, perspective=False)
        x, y, depth = camera.project(points)
        _, front = splat_balls(x, y, depth, radius, np.full(len(x), radius * scale), size, closed=False)
        return cls(camera, front, BIAS * radius)

    def lit(self, points):
        """Share [0, 1] of the sun's disc that places (n, 3) see past the snow; 1 where no snow can be in the way."""
        x, y, depth = self.camera.project(points)
        limit = depth - np.float32(self.bias)
        nearest, farthest = self._limits
        row, column = (np.floor(at / BLOCK).astype(np.int32).clip(-2, last - 3) + 2
                       for at, last in zip((y, x), nearest.shape, strict=True))
        lit = nearest[row, column] >= limit
        edge = np.flatnonzero(~lit & (farthest[row, column] >= limit))
        share = lit.astype(np.float32)
        share[edge] = self._taps(x[edge], y[edge], limit[edge])
        return share

    def _taps(self, x, y, limit):
        """Share of the taps around pixels x, y that see no snow nearer than `limit` [m]."""
        width, height = self.camera.size
        total = np.zeros(len(x), np.float32)
        for k in range(TAPS):
            # Vogel's spiral: taps spread evenly over the disc
            angle, reach = 2.399963 * k, SOFT * np.sqrt((k + 0.5) / TAPS)
            column = (x + np.float32(reach * np.cos(angle))).astype(np.int32)
            row = (y + np.float32(reach * np.sin(angle))).astype(np.int32)
            outside = (column < 0) | (column >= width) | (row < 0) | (row >= height)
            near = self.front[row.clip(0, height - 1), column.clip(0, width - 1)]
            total += outside | (near >= limit)
        return total / TAPS


def sunlit(shadow, places, mask, softness=1.0):
    """Share [0, 1] of the sun at each pixel of a part of a picture, 1 outside `mask` (height, width).

    places (n, 3) [m] of the pixels in the mask (`Camera.places`); softness [px] of the edges
    """
    window, share = shade_on(shadow, places, mask, softness)
    whole = np.ones(mask.shape, np.float32)
    whole[window] = share
    return whole


def shade_on(shadow, places, mask, softness):
    """(window, share): two slices of a picture outside of which no shadow falls, and the share of the sun in it; the
    rest as of `sunlit`."""
    nowhere = (slice(0, 0), slice(0, 0)), np.ones((0, 0), np.float32)
    if shadow is None or not len(places):
        return nowhere
    share = np.ones(mask.shape, np.float32)
    share[mask] = shadow.lit(places)
    dark = share < 1.0
    lines = [np.flatnonzero(dark.any(axis=axis)) for axis in (1, 0)]
    if not len(lines[0]):
        return nowhere
    # What a blur of the window sees of its borders stays outside what a blur carries away from the shadow
    margin = 2 * int(TRUNCATE * softness + 1.0)
    window = tuple(slice(max(int(line[0]) - margin, 0), int(line[-1]) + margin + 1) for line in lines)
    mask, share = mask[window], share[window]
    smooth = blur(share * mask, softness) / np.maximum(blur(mask, softness), 1e-6)
    return window, np.where(mask, smooth, 1.0).astype(np.float32)
