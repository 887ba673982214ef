"""Shadows that snow casts on itself and on the ground: a depth map as the sun sees it, compared around each place."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.render.camera import Camera
from snowmpm.render.splat import splat_balls

LARGEST = 2048  # px a side of the sun's picture
STRAYS = 0.001  # share of the particles on each side that the sun's picture may leave out
SOFT = 2.0  # px: radius over which the edge of a shadow fades
BIAS = 3.0  # ball radii: what lies less deep below the lit surface is the surface itself, smoothed
TAPS = 12


@dataclass(frozen=True)
class Shadow:
    """The snow as seen from the sun: an orthographic camera, and the depth [m] of the nearest snow at each pixel."""

    camera: Camera
    front: np.ndarray
    bias: float

    @classmethod
    def of(cls, points, radius, sun):
        """Of balls of `radius` [m] around `points` (n, 3), lit from `sun` (3,), a unit vector; None without points."""
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return None
        right = np.cross([0.0, 0.0, 1.0], sun)
        right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else np.array([1.0, 0.0, 0.0])
        axes = np.stack([right, np.cross(sun, right), -sun])
        local = points[:: max(1, len(points) // 50000)] @ axes.T
        low, high = np.quantile(local, [STRAYS, 1.0 - STRAYS], axis=0)
        extent = high - low + 8.0 * radius
        scale = min(1.0 / radius, LARGEST / float(extent[:2].max()))
        size = tuple(int(np.ceil(side)) + 1 for side in scale * extent[:2])
        middle = 0.5 * (low + high)
        eye = middle[0] * axes[0] + middle[1] * axes[1] + (local[:, 2].min() - 100.0 * radius) * axes[2]
        camera = Camera(eye, axes, scale, size, perspective=False)
        x, y, depth = camera.project(points)
        _, front = splat_balls(x, y, depth, radius, np.full(len(x), radius * scale), size)
        return cls(camera, front, BIAS * radius)

    def lit(self, points):
        """Share [0, 1] of the sun's disc that places (n, 3) see past the snow; 1 where no snow can be in the way."""
        x, y, depth = self.camera.project(points)
        width, height = self.camera.size
        limit = depth - np.float32(self.bias)
        total = np.zeros(len(points), np.float32)
        for k in range(TAPS):
            # Vogel's spiral: taps spread evenly over the disc
            angle, reach = 2.399963 * k, SOFT * np.sqrt((k + 0.5) / TAPS)
            column = (x + np.float32(reach * np.cos(angle))).astype(np.int32)
            row = (y + np.float32(reach * np.sin(angle))).astype(np.int32)
            outside = (column < 0) | (column >= width) | (row < 0) | (row >= height)
            near = self.front[row.clip(0, height - 1), column.clip(0, width - 1)]
            total += outside | (near >= limit)
        return total / TAPS


def sunlit(shadow, camera, depth, mask, corner=(0, 0), blur=1.0):
    """Share [0, 1] of the sun at each pixel of a part of a picture, 1 outside `mask`.

    depth (height, width) [m] along the view of `camera`; corner: (row, column) of that part in the picture; blur [px]
    """
    share = np.ones(depth.shape, np.float32)
    rows, columns = np.nonzero(mask)
    if shadow is None or not len(rows):
        return share
    local = camera.local(columns + corner[1] + 0.5, rows + corner[0] + 0.5, depth[rows, columns])
    share[rows, columns] = shadow.lit(local @ camera.axes + camera.eye)
    weight = ndimage.gaussian_filter(mask.astype(np.float32), blur)
    smooth = ndimage.gaussian_filter(share * mask, blur) / np.maximum(weight, 1e-6)
    return np.where(mask, smooth, 1.0).astype(np.float32)
