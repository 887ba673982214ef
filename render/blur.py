"""Gaussian blur of pictures. A wide one is made on fewer pixels: its time does not grow with its width."""

import numpy as np
from scipy import ndimage

FINE = 2.5  # px: standard deviation on the coarse picture, at the least; more for a filter that is cut shorter
TRUNCATE = 4.0  # standard deviations: reach of the filter


def blur(values, width, truncate=TRUNCATE):
    """`values` (height, width) convolved with a Gaussian of standard deviation `width` [px], mirrored at the borders.

    Below 2 FINE, at the usual reach, it is `scipy.ndimage.gaussian_filter`. Above, means of blocks are blurred and
    interpolated linearly. Both steps widen, and the Gaussian between is narrower for it, so that the variance is that
    of `width`.
    """
    values = np.asarray(values, np.float32)
    block = int(width * truncate / (FINE * TRUNCATE))
    if block < 2:
        return ndimage.gaussian_filter(values, width, truncate=truncate)
    coarse = _block_means(values, block, int(np.ceil(truncate * width)))
    # Variance of the mean of a block, and of the triangle that interpolates
    widened = (block**2 - 1.0) / 12.0 + (block**2 - 1.0) / 6.0
    ndimage.gaussian_filter(coarse, np.sqrt(width**2 - widened) / block, output=coarse, truncate=truncate)
    return _interpolated(_interpolated(coarse, values.shape[0], block, 0), values.shape[1], block, 1)


def _block_means(values, block, reach):
    """Means over squares of `block` pixels; the picture goes on mirrored beyond its lower and right border, by `reach`
    [px] at least where the border lies within a square."""
    more = [(0, -side % block and -(-(side + reach) // block) * block - side) for side in values.shape]
    values = np.pad(values, more, mode="symmetric")
    rows, columns = (side // block for side in values.shape)
    return values.reshape(rows, block, columns, block).mean(axis=(1, 3), dtype=np.float32)


def _interpolated(coarse, size, block, axis):
    """`size` values along an axis, linear between the middles of the blocks."""
    at = (np.arange(size, dtype=np.float32) + 0.5) / block - 0.5
    lower = np.floor(at).astype(int)
    share = (at - lower).astype(np.float32)
    share = share[:, None] if axis == 0 else share
    last = coarse.shape[axis] - 1
    first, second = (coarse.take((lower + k).clip(0, last), axis=axis) for k in (0, 1))
    return first + share * (second - first)
