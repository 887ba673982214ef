"""A first guess of where an avalanche would start on a slope: for a scene that a person then puts right."""

from dataclasses import dataclass

import numpy as np

SAMPLES = 96  # of the plan box, along its longer side
STEEP = (30.0, 50.0)  # degrees: slabs release there; steeper slopes shed their snow
SIDE = 0.22  # of the longer side of the plan box: side of the release


@dataclass(frozen=True)
class FirstRelease:
    """A box in plan. x, y: its (lower, upper) [m]; slope: mean angle of the ground in it [degrees]; area: in plan, of
    what has ground below [m2]."""

    x: tuple
    y: tuple
    slope: float
    area: float


def first_release(surface):
    """The box in plan on a `TerrainSurface` that is the steepest within STEEP and the highest; -> FirstRelease.

    Holes count as flat. The box is clear of the rim of the surface by a twentieth of the extent where it can be.
    """
    lower, upper = surface.lower[:2], surface.upper[:2]
    step = float((upper - lower).max()) / SAMPLES
    shape = np.maximum(np.round((upper - lower) / step).astype(int), 4)
    cell = (upper - lower) / shape
    x, y = (lower[k] + cell[k] * (np.arange(shape[k]) + 0.5) for k in (0, 1))
    plan = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    height = surface.height(plan).reshape(shape)
    ground = np.isfinite(height)
    along = np.gradient(height, x, y)
    slope = np.nan_to_num(np.degrees(np.arctan(np.hypot(*along))))
    rise = np.nan_to_num((height - np.nanmin(height)) / max(np.nanmax(height) - np.nanmin(height), 1e-9))
    suited = ground & (slope >= STEEP[0]) & (slope <= STEEP[1])
    # On gentle slopes nothing is suited: the steepest then is, beside which height says little.
    worth = suited * (0.3 + rise) + 1e-3 * np.minimum(slope, STEEP[1]) / STEEP[1] * (0.3 + rise) * ground
    size = np.minimum(np.maximum(np.round(SIDE * SAMPLES * step / cell).astype(int), 2), np.maximum(shape // 2, 2))
    rim = np.minimum(np.round(0.05 * SAMPLES * step / cell).astype(int), (shape - size) // 2)
    best = _window_sums(worth, size)[rim[0] : shape[0] - size[0] - rim[0] + 1, rim[1] : shape[1] - size[1] - rim[1] + 1]
    corner = rim + np.unravel_index(int(best.argmax()), best.shape)
    inside = tuple(slice(a, a + n) for a, n in zip(corner, size, strict=True))
    low, high = lower + corner * cell, lower + (corner + size) * cell
    covered = float(ground[inside].sum() * cell.prod())
    mean = float(slope[inside][ground[inside]].mean()) if ground[inside].any() else 0.0
    return FirstRelease(*(tuple(map(float, pair)) for pair in zip(low, high, strict=True)), mean, covered)


def _window_sums(values, size):
    """Sum of `values` over every window of `size` cells."""
    total = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    a, b = size
    return total[a:, b:] - total[:-a, b:] - total[a:, :-b] + total[:-a, :-b]
