"""Triangles to pixels: which facet is seen where, for the view of a camera and for rasters in plan."""

from dataclasses import dataclass

import numpy as np

BATCH = 2_000_000  # pixel tests at a time: bounds the memory


@dataclass(frozen=True)
class Raster:
    """Per pixel (height, width): the number of the facet seen, -1 for none, and the weights of its three corners."""

    facet: np.ndarray
    weights: np.ndarray

    @property
    def hit(self):
        return self.facet >= 0

    def interpolate(self, values, facets):
        """Values at the vertices, (n,) or (n, k), carried to the pixels that show a facet, in row order."""
        corners = values[facets[self.facet[self.hit]]]
        return np.einsum("pc,pc...->p...", self.weights[self.hit], corners)


def rasterise(x, y, nearness, facets, size, perspective=False):
    """Draw triangles with a depth buffer.

    x, y       (n,) vertices in pixels; centres lie at half integers
    nearness   (n,) > 0, linear on the picture; the largest is seen (perspective: 1 / depth)
    facets     (m, 3);  size (width, height)
    """
    width, height = size
    corners = np.stack([x, y], axis=1).astype(np.float64)[facets]
    low = np.ceil(corners.min(axis=1) - 0.5).astype(np.int64).clip(0)
    high = np.minimum(np.floor(corners.max(axis=1) - 0.5), (width - 1, height - 1)).astype(np.int64)
    near = np.asarray(nearness, np.float32)[facets]
    span = high - low + 1
    area = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    wanted = np.flatnonzero((span > 0).all(axis=1) & (area != 0.0) & (near > 0.0).all(axis=1))
    seen = np.full(width * height, -1, np.int64)
    boxes = _box_sizes(span[wanted])
    for box in np.unique(boxes, axis=0):
        group = wanted[(boxes == box).all(axis=1)]
        step = max(1, BATCH // int(box[0] * box[1]))
        for start in range(0, len(group), step):
            _draw(group[start : start + step], box, corners, area, near, low, size, seen)
    return _weights(seen, corners, area, near, size, perspective)


def _box_sizes(span):
    """Sides rounded up to a few sizes, so that facets of about one size are drawn together."""
    sizes = np.unique(np.round(1.3 ** np.arange(0, 40)).astype(np.int64))
    return sizes[np.searchsorted(sizes, np.minimum(span, sizes[-1]))]


def _draw(group, box, corners, area, near, low, size, seen):
    width, height = size
    column = low[group, 0, None] + np.tile(np.arange(box[0]), box[1])
    row = low[group, 1, None] + np.repeat(np.arange(box[1]), box[0])
    weights = _barycentric(column + 0.5, row + 0.5, corners[group], area[group])
    inside = (weights >= -1e-9).all(axis=0) & (column < width) & (row < height)
    value = np.einsum("cpk,pc->pk", weights, near[group]).astype(np.float32)
    # Positive floats compare like their bit patterns: nearest first, then the facet that came last.
    key = (value.view(np.int32).astype(np.int64) << 32) | np.broadcast_to(group[:, None], value.shape)
    np.maximum.at(seen, (row * width + column)[inside], key[inside])


def _barycentric(x, y, corners, area):
    """(3, facets, pixels) weights of the corners."""
    a, b, c = (corners[:, k, :, None] for k in range(3))
    inverse = 1.0 / area[:, None]
    first = ((b[:, 0] - x) * (c[:, 1] - y) - (b[:, 1] - y) * (c[:, 0] - x)) * inverse
    second = ((c[:, 0] - x) * (a[:, 1] - y) - (c[:, 1] - y) * (a[:, 0] - x)) * inverse
    return np.stack([first, second, 1.0 - first - second])


def _weights(seen, corners, area, near, size, perspective):
    width, height = size
    facet = np.where(seen >= 0, seen & 0xFFFFFFFF, -1)
    pixel = np.flatnonzero(facet >= 0)
    number = facet[pixel]
    x, y = (pixel % width + 0.5)[:, None], (pixel // width + 0.5)[:, None]
    found = _barycentric(x, y, corners[number], area[number])[:, :, 0].T
    if perspective:
        found = found * near[number]
        found /= found.sum(axis=1, keepdims=True)
    weights = np.zeros((width * height, 3), np.float32)
    weights[pixel] = found
    return Raster(facet.reshape(height, width), weights.reshape(height, width, 3))


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
