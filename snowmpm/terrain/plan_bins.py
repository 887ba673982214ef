"""Facets sorted into square bins of the plan, to find facets near a plan position quickly."""

from dataclasses import dataclass

import numpy as np

from snowmpm import memory

BYTES_PER_ENTRY = 40  # of the table while it is made
MAX_BINS_PER_FACET = 4  # keeps the table small where facets are small and far between
ROUND_OFF = 1e-12  # of places, relative
OFF_LATTICE = 1e-10  # of vertices of a raster [cells]; less than the slack with which a facet holds a place


@dataclass(frozen=True, eq=False)
class PlanBins:
    """Lists of facets by bin: the facets whose plan bounding box touches bin b are items[starts[b]:starts[b + 1]].

    lower (d,) [m]: corner of the first bin; size [m]: edge of a bin; shape (d,): bins per plan axis, last axis fastest;
    d = dim - 1 is 1 or 2.
    """

    lower: np.ndarray
    size: float
    shape: np.ndarray
    starts: np.ndarray
    items: np.ndarray

    def numbers(self, plan):
        """Bin number of plan positions (k, d), -1 outside; shape (k,)."""
        at = (plan - self.lower) / self.size
        # The far border belongs to the last bin.
        index = np.where((at >= self.shape) & (at <= self.shape * (1.0 + ROUND_OFF)), self.shape - 1, np.floor(at))
        inside = ((index >= 0) & (index < self.shape)).all(axis=1)  # False for NaN as well
        index = np.where(inside[:, None], index, 0).astype(np.int64)
        number = index[:, 0] if len(self.shape) == 1 else index[:, 0] * self.shape[1] + index[:, 1]
        return np.where(inside, number, -1)


def bin_squares(vertices, facets, cell):
    """Bins of a raster's facets, its squares: two triangles in each, where `bin_facets` finds the eight that touch it.

    cell [m]: about the distance of the vertices along x and y. None for a raster with gaps, or whose vertices are
    nowhere near such distances.
    """
    lower, upper = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    shape = np.round((upper - lower) / cell).astype(np.int64)
    if shape.min() < 1 or len(facets) != 2 * shape.prod():
        return None
    size = float((upper - lower).max() / shape.max())
    at = (vertices[:, :2] - lower) / size
    if np.abs(at - np.round(at)).max() > OFF_LATTICE:
        return None
    # A place on a line between two squares is in either of them, and in its facets to round-off
    first = np.round(at[facets].min(axis=1)).astype(np.int64)
    number = first[:, 0] * shape[1] + first[:, 1]
    return PlanBins(lower, size, shape, np.arange(0, 2 * shape.prod() + 1, 2, dtype=np.int32),
                    np.argsort(number, kind="stable").astype(np.int32))


def bin_facets(vertices, facets, size=None):
    """Sort facets (m, dim) into plan bins of edge `size` [m]; by default about one facet wide."""
    d = vertices.shape[1] - 1
    corner = vertices[facets][:, :, :d]
    low, high = corner.min(axis=1), corner.max(axis=1)
    lower, extent = low.min(axis=0), high.max(axis=0) - low.min(axis=0)
    width = np.maximum(extent.max(), 1e-300)
    if size is None:
        size = float(np.median((high - low).max(axis=1)))
    fewest = (np.maximum(extent, 1e-6 * width).prod() / (MAX_BINS_PER_FACET * len(facets))) ** (1.0 / d)
    size = max(size, fewest, 1e-6 * width)
    size *= 1.0 + 1e-12  # the far border falls inside the last bin whatever the round-off
    shape = np.maximum(np.ceil(extent / size).astype(np.int64), 1)

    first = np.clip(np.floor((low - lower) / size).astype(np.int64), 0, shape - 1)
    last = np.clip(np.floor((high - lower) / size).astype(np.int64), 0, shape - 1)
    span = last - first + 1
    repeats = span.prod(axis=1)
    memory.require(BYTES_PER_ENTRY * float(repeats.sum(dtype=float)), "terrain: the table of its facets",
                   "facets that differ less in size need less")
    item = np.repeat(np.arange(len(facets)), repeats)
    rank = np.arange(len(item)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    if d == 1:
        number = first[item, 0] + rank
    else:
        number = (first[item, 0] + rank // span[item, 1]) * shape[1] + first[item, 1] + rank % span[item, 1]
    order = np.argsort(number, kind="stable")
    starts = np.zeros(int(shape.prod()) + 1, np.int32)
    starts[1:] = np.cumsum(np.bincount(number, minlength=len(starts) - 1))
    return PlanBins(lower, size, shape, starts, item[order].astype(np.int32))
