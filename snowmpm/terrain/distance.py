"""Signed distance to the ground, exact, many points at a time."""

import functools
from typing import NamedTuple

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.terrain import topology
from snowmpm.terrain.nearest import facet_in_column, nearest_facet
from snowmpm.terrain.plan_bins import bin_facets

POINTS_PER_TASK = 64
TASK_STRIDE = 512  # Taichi hands a CPU thread this many iterations at a time: one task per stride lets all threads work
AT_SURFACE = 1e-10  # of the surface's size: nearer than this the direction to the nearest point is round-off


class DistanceField:
    """Exact signed Euclidean distance and its gradient, for segments (2-D) and triangles (3-D), in float64.

        d(x) = +-min_f |x - closest point of facet f|,   n = grad d

    d > 0 above the ground. The sign is that of (x - closest point) . (normal of the face, edge or corner it lies on),
    with angle-weighted normals at corners: J. A. Baerentzen and H. Aanaes (2005), doi:10.1109/TVCG.2005.49.

    - Further than `reach` [m]: +-reach, the sign from the facet straight above or below; normal of that facet.
    - Open surfaces end at their border: where no facet lies above or below (outside in plan, over a hole), d = +reach
      and the normal is up. Closed surfaces have no such limit; out of reach of them d = +-reach with the right sign.
    - On the surface itself the normal is that of the face, edge or corner.

    Facets are sorted into plan bins of `bin_size` [m] (default: about one facet wide).
    """

    def __init__(self, surface, reach, bin_size=None):
        runtime.start()
        # As given, even if larger than the surface: snow may be deep on a small piece of ground
        self.dim = surface.dim
        self.reach = float(reach) if np.isfinite(reach) else float(np.linalg.norm(surface.upper - surface.lower))
        # Local origin: differences of map coordinates would lose digits in products.
        self.origin = 0.5 * (surface.lower + surface.upper)
        vertices = surface.vertices - self.origin
        bins = bin_facets(vertices, surface.facets, bin_size)
        corners = vertices[surface.facets]
        joint, joint_normal = topology.joint_normals(vertices, surface.facets)
        size = float(np.max(surface.upper - surface.lower))
        self._scalars = (self.reach, bins.size, *_pair(bins.lower, 0.0), *_pair(bins.shape.tolist(), 1))
        self._scalars += (int(surface.closed), AT_SURFACE * size)
        tables = (
            bins.starts,
            bins.items,
            _height_ranges(bins, corners[:, :, -1]),
            corners.reshape(len(corners), -1),
            surface.facet_normals,
            surface.facets,
            surface.vertex_normals,
            joint,
            joint_normal,
        )
        self._tables = tuple(_on_device(table) for table in tables)

    def query(self, points):
        """Signed distance (k,) [m] and unit normal (k, dim) at points (k, dim) [m]."""
        points = np.ascontiguousarray(np.asarray(points, dtype=np.float64).reshape(-1, self.dim) - self.origin)
        distance, normal = np.empty(len(points)), np.empty_like(points)
        if len(points):
            with runtime.precision("f64"):
                kernel = _distance_kernel(self.dim, len(points) <= POINTS_PER_TASK)
                kernel(points, distance, normal, Facets(*self._tables), Bins(*self._scalars))
        return distance, normal


def _pair(values, filler):
    """Numbers of both plan axes; a profile has one bin across."""
    return (*values, filler)[:2]


def _on_device(table):
    kind = np.int32 if table.dtype.kind == "i" else np.float64
    array = ti.ndarray(ti.i32 if kind is np.int32 else ti.f64, table.shape)
    array.from_numpy(np.ascontiguousarray(table, kind))
    return array


def _height_ranges(bins, heights):
    """Lowest and highest height (n_bins, 2) of the facets listed in each bin; empty bins get an empty range."""
    ranges = np.tile([np.inf, -np.inf], (len(bins.starts) - 1, 1))
    filled = np.flatnonzero(np.diff(bins.starts))
    first = bins.starts[filled]
    ranges[filled, 0] = np.minimum.reduceat(heights.min(axis=1)[bins.items], first)
    ranges[filled, 1] = np.maximum.reduceat(heights.max(axis=1)[bins.items], first)
    return ranges


class Facets(NamedTuple):
    """First item of each bin, the items, lowest and highest point of each bin's facets; corners, normals and vertices
    of the facets; normals of vertices; joints of each facet with others, and their normals."""

    starts: Array
    items: Array
    ranges: Array
    corners: Array
    facet_normal: Array
    vertices: Array
    vertex_normal: Array
    joint: Array
    joint_normal: Array


class Bins(NamedTuple):
    """reach [m]; size and first corner of the bins [m], and how many along both axes; whether the surface is closed;
    distance [m] below which a point lies on the surface."""

    reach: Real
    size: Real
    lower_x: Real
    lower_y: Real
    n_x: int
    n_y: int
    closed: int
    at_surface: Real


@ti.func
def _row(dim: ti.template(), table: ti.template(), i):
    return ti.Vector([table[i, k] for k in ti.static(range(dim))])


@functools.cache
def _distance_kernel(dim, few):
    """Kernel for points (k, dim); few: one thread finds their distances."""

    @grouped_kernel(ti.f64)
    def signed_distances(points: Array, distance: Array, normal: Array, facets: Facets, bins: Bins):
        """Fill distance (k,) and normal (k, dim) at points (k, dim); to be run in float64. Tables: see
        `DistanceField`."""
        ti.loop_config(serialize=ti.static(few))
        n_tasks = (points.shape[0] + POINTS_PER_TASK - 1) // POINTS_PER_TASK
        for task in range(n_tasks * TASK_STRIDE):
            if task % TASK_STRIDE == 0:
                first = task // TASK_STRIDE * POINTS_PER_TASK
                for i in range(first, ti.min(first + POINTS_PER_TASK, points.shape[0])):
                    p = _row(dim, points, i)
                    x, y = (p[0] - bins.lower_x) / bins.size, 0.5
                    if ti.static(dim == 3):
                        y = (p[1] - bins.lower_y) / bins.size
                    inside = x >= 0.0 and x < bins.n_x and y >= 0.0 and y < bins.n_y
                    d, n = bins.reach, ti.Vector.zero(ti.f64, dim)
                    n[dim - 1] = 1.0

                    column, side = -1, 1.0
                    if inside:
                        b = ti.floor(x, ti.i32) * bins.n_y + ti.floor(y, ti.i32)
                        column, above = facet_in_column(dim, p, b, facets.starts, facets.items, facets.corners)
                        if column >= 0:
                            n = _row(dim, facets.facet_normal, column)
                            side = 1.0 if above * n[dim - 1] >= 0.0 else -1.0
                            d = side * bins.reach

                    # In bins; beyond, a closed surface is out of reach and numbers may overflow
                    far = bins.reach / bins.size + 1.0
                    near = x > -far and x < bins.n_x + far and y > -far and y < bins.n_y + far
                    if column >= 0 or (bins.closed == 1 and near):
                        f, part, q, square = nearest_facet(dim, p, ti.Vector([x, y]), facets, bins)
                        if f >= 0:
                            n = _row(dim, facets.facet_normal, f)
                            if part > dim:
                                n = _row(dim, facets.joint_normal, facets.joint[f, part - 4])
                            elif part > 0:
                                n = _row(dim, facets.vertex_normal, facets.vertices[f, part - 1])
                            away = p - q
                            side = 1.0 if away.dot(n) >= 0.0 else -1.0
                            d = ti.sqrt(square)
                            if part > 0 and d > bins.at_surface:
                                n = side / d * away
                            d *= side
                    distance[i] = d
                    for k in ti.static(range(dim)):
                        normal[i, k] = n[k]

    return signed_distances
