"""Particles to pixels. Half a million take less than a tenth of a second: each is a little ball of a few pixels."""

import numpy as np

SMALLEST = 0.75  # px: radius of a particle too small to see
LARGEST = 48.0
DOT = 0.5  # px: particles of a smaller radius are closer than a pixel, and one is enough for each
FINE = 1.5  # px: below, the pixels of a ball are counted from its centre, not from the middle of the pixel it lies in
BATCH = 4_000_000  # disc pixels at a time: bounds the memory


def splat_balls(x, y, depth, radius, radius_px, size, closed=True):
    """Nearest ball of each pixel: (particle number or -1, depth of its surface), both (height, width).

    x, y, depth  (n,) centres [px, px, m];  radius [m], one or (n,);  radius_px (n,) [px]
    closed  small balls whose discs overlap leave no pixel between them out
    """
    width, height = size
    best = np.full(width * height, np.iinfo(np.int64).max, np.int64)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height) & (depth > 0)
    number = np.flatnonzero(inside)
    drawn = np.clip(radius_px[number], SMALLEST, LARGEST)
    # Radii in steps of a quarter of a pixel and coarser: particles of one radius are drawn together.
    level = np.where(drawn < 4.0, np.round(drawn * 4.0) / 4.0, np.round(drawn))
    if closed:
        level = np.where(drawn < FINE, np.ceil(drawn * 4.0) / 4.0, level)
        level[radius_px[number] < DOT] = DOT
    radius = np.broadcast_to(radius, len(x))
    for r in np.unique(level):
        chosen = number[level == r]
        _splat_level(x[chosen], y[chosen], depth[chosen], chosen, radius[chosen], float(r), size, best,
                     closed and DOT < r <= FINE)
    hit = best < np.iinfo(np.int64).max
    ids = np.where(hit, best & 0xFFFFFFFF, -1)
    front = np.where(hit, (best >> 32).astype(np.int32).view(np.float32), np.inf)
    return ids.reshape(height, width), front.reshape(height, width).astype(np.float32)


def _splat_level(x, y, depth, number, radius, r, size, best, exact):
    width, height = size
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    reach = int(np.ceil(r)) if exact else int(r)
    border = (column < reach) | (column >= width - reach) | (row < reach) | (row >= height - reach)
    base = row * width + column
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            distance = (dx * dx + dy * dy) / r**2
            if exact:
                near = (column + (dx + 0.5) - x) ** 2 + (row + (dy + 0.5) - y) ** 2 <= r**2
                distance = min(distance, 1.0)
            elif distance > 1.0:
                continue
            surface = np.maximum(depth - (radius * np.sqrt(1.0 - distance)).astype(np.float32), 1e-6).astype(np.float32)
            key = (surface.view(np.int32).astype(np.int64) << 32) | number
            if dx or dy:
                c, w = column + dx, row + dy
                keep = ~border | ((c >= 0) & (c < width) & (w >= 0) & (w < height))
                if exact:
                    keep &= near
                np.minimum.at(best, (base + dy * width + dx)[keep], key[keep])
            else:
                np.minimum.at(best, base, key)


def splat_discs(x, y, radius_px, size):
    """Flat discs with smooth edges: (particle number or -1, coverage in [0, 1]), both (height, width).

    Where discs overlap, the one whose centre is nearest (relative to its radius) is seen.
    """
    width, height = size
    best = np.zeros(width * height, np.int64)
    reach = int(np.ceil(radius_px + 0.5))
    offsets = np.stack(np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1)), axis=-1).reshape(-1, 2)
    offsets = offsets[np.hypot(*offsets.T) <= radius_px + 1.3]
    inside = (x >= -reach) & (x < width + reach) & (y >= -reach) & (y < height + reach)
    number = np.flatnonzero(inside)
    step = max(1, BATCH // len(offsets))
    for start in range(0, len(number), step):
        chosen = number[start : start + step]
        column = np.floor(x[chosen]).astype(np.int64)[:, None] + offsets[:, 0]
        row = np.floor(y[chosen]).astype(np.int64)[:, None] + offsets[:, 1]
        distance = np.hypot(column + 0.5 - x[chosen, None], row + 0.5 - y[chosen, None])
        keep = (distance < radius_px + 0.5) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        closeness = np.round(1e6 * (1.0 - distance[keep] / (radius_px + 0.5))).astype(np.int64) + 1
        key = (closeness << 32) | np.broadcast_to(chosen[:, None], keep.shape)[keep]
        np.maximum.at(best, (row * width + column)[keep], key)
    hit = best > 0
    distance = (1.0 - ((best >> 32) - 1) * 1e-6) * (radius_px + 0.5)
    coverage = np.where(hit, np.clip(radius_px + 0.5 - distance, 0.0, 1.0), 0.0)
    ids = np.where(hit, best & 0xFFFFFFFF, -1)
    return ids.reshape(height, width), coverage.reshape(height, width).astype(np.float32)
