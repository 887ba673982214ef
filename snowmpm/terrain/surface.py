"""The ground: a surface of segments (2-D) or triangles (3-D), read in plan like a map."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain import topology
from snowmpm.terrain.plan_bins import bin_facets, bin_squares

ON_EDGE = 1e-9  # barycentric slack: a plan position on the line between two facets belongs to both


@dataclass(frozen=True, eq=False)
class TerrainSurface:
    """Ground surface. Build it with `TerrainSurface.of`, which welds, cleans and orients.

    vertices: (n, dim) float64 [m], scene coordinates, last axis up; facets: (m, dim) int32, segments or triangles whose
    normals point out of the ground; closed: the surface encloses a volume (a block, an obstacle) instead of being a
    sheet; system: `ReferenceSystem` of x and y, None where none is known; lattice: of a surface made from an elevation
    raster, a corner of its cells (2,) and their side [m].
    """

    vertices: np.ndarray
    facets: np.ndarray
    closed: bool = False
    system: Any = None
    lattice: tuple | None = None

    @classmethod
    def of(cls, vertices, facets):
        """Surface of any vertices (n, dim) and facets (m, dim): repeated, degenerate and flipped facets are put right.

        InputError: no facet is left, or a coordinate is not finite.
        """
        vertices, facets = topology.tidied(_within_reach(vertices), np.asarray(facets))
        if len(facets) == 0:
            raise InputError("terrain: the surface has no facet with an area")
        facets, closed = topology.oriented(vertices, facets)
        return cls(vertices, np.ascontiguousarray(facets, dtype=np.int32), closed)

    @classmethod
    def sheet(cls, vertices, facets):
        """Open surface of facets that are right already, as those of a raster: every vertex is used and
        has a place of its own, all facets have an area and face up. `of` would find this out, in 1 us a facet.

        InputError: a coordinate is not finite.
        """
        return cls(_within_reach(vertices), np.ascontiguousarray(facets, dtype=np.int32))

    @property
    def dim(self):
        return self.vertices.shape[1]

    @cached_property
    def lower(self):
        """Lowest coordinates (dim,) [m]."""
        return self.vertices.min(axis=0)

    @cached_property
    def upper(self):
        """Highest coordinates (dim,) [m]."""
        return self.vertices.max(axis=0)

    @cached_property
    def facet_normals(self):
        """Unit normals of the facets (m, dim)."""
        return topology.facet_normals(self.vertices, self.facets)

    @cached_property
    def vertex_normals(self):
        """Angle-weighted unit normals at the vertices (n, dim)."""
        return topology.vertex_normals(self.vertices, self.facets)

    @cached_property
    def _bins(self):
        squares = bin_squares(self.vertices, self.facets, self.lattice[1]) if self.lattice else None
        return squares or bin_facets(self.vertices, self.facets)

    def area(self):
        """Area [m2] measured on the surface, not in plan; length [m] in 2-D."""
        return float(topology.facet_measures(self.vertices, self.facets).sum())

    def volume(self):
        """Enclosed volume [m3] (area [m2] in 2-D) of a closed surface."""
        corner = self.vertices[self.facets] - self.vertices.mean(axis=0)
        return float(np.abs(np.linalg.det(corner).sum())) / (2.0 if self.dim == 2 else 6.0)

    def recentred(self, origin):
        """The same surface in coordinates relative to `origin` (dim,) [m]."""
        return TerrainSurface(self.vertices - np.asarray(origin, float), self.facets, self.closed)  # no map

    def clipped(self, lower, upper):
        """The part whose facets touch the plan box from `lower` to `upper` [m]; a height in the corners is ignored.

        InputError: no facet touches the box.
        """
        d = self.dim - 1
        lower, upper = np.asarray(lower, float)[:d], np.asarray(upper, float)[:d]
        corner = self.vertices[self.facets][:, :, :d]
        touches = ((corner.max(axis=1) >= lower) & (corner.min(axis=1) <= upper)).all(axis=1)
        if not touches.any():
            raise InputError(f"terrain: nothing of it lies between {lower.tolist()} and {upper.tolist()} in plan")
        if touches.all():
            return self
        used, facets = np.unique(self.facets[touches], return_inverse=True)
        facets = facets.reshape(-1, self.dim).astype(np.int32)
        return replace(self, vertices=self.vertices[used], facets=facets, closed=False)

    @cached_property
    def _plan_maps(self):
        """Per facet: plan position of corner 0, by axis [(m,)], and the map from plan offsets to the other corners'
        weights, by corner and axis [[(m,)]]. An array for each number is looked up several times as fast as rows.

        NaN where the facet stands upright and covers no plan.
        """
        corners = [[np.ascontiguousarray(self.vertices[self.facets[:, k], a]) for a in range(self.dim - 1)]
                   for k in range(self.dim)]
        first, edges = corners[0], [[x - x0 for x, x0 in zip(corner, corners[0], strict=True)]
                                    for corner in corners[1:]]  # offsets of the other corners
        if self.dim == 2:
            det, adjugate = edges[0][0], [[np.ones(len(self.facets))]]
        else:
            (ax, ay), (bx, by) = edges
            det, adjugate = ax * by - ay * bx, [[by, -bx], [-ay, ax]]
        longest = np.max([np.abs(edge).max(axis=0) for edge in edges], axis=0)
        with np.errstate(divide="ignore"):
            factor = np.where(np.abs(det) > 1e-12 * longest ** (self.dim - 1), 1.0 / det, np.nan)
        return first, [[entry * factor for entry in row] for row in adjugate]

    def locate(self, plan):
        """Highest facet above or below plan positions (k, dim - 1).

        -> facet (k,), -1 where there is none (outside, or over a hole); weights (k, dim) of its corners, summing to 1.
        """
        plan = np.ascontiguousarray(plan, dtype=np.float64).reshape(-1, self.dim - 1)
        best = np.full(len(plan), -1, np.int64)
        best_height = np.full(len(plan), -np.inf)
        best_weights = np.full((len(plan), self.dim), np.nan)
        for point, facet, weights, height in self._crossings(plan):
            higher = height > best_height[point]
            point = point[higher]
            best[point], best_height[point], best_weights[point] = facet[higher], height[higher], weights[higher]
        return best, best_weights

    def _crossings(self, plan):
        """What the verticals through plan positions cross, each at most once in a turn: positions, facets, weights of
        their corners, heights [m]."""
        bins, (start_corner, to_weights) = self._bins, self._plan_maps
        number, place = bins.numbers(plan), [np.ascontiguousarray(column) for column in plan.T]
        start = bins.starts[number]
        count = np.where(number >= 0, bins.starts[number + 1] - start, 0)
        for k in range(int(count.max(initial=0))):
            point = np.flatnonzero(count > k)
            facet = bins.items[start[point] + k]
            offset = [x[point] - x0[facet] for x, x0 in zip(place, start_corner, strict=True)]
            others = [_added([a[facet] * b for a, b in zip(row, offset, strict=True)]) for row in to_weights]
            first = 1.0 - sum(others)
            hit = first >= -ON_EDGE
            for weight in others:
                hit &= weight >= -ON_EDGE
            hit = np.flatnonzero(hit)
            point, facet = point[hit], facet[hit]
            weights = np.stack([first[hit], *(weight[hit] for weight in others)], axis=1)
            yield point, facet, weights, _dot(weights, self.vertices[self.facets[facet], -1])

    def layers(self):
        """How far the surface reaches above and below itself: per facet that covers some plan, the vertical distance
        (k,) [m] between the highest and the lowest facet over its middle, 0 if there is only itself; and these
        middles (k, dim - 1) [m]."""
        covers = np.isfinite(self._plan_maps[1][0][0])
        middle = self.vertices[self.facets[covers]].mean(axis=1)
        high, low = middle[:, -1].copy(), middle[:, -1].copy()
        for point, _, _, height in self._crossings(np.ascontiguousarray(middle[:, :-1])):
            high[point], low[point] = np.maximum(high[point], height), np.minimum(low[point], height)
        return high - low, middle[:, :-1]

    def height(self, plan):
        """Height (k,) [m] of the highest surface point at plan positions (k, dim - 1); NaN outside and over holes."""
        facet, weights = self.locate(plan)
        height = _dot(weights, self.vertices[self.facets[facet], -1])
        return np.where(facet >= 0, height, np.nan)

    def normal(self, plan):
        """Upward unit normals (k, dim), continuous (interpolated between vertices); NaN outside and over holes."""
        facet, weights = self.locate(plan)
        normal = (weights[:, :, None] * self.vertex_normals[self.facets[facet]]).sum(axis=1)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def gradient(self, plan, width):
        """Slope dh/dplan (k, dim - 1) from heights `width` [m] to both sides; one-sided at a border, NaN off it.

        On a plane it is exact; at a kink it changes over twice the width.
        """
        plan = np.ascontiguousarray(plan, dtype=np.float64).reshape(-1, self.dim - 1)
        here = self.height(plan)
        slope = np.empty_like(plan)
        for axis in range(self.dim - 1):
            step = np.zeros(self.dim - 1)
            step[axis] = width
            rise = [(self.height(plan + step) - here) / width, (here - self.height(plan - step)) / width]
            rise = [np.where(np.isnan(a), b, a) for a, b in (rise, rise[::-1])]
            slope[:, axis] = 0.5 * (rise[0] + rise[1])
        # An islet narrower than the width: the facet's own slope.
        lost = np.isnan(slope).any(axis=1) & ~np.isnan(here)
        if lost.any():
            normal = self.facet_normals[self.locate(plan[lost])[0]]
            slope[lost] = -normal[:, :-1] / normal[:, -1:]
        return slope

    def smooth_normal(self, plan, width):
        """Upward unit normals (k, dim) of `gradient`: continuous in plan whatever the size of the facets."""
        slope = self.gradient(plan, width)
        normal = np.column_stack([-slope, np.ones(len(slope))])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _within_reach(vertices):
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    if not (np.abs(vertices) <= topology.LARGEST).all():
        raise InputError("terrain: a vertex has a coordinate that is not a finite number, or out of reach")
    return vertices


def _dot(a, b):
    """Row by row (k, n) . (k, n); for rows this short a sum over an axis takes several times as long."""
    return _added([a[:, j] * b[:, j] for j in range(a.shape[1])])


def _added(arrays):
    """Their sum, in the first of them."""
    total = arrays[0]
    for array in arrays[1:]:
        total += array
    return total
