"""The terrain of a run as a small map: where the avalanche has been, where it is, what the camera shows."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.render import light
from snowmpm.render.ground import contour_interval
from snowmpm.render.relief import height_raster, map_shade

TRACK = light.decode([0.93, 0.60, 0.25])
FLOW = light.decode([0.66, 0.10, 0.22])
VIEW = (38, 84, 180)  # outline of what the camera shows
OPACITY = 0.62  # of track and snow over the ground
CONTOUR = 0.72  # light left on a contour line


@dataclass(frozen=True)
class PlanMap:
    """North is up in pictures, and a cell of the rasters is a pixel.

    heights [m], NaN where there is no ground, and swept [s], when moving snow first was there, inf where never: (rows,
    columns), row i at y0 + i cell, column j at x0 + j cell [m]
    paper (rows, columns, 3): linear light of the ground alone; reach: pixels from a particle that its snow covers,
    where particles are farther apart than pixels
    """

    heights: np.ndarray
    swept: np.ndarray
    paper: np.ndarray
    x0: float
    y0: float
    cell: float
    reach: int = 0

    @classmethod
    def of(cls, terrain, cover, lower, shape, cell, spacing=0.0):
        """Of `snowmpm.io.Terrain` from plan corner `lower` (2,), in `shape` (columns, rows) pixels of `cell` [m].

        cover: the `SnowCover` that says when the ground was swept; spacing: between particles [m]. None where no ground
        is.
        """
        heights = height_raster(np.asarray(terrain.vertices, float), terrain.facets, lower, cell, shape)
        if heights is None:
            return None
        swept = _sampled(cover, lower, heights.shape, cell)
        rows, columns = np.nonzero(np.isfinite(cover.swept))
        row, column, inside = _pixels(heights.shape, lower, cell, cover.x0 + cover.cell * columns,
                                      cover.y0 + cover.cell * rows)
        np.minimum.at(swept, (row[inside], column[inside]), cover.swept[rows, columns][inside])
        return cls(heights, swept, _paper(heights, cell), float(lower[0]), float(lower[1]), cell,
                   int(np.ceil(0.6 * spacing / cell)) if spacing > cell else 0)

    def pixels(self, x, y):
        """Rows, columns (n,) of plan positions [m], and whether they are on the map."""
        return _pixels(self.heights.shape, (self.x0, self.y0), self.cell, x, y)

    def track(self, time):
        """Where (rows, columns) the avalanche has been until a time [s]."""
        return self.swept <= time

    def snow(self, time, points):
        """Where (rows, columns) of its track there is snow now, which is at `points` (n, 3)."""
        there = np.zeros(self.heights.shape, bool)
        row, column, inside = self.pixels(points[:, 0], points[:, 1])
        there[row[inside], column[inside]] = True
        if self.reach:
            there = ndimage.maximum_filter(there, 2 * self.reach + 1)
        return there & self.track(time)

    def shown(self, camera, lower, upper):
        """Which ground (rows, columns) a camera has in its picture, of that in the plan box drawn there; hills that may
        hide it are not asked."""
        rows, columns = np.indices(self.heights.shape)
        x, y = self.x0 + self.cell * columns, self.y0 + self.cell * rows
        there = np.isfinite(self.heights) & (x >= lower[0]) & (x <= upper[0]) & (y >= lower[1]) & (y <= upper[1])
        there[there] = in_picture(camera, np.column_stack([x[there], y[there], self.heights[there]]))
        return there

    def picture(self, time, points, shown):
        """(rows, columns, 3) uint8 at a time [s], with snow at `points` (n, 3); shown: as of the method."""
        picture = self.paper.copy()
        for mask, colour in ((self.track(time), TRACK), (self.snow(time, points), FLOW)):
            picture[mask] += OPACITY * (colour - picture[mask])
        picture = light.encode(picture)
        picture[shown & ~ndimage.binary_erosion(shown, iterations=max(1, round(min(shown.shape) / 150)))] = VIEW
        return picture[::-1]


def in_picture(camera, points):
    """Which of `points` (n, 3) lie within the picture of a `Camera`."""
    x, y, depth = camera.project(points)
    return (depth > 0.0) & (x >= 0.0) & (x < camera.size[0]) & (y >= 0.0) & (y < camera.size[1])


def _pixels(shape, lower, cell, x, y):
    row = np.round((np.asarray(y) - lower[1]) / cell).astype(int)
    column = np.round((np.asarray(x) - lower[0]) / cell).astype(int)
    return row, column, (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])


def _sampled(cover, lower, shape, cell):
    """Times (rows, columns) of a `SnowCover` at the middles of pixels, inf beyond it: of pixels smaller than its cells
    each has one."""
    at = [np.round((low + cell * np.arange(n) - start) / cover.cell).astype(int)
          for low, n, start in ((lower[1], shape[0], cover.y0), (lower[0], shape[1], cover.x0))]
    within = [(k >= 0) & (k < n) for k, n in zip(at, cover.swept.shape, strict=True)]
    times = np.full(shape, np.inf)
    times[np.ix_(*within)] = cover.swept[np.ix_(at[0][within[0]], at[1][within[1]])]
    return times


def _paper(heights, cell):
    """Shaded ground with contours, white where there is none."""
    shade = map_shade(heights, cell)
    interval = contour_interval(heights, cell * max(heights.shape))
    if interval:
        step = np.floor(heights / interval)
        line = np.zeros(heights.shape, bool)
        line[:-1] |= np.abs(np.diff(step, axis=0)) > 0.0
        line[:, :-1] |= np.abs(np.diff(step, axis=1)) > 0.0
        shade = shade * np.where(line, CONTOUR, 1.0)
    return np.repeat(np.nan_to_num(shade, nan=1.0)[..., None], 3, axis=-1).astype(np.float32)
