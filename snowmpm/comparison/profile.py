"""Upper surface of the snow: height over a horizontal coordinate, without particles that fly or roll ahead.

Particles are gathered in bins two particle spacings wide. A bin counts as filled if its mean depth, at the
initial density, is at least one layer of particles, or, for bins with at least `ENOUGH` particles (as in rings), a
quarter of `TOE` of the greatest depth. The body is the row of connected filled bins with most particles. Its surface
lies half a spacing above the highest particle of each bin that is not separated from those below by a gap of more than
three spacings in the bin and its two neighbours. Its ends are half a spacing beyond the outermost particles.

Beyond the body, a collapse leaves a film of one or two layers of particles, which reaches further for finer particles.
The front, as seen in an experiment from a distance, is where the depth (volume in a bin over its plan area) falls below
`TOE` of the greatest depth. (Fávero Neto and Borja (2018), doi:10.1007/s11440-018-0700-3, take where density falls to
90-95 %: with their particles, which are 3 to 10 % of the height, that leaves out the same.)
"""

from dataclasses import dataclass

import numpy as np

BIN = 2.0
"""Width of a bin in particle spacings."""

GAP = 3.0
"""Spacings between heights of particles beyond which the upper ones are in the air."""

TOE = 0.05
"""Share of the greatest depth at which the front is."""

ENOUGH = 16
"""Particles that tell the mean depth of a bin to a quarter, also where it is less than a layer. A bin of a plane
profile holds two a layer, a ring hundreds: cut off at a layer of coarse particles, a round heap would end where it is
a tenth of its height deep, and further out on finer ones."""

STRAY = 0.01
"""Share of the snow below which what lies on the way is stray grains, and no profile."""

ALONG = {"x": "x  [m]", "r": "distance from the middle  [m]", "s": "along the thalweg of the first run  [m]"}


@dataclass(frozen=True)
class Profile:
    """s (k,): middles of the filled bins [m]; top, bottom (k,): height of surface and lowest particle [m]; start, end:
    where the body begins and ends [m]; back, front: the same down to a depth of `TOE` [m]; along: "x", "r" or "s"."""

    s: np.ndarray
    top: np.ndarray
    bottom: np.ndarray
    start: float
    end: float
    back: float
    front: float
    along: str = "x"

    @property
    def outline(self):
        """s and height of the surface (k + 4,) from the ground at one end to the ground at the other."""
        s = np.concatenate([[self.start, self.start], self.s, [self.end, self.end]])
        top = np.concatenate([[self.bottom[0], self.top[0]], self.top, [self.top[-1], self.bottom[-1]]])
        return s, top

    def at(self, s):
        """Height of the surface [m] at s; NaN outside the body."""
        return np.interp(s, self.s, self.top, left=np.nan, right=np.nan)


def profile(case, frame, centre=None, way=None):
    """`Profile` of a `Frame` of a `Case`: along x; in 3-D on a strip along x through the middle of all mass, or, with
    a `centre` (2,) in plan, over the distance from it, all around, or, with a `Way`, on a strip along it, heights being
    those above its ground. None where hardly any snow lies on the way."""
    x, spacing = case.positions(frame), case.spacing
    width = BIN * spacing
    if case.in_plan:
        return _of_columns(case, frame, centre, way)
    volume = case.volumes(frame)
    if x.shape[1] == 2:
        return _profile(x[:, 0], x[:, 1], volume, spacing, lambda s: width)
    if centre is not None:
        r = np.hypot(*(x[:, :2] - np.asarray(centre, float)).T)
        return _profile(r, x[:, 2], volume, spacing, lambda s: 2.0 * np.pi * np.maximum(s, width / 4) * width, "r")
    if way is not None:
        near, s, height = way.strip(x, width)
        if near.sum() < ENOUGH or volume[near].sum() < STRAY * volume.sum():
            return None
        return _profile(s, height, volume[near], spacing, lambda s: 2.0 * width * width, "s")
    middle = float(np.average(x[:, 1], weights=volume))
    strip = np.abs(x[:, 1] - middle) < width
    return _profile(x[strip, 0], x[strip, 2], volume[strip], spacing, lambda s: 2.0 * width * width)


def _of_columns(case, frame, centre, way):
    """The same of columns, which lie at half of their snow and know its depth: means over each bin."""
    x, depth = case.positions(frame), np.asarray(frame.fields["depth"], float).ravel()
    width, along, height = BIN * case.spacing, "x", x[:, 2]
    if centre is not None:
        s, along, near = np.hypot(*(x[:, :2] - np.asarray(centre, float)).T), "r", np.ones(len(x), bool)
    elif way is not None:
        (near, s, height), along = way.strip(x, width), "s"
    else:
        near = np.abs(x[:, 1] - x[:, 1].mean()) < width
        s, height = x[near, 0], height[near]
    if near.sum() < min(ENOUGH, len(near)) or depth[near].sum() < STRAY * depth.sum():
        return None
    number = np.floor(s / width + 1e-4).astype(np.int64)
    first = number.min()
    count = np.bincount(number - first)
    begin, stop = _main_row(count > 0, np.bincount(number - first, depth[near]))
    inside = (number - first >= begin) & (number - first < stop)
    bins = number[inside] - first - begin
    there = np.bincount(bins) > 0

    def mean(values):
        return np.bincount(bins, values)[there] / np.bincount(bins)[there]

    middles = mean(s[inside])
    thick, ground = mean(depth[near][inside]), mean(x[near, 2][inside])
    slope = np.gradient(ground, middles) if len(middles) > 1 else np.zeros(1)
    cosine = 1.0 / np.sqrt(1.0 + slope**2)
    # Along a way heights are above its ground, on which cells and columns lie wherever they are beside it
    bottom = np.zeros(len(middles)) if along == "s" else mean(height[inside]) - 0.5 * cosine * thick
    start, end = float(s[inside].min() - 0.5 * case.spacing), float(s[inside].max() + 0.5 * case.spacing)
    back, front = _reach(middles, thick / cosine, width)
    return Profile(middles, bottom + thick / cosine, bottom, start, end, max(start, back), min(end, front), along)


def _profile(s, height, volume, spacing, area, along="x"):
    width = BIN * spacing
    # With slack: particles that lie on the edge of a bin by round-off belong to one side of it
    number = np.floor(s / width + 1e-4).astype(np.int64)
    first = number.min()
    held = np.bincount(number - first, volume)
    middles = (np.arange(len(held)) + first + 0.5) * width
    depth = held / area(middles)
    known = np.bincount(number - first) >= ENOUGH
    filled = (depth >= spacing * (1.0 - 1e-3)) | (known & (depth >= 0.25 * TOE * depth.max()))
    if not filled.any():
        filled = held == held.max()
    begin, stop = _main_row(filled, held)
    inside = (number - first >= begin) & (number - first < stop)
    bins, heights, places = number[inside] - first - begin, height[inside], s[inside]
    bottom, top = np.full(stop - begin, np.inf), np.full(stop - begin, -np.inf)
    np.minimum.at(bottom, bins, heights - 0.5 * spacing)
    kept = heights < _ceiling(bins, heights, stop - begin, spacing)[bins]
    np.maximum.at(top, bins[kept], heights[kept] + 0.5 * spacing)
    there = np.isfinite(top)
    s, top, bottom = middles[begin:stop][there], top[there], bottom[there]
    start, end = float(places.min() - 0.5 * spacing), float(places.max() + 0.5 * spacing)
    back, front = _reach(s, depth[begin:stop][there], width)
    return Profile(s, top, bottom, start, end, max(start, back), min(end, front), along)


def _reach(s, depth, width):
    """First and last place where the depth, straight between the middles of bins and smoothed over three of them, is
    `TOE` of its largest."""
    smooth = np.convolve(np.pad(depth, 1), np.ones(3), "valid") / 3.0
    smooth = np.where(depth >= smooth.max(), depth, smooth)
    limit = TOE * smooth.max()
    deep = np.flatnonzero(smooth >= limit)

    def crossing(i, step):
        beyond = smooth[i + step] if 0 <= i + step < len(s) else 0.0
        return s[i] + step * width * (smooth[i] - limit) / max(smooth[i] - beyond, 1e-300)

    return crossing(deep[0], -1), crossing(deep[-1], 1)


def _ceiling(bins, heights, n, spacing):
    """Height in each of `n` bins above which particles are in the air: of a gap in the bin and the two beside it."""
    order = np.argsort(bins, kind="stable")
    ends = np.searchsorted(bins[order], np.arange(n + 1))
    ceiling = np.full(n, np.inf)
    for k in range(n):
        column = np.sort(heights[order[ends[max(k - 1, 0)] : ends[min(k + 2, n)]]])
        gaps = np.flatnonzero(np.diff(column) > GAP * spacing)
        if len(gaps):
            ceiling[k] = column[gaps[0]] + 0.5 * spacing
    return ceiling


def _main_row(filled, held):
    """First bin, and one past the last, of the row of filled bins that holds most; a single empty bin splits none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], filled, [False]]).astype(int)))
    rows = [list(row) for row in edges.reshape(-1, 2)]
    joined = rows[:1]
    for row in rows[1:]:
        if row[0] - joined[-1][1] <= 1:
            joined[-1][1] = row[1]
        else:
            joined.append(row)
    return max(joined, key=lambda row: held[row[0] : row[1]].sum())
