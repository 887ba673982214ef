"""The ground of a run, and its rasters in plan."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats, Numbers
from snowmpm.glance import ArraysGlance


@dataclass(frozen=True, repr=False)
class Terrain(ArraysGlance):
    """The ground: vertices (n, 3) [m] relative to the run's origin; facets (m, 3) triangles or (m, 2) segments."""

    vertices: Floats
    facets: NDArray[np.integer[Any]]

    def heights(self, plan: Floats) -> Floats:
        """Height (k,) [m] of triangles at a few places (k, 2), the highest where several lie there; NaN over holes."""
        corners = self.vertices[self.facets].astype(float)
        low, high = corners[..., :2].min(axis=1), corners[..., :2].max(axis=1)
        found = np.full(len(plan), np.nan)
        for k, place in enumerate(np.asarray(plan, float)):
            near = corners[((low <= place) & (place <= high)).all(axis=1)]
            a, ab, ac = near[:, 0], near[:, 1] - near[:, 0], near[:, 2] - near[:, 0]
            area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
            own = np.flatnonzero(area)
            way, area = place - a[own, :2], area[own]
            along = (way[:, 0] * ac[own, 1] - way[:, 1] * ac[own, 0]) / area
            across = (ab[own, 0] * way[:, 1] - ab[own, 1] * way[:, 0]) / area
            inside = (along >= -1e-9) & (across >= -1e-9) & (along + across <= 1.0 + 1e-9)
            z = a[own, 2] + along * ab[own, 2] + across * ac[own, 2]
            if inside.any():
                found[k] = z[inside].max()
        return found


@dataclass(frozen=True, repr=False)
class Map(ArraysGlance):
    """A raster in plan: values (rows, columns), row i at y0 + i cell, column j at x0 + j cell [m], relative to the
    origin."""

    values: Numbers
    x0: float
    y0: float
    cell: float
    units: str

    def _cells(self, plan: Floats) -> Floats:
        """Row and column (2, k) of places (k, 2) [m] relative to the origin; whole ones are middles of cells."""
        at = (np.asarray(plan, float) - [self.x0, self.y0]) / self.cell
        return np.asarray(at.T[::-1])

    def holds(self, plan: Floats) -> NDArray[np.bool_]:
        """Which places (k, 2) [m], relative to the origin, lie in it."""
        at, last = self._cells(plan), np.array(self.values.shape)[:, None] - 0.5
        return np.asarray(((at >= -0.5) & (at < last)).all(axis=0))

    def nearest(self, plan: Floats) -> Floats:
        """Values (k,) of the cells that places (k, 2) lie in; NaN beside it."""
        inside = self.holds(plan)
        found = np.full(len(inside), np.nan)
        row, column = np.floor(self._cells(plan)[:, inside] + 0.5).astype(int)
        found[inside] = self.values[row, column]
        return found

    def between(self, plan: Floats) -> Floats:
        """Values (k,) at places (k, 2), linear between the middles of cells; 0 beside it, and for what is not
        finite."""
        from scipy.ndimage import map_coordinates

        values = np.where(np.isfinite(self.values), self.values, 0.0).astype(float)
        inside = self.holds(plan)
        found = np.zeros(len(inside))
        found[inside] = map_coordinates(values, self._cells(plan)[:, inside], order=1, mode="nearest")
        return found
