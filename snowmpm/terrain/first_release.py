"""A first guess of the release area on a slope, for a scene that the user then corrects."""

from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

SAMPLES = 96  # of the plan box, along its longer side
STEEP = (30.0, 50.0)  # degrees: slabs release there; steeper slopes shed their snow
SIDE = 0.22  # of the longer side of the plan box: side of the release, at most
SMALLER = (1.0, 0.75, 0.55, 0.4, 0.3, 0.2, 0.1)  # shares of SIDE, where the ground has no room for more
RIM = (0.05, 0.02, 0.01)  # of the longer side: distance from the rim of the ground and from holes, the first that fits
PROBES = 300  # along each side of a box, to find holes that lie between SAMPLES
BENDS = 120  # along each side of a box, to find where a layer on it would fold
BENT = 0.1  # thickness of the snow over the radius of curvature of the ground at which the score of a place is halved
SHRUNK = 0.2  # of the area below a layer that its upper side must keep
WIDENINGS = 6  # doublings of the width over which a layer's normals are smoothed
NO_ROOM = "terrain: has no ground wide and even enough for a release: choose its place with --release FILE"


@dataclass(frozen=True)
class FirstRelease:
    """A box in plan with ground below all of it. x, y: its (lower, upper) [m]; slope: mean angle of the ground in it
    [degrees]."""

    x: tuple
    y: tuple
    slope: float

    @property
    def area(self):
        """In plan [m2]."""
        return (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])


def first_release(surface, thickness=0.0):
    """The box in plan on a `TerrainSurface` with the best score for steepness (within STEEP), height and evenness; ->
    FirstRelease.

    thickness [m]: of the snow. If it is more than a small share of the ground's radius of curvature, curved ground
    scores less, and ground on which so thick a layer would fold is excluded. The whole box lies on the terrain, clear
    of its rim and of holes. Its corners are round numbers. InputError: no ground is wide or even enough.
    """
    lower, upper = surface.lower[:2], surface.upper[:2]
    longer = float((upper - lower).max())
    shape = np.maximum(np.round((upper - lower) * SAMPLES / longer).astype(int), 4)
    cell = (upper - lower) / shape
    x, y = (lower[k] + cell[k] * (np.arange(shape[k]) + 0.5) for k in (0, 1))
    plan = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    height = surface.height(plan).reshape(shape)
    ground = np.isfinite(height)
    slope = np.nan_to_num(np.degrees(np.arctan(np.hypot(*np.gradient(height, x, y)))))
    rise = np.nan_to_num((height - np.nanmin(height)) / max(np.nanmax(height) - np.nanmin(height), 1e-9))
    suited = ground & (slope >= STEEP[0]) & (slope <= STEEP[1])
    # On gentle slopes no place is in the range: take the steepest, since height matters less.
    worth = suited * (0.3 + rise) + 1e-3 * np.minimum(slope, STEEP[1]) / STEEP[1] * (0.3 + rise) * ground
    worth /= 1.0 + (thickness * np.nan_to_num(_curvature(height, x, y)) / BENT) ** 2
    while ground.any():
        corner, size = _best(worth, ground, longer * SIDE / cell, longer / cell)
        low, high = _rounded(lower + corner * cell, lower + (corner + size) * cell)
        missing = _holes(surface, low, high)
        if not len(missing) and thickness > 0.0:
            missing = _folds(surface, low, high, thickness)
        if not len(missing):
            inside = tuple(slice(a, a + n) for a, n in zip(corner, size, strict=True))
            return FirstRelease(*((float(a), float(b)) for a, b in zip(low, high, strict=True)),
                                float(slope[inside].mean()))
        at = np.clip(((missing - lower) / cell).astype(int), 0, shape - 1)
        ground[tuple(at.T)] = False
    raise InputError(NO_ROOM)


def _curvature(height, x, y):
    """Largest principal curvature [1/m] of heights over a grid."""
    by_x, by_y = np.gradient(height, x, y)
    (xx, xy), (_, yy) = np.gradient(by_x, x, y), np.gradient(by_y, x, y)
    turn = np.abs(0.5 * (xx + yy)) + np.hypot(0.5 * (xx - yy), xy)
    return turn / (1.0 + by_x**2 + by_y**2)


def _folds(surface, low, high, thickness):
    """Places (k, 2) in a box in plan where the columns of a layer of this thickness [m], normal to the ground, would
    cross, however widely the normals are smoothed."""
    axes = [np.linspace(a, b, BENDS) for a, b in zip(low, high, strict=True)]
    plan = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    ground = np.concatenate([plan, surface.height(plan.reshape(-1, 2)).reshape(BENDS, BENDS, 1)], axis=-1)
    width = thickness
    for _ in range(WIDENINGS + 1):
        normal = surface.smooth_normal(plan.reshape(-1, 2), width).reshape(BENDS, BENDS, 3)
        areas = [(np.cross(*np.gradient(ground + h * normal, *axes, axis=(0, 1))) * normal).sum(axis=-1)
                 for h in (0.0, thickness)]
        folded = areas[1] < SHRUNK * areas[0]
        if not folded.any():
            break
        width *= 2.0
    return plan[folded]


def _best(worth, ground, largest, whole):
    """First cell and size of the window on the terrain with the best score: the sum of its values times their mean.

    largest, whole: cells along the largest window and along the whole extent. Cells far from the rim score up to twice
    as much, since least snow leaves the terrain there. InputError: no window has ground all over.
    """
    from scipy.ndimage import distance_transform_cdt  # slow to import

    clear = distance_transform_cdt(np.pad(ground, 1), metric="chessboard")[1:-1, 1:-1]  # 1 beside cells without terrain
    worth = worth * (1.0 + clear / clear.max())
    for rim in RIM:
        free = (clear > np.ceil(rim * whole.max())).astype(float)
        found = []
        for share in SMALLER:
            size = np.maximum(np.round(share * largest).astype(int), 2)
            if (size > worth.shape).any():
                continue
            fits = _window_sums(free, size) > size.prod() - 0.5
            if fits.any():
                sums = np.where(fits, _window_sums(worth, size), 0.0)
                at = np.array(np.unravel_index(int(sums.argmax()), sums.shape))
                found.append((float(sums.max()) ** 2 / size.prod(), at, size))
        if found:
            return max(found, key=lambda window: window[0])[1:]
    raise InputError(NO_ROOM)


def _rounded(low, high):
    """Corners moved inwards to multiples of a power of ten that is at most a fiftieth of the shorter side."""
    step = 10.0 ** np.floor(np.log10((high - low).min() / 50.0))
    return np.round(np.ceil(low / step) * step, 9), np.round(np.floor(high / step) * step, 9)


def _holes(surface, low, high):
    """Places (k, 2) in a box in plan that have no ground below."""
    axes = [np.linspace(a, b, PROBES) for a, b in zip(low, high, strict=True)]
    plan = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return plan[np.isnan(surface.height(plan))]


def may_leave(surface, centre, friction):
    """Whether snow that starts at `centre` (2,) [m] may leave the ground at its rim: whether any of that lies below the
    energy line, which falls by `friction` from there (the ground's height less friction times the distance in plan)."""
    edges = np.sort(np.stack([surface.facets[:, [0, 1]], surface.facets[:, [1, 2]], surface.facets[:, [2, 0]]]), axis=2)
    edges, count = np.unique(edges.reshape(-1, 2), axis=0, return_counts=True)
    rim = surface.vertices[np.unique(edges[count == 1])]
    start = surface.height(np.array([centre], float))[0]
    below = start - friction * np.linalg.norm(rim[:, :2] - centre, axis=1) - rim[:, 2]
    return bool((below > 0.0).any())


def _window_sums(values, size):
    """Sum of `values` over every window of `size` cells."""
    total = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    a, b = size
    return total[a:, b:] - total[:-a, b:] - total[a:, :-b] + total[:-a, :-b]
