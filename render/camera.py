"""Where a picture is taken from: the map between points in space and pixels."""

from dataclasses import dataclass

import numpy as np

MARGINS = (0.08, 0.08, 0.14, 0.12)
FIELD_OF_VIEW = 0.5  # of the longer side [rad]


@dataclass(frozen=True)
class Camera:
    """A view of `size` (width, height) pixels; pixel (0, 0) is at the top left and centres lie at half integers.

    eye      (3,) [m]
    axes     (3, 3) rows: right, up, forward; unit vectors
    scale    perspective: focal length in pixels; otherwise pixels per metre
    """

    eye: np.ndarray
    axes: np.ndarray
    scale: float
    size: tuple[int, int]
    perspective: bool = True

    def project(self, points):
        """(x, y, depth) of `points` (n, 3): pixels, and metres along the view."""
        local = np.asarray(points, np.float32) - self.eye.astype(np.float32)
        # Each in one piece of memory
        across, up, depth = np.einsum("ji,ni->jn", self.axes.astype(np.float32), local)
        factor = self.pixels_per_metre(depth)
        return 0.5 * self.size[0] + factor * across, 0.5 * self.size[1] - factor * up, depth

    def pixels_per_metre(self, depth):
        """Size on the picture of one metre across the view at `depth`."""
        if self.perspective:
            return self.scale / np.maximum(depth, 1e-6)
        return np.full_like(depth, self.scale)

    def local(self, x, y, depth):
        """Camera coordinates (..., 3) (right, up, forward) [m] of what is seen at pixels x, y at `depth`."""
        factor = 1.0 / self.pixels_per_metre(depth)
        return np.stack([(x - 0.5 * self.size[0]) * factor, (0.5 * self.size[1] - y) * factor, depth], axis=-1)

    def places(self, depth, mask, corner=(0, 0)):
        """Places (n, 3) float32 [m] in space of what the pixels of a mask (height, width) show at `depth` (height,
        width); corner: (row, column) of that part in the picture."""
        rows, columns = np.nonzero(mask)
        local = self.local(columns + corner[1] + 0.5, rows + corner[0] + 0.5, depth[mask])
        return (np.einsum("ni,ij->nj", local, self.axes) + self.eye).astype(np.float32)

    def bearing_and_elevation(self):
        """The direction it stands in, seen from what it shows: "BEARING,ELEVATION" in degrees."""
        out = -self.axes[2]
        return f"{np.degrees(np.arctan2(out[0], out[1])):.6f},{np.degrees(np.arcsin(np.clip(out[2], -1.0, 1.0))):.6f}"

    def enlarged(self, factor):
        """The same view with `factor` times as many pixels each way."""
        size = (self.size[0] * factor, self.size[1] * factor)
        return Camera(self.eye, self.axes, self.scale * factor, size, self.perspective)


def view_axes(azimuth, elevation):
    """Rows right, up, forward of a camera that stands at `azimuth`, `elevation` [rad] as seen from its target.

    azimuth: compass bearing, clockwise from +y; elevation: above the horizon.
    """
    out = np.array([np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.cos(azimuth), np.sin(azimuth), 0.0])
    return np.stack([right, np.cross(out, right), -out])


def look_at(eye, target, field_of_view, size):
    """The camera at `eye` (3,) that has `target` (3,) in its middle; field_of_view: of the longer side [rad]."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    across = np.cross(forward, [0.0, 0.0, 1.0])
    if np.linalg.norm(across) < 1e-6:  # straight down: north is up
        across = np.array([1.0, 0.0, 0.0])
    across = across / np.linalg.norm(across)
    axes = np.stack([across, np.cross(across, forward), forward])
    return Camera(np.asarray(eye, float), axes, 0.5 * max(size) / np.tan(0.5 * field_of_view), tuple(size))


def fit_camera(points, azimuth, elevation, size, *, margins=MARGINS, field_of_view=FIELD_OF_VIEW, perspective=True):
    """The camera from that direction that has `points` (n, 3) just fill the picture.

    margins        left, right, top and bottom share of the picture that stays free
    field_of_view  of the longer side [rad]
    """
    axes = view_axes(azimuth, elevation)
    left, right, top, bottom = margins
    room = np.array([size[0] * (1.0 - left - right), size[1] * (1.0 - top - bottom)])
    middle = np.array([size[0] * (left + 1.0 - right), size[1] * (top + 1.0 - bottom)]) / 2.0
    target = 0.5 * (points.min(axis=0) + points.max(axis=0)).astype(float)
    extent = max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-3)
    scale = 0.5 * max(size) / np.tan(0.5 * field_of_view) if perspective else room.min() / extent
    distance = 3.0 * extent
    for _ in range(12):
        camera = Camera(target - distance * axes[2], axes, scale, tuple(size), perspective)
        x, y, _ = camera.project(points)
        low, high = np.array([x.min(), y.min()]), np.array([x.max(), y.max()])
        growth = float(np.min(room / np.maximum(high - low, 1e-6)))
        offset = (0.5 * (low + high) - middle) / camera.pixels_per_metre(np.array([distance]))
        target = target + offset[0] * axes[0] - offset[1] * axes[1]
        if perspective:
            distance = max(distance / growth, 0.02 * extent)
        else:
            scale *= growth
    return Camera(target - distance * axes[2], axes, scale, tuple(size), perspective)
