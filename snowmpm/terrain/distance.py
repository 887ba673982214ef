"""Signed distance to the ground, exact, many points at a time."""

import functools

import numpy as np
import taichi as ti

from snowmpm import runtime
from snowmpm.terrain import topology
from snowmpm.terrain.closest import closest_on_segment, closest_on_triangle
from snowmpm.terrain.plan_bins import bin_facets

POINTS_PER_TASK = 64
TASK_STRIDE = 512  # Taichi hands a CPU thread this many iterations at a time: one task per stride lets all threads work
ON_EDGE = 1e-9  # barycentric slack of the vertical line through a point: no gap between neighbouring facets
AT_SURFACE = 1e-10  # of the surface's size: nearer than this the direction to the nearest point is round-off


class DistanceField:
    """Exact signed Euclidean distance and its gradient, for segments (2-D) and triangles (3-D), in float64.

        d(x) = +-min_f |x - closest point of facet f|,   n = grad d

    d > 0 above the ground. The sign is that of (x - closest point) . (normal of the face, edge or corner it lies on), with
    angle-weighted normals at corners: J. A. Baerentzen and H. Aanaes (2005), doi:10.1109/TVCG.2005.49.

    - Further than `reach` [m]: +-reach, the sign from the facet straight above or below; normal of that facet.
    - Open surfaces end at their border: where no facet lies above or below (outside in plan, over a hole), d = +reach and
      the normal is up. Closed surfaces have no such limit; out of reach of them d = +-reach, the sign being right.
    - On the surface itself the normal is that of the face, edge or corner.

    Facets are sorted into plan bins of `bin_size` [m] (default: about one facet wide).
    """

    def __init__(self, surface, reach, bin_size=None):
        runtime.start()
        self.dim, self.reach = surface.dim, float(reach)
        # Local origin: differences of map coordinates would lose digits in products.
        self.origin = 0.5 * (surface.lower + surface.upper)
        vertices = surface.vertices - self.origin
        bins = bin_facets(vertices, surface.facets, bin_size)
        corner = vertices[surface.facets]
        joint, joint_normal = topology.joint_normals(vertices, surface.facets)
        size = float(np.max(surface.upper - surface.lower))
        shape = np.ones(2, np.int64)
        shape[: self.dim - 1] = bins.shape
        lower = np.zeros(2)
        lower[: self.dim - 1] = bins.lower
        self._scalars = (self.reach, bins.size, *lower, *shape.tolist(), int(surface.closed), AT_SURFACE * size)
        self._tables = tuple(
            _on_device(table)
            for table in (
                bins.starts,
                bins.items,
                _height_ranges(bins, corner[:, :, -1]),
                corner.reshape(len(corner), -1),
                surface.facet_normals,
                surface.facets,
                surface.vertex_normals,
                joint,
                joint_normal,
            )
        )

    def query(self, points):
        """Signed distance (k,) [m] and unit normal (k, dim) at points (k, dim) [m]."""
        points = np.ascontiguousarray(np.asarray(points, dtype=np.float64).reshape(-1, self.dim) - self.origin)
        distance, normal = np.empty(len(points)), np.empty_like(points)
        if len(points):
            with runtime.precision("f64"):
                _query_kernel(self.dim)(points, distance, normal, *self._tables, *self._scalars)
        return distance, normal


def _on_device(table):
    array = ti.ndarray(ti.i32 if table.dtype.kind == "i" else ti.f64, table.shape)
    array.from_numpy(np.ascontiguousarray(table, np.int32 if table.dtype.kind == "i" else np.float64))
    return array


def _height_ranges(bins, heights):
    """Lowest and highest height (n_bins, 2) of the facets listed in each bin; empty bins get an empty range."""
    ranges = np.tile([np.inf, -np.inf], (len(bins.starts) - 1, 1))
    filled = np.flatnonzero(np.diff(bins.starts))
    if len(filled):
        first = bins.starts[filled]
        ranges[filled, 0] = np.minimum.reduceat(heights.min(axis=1)[bins.items], first)
        ranges[filled, 1] = np.maximum.reduceat(heights.max(axis=1)[bins.items], first)
    return ranges


@functools.cache
def _query_kernel(dim):
    """Kernel of one dimension; made on first use so that importing this module compiles nothing."""
    floats, ints = ti.types.ndarray(dtype=ti.f64, ndim=2), ti.types.ndarray(dtype=ti.i32, ndim=1)
    int_rows = ti.types.ndarray(dtype=ti.i32, ndim=2)

    @ti.func
    def row(table: ti.template(), i):
        return ti.Vector([table[i, k] for k in ti.static(range(dim))])

    @ti.func
    def corner(corners: ti.template(), f, k: ti.template()):
        return ti.Vector([corners[f, k * dim + j] for j in ti.static(range(dim))])

    @ti.func
    def closest(p, corners: ti.template(), f):
        q = corner(corners, f, 0)
        part = 0
        if ti.static(dim == 2):
            q, part = closest_on_segment(p, corner(corners, f, 0), corner(corners, f, 1))
        else:
            q, part = closest_on_triangle(p, corner(corners, f, 0), corner(corners, f, 1), corner(corners, f, 2))
        return q, part

    @ti.func
    def height_over(p, corners: ti.template(), f):
        """Whether the vertical line through p meets facet f, and p's height above that point."""
        a, b = corner(corners, f, 0), corner(corners, f, 1)
        hit, above = False, 0.0
        if ti.static(dim == 2):
            width = b[0] - a[0]
            if width != 0.0:
                s = (p[0] - a[0]) / width
                if s >= -ON_EDGE and s <= 1.0 + ON_EDGE:
                    hit = True
                    above = p[1] - a[1] - s * (b[1] - a[1])
        else:
            u, v, r = b - a, corner(corners, f, 2) - a, p - a
            det = u[0] * v[1] - u[1] * v[0]
            if ti.abs(det) > 1e-12 * (u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1]):
                s = (r[0] * v[1] - r[1] * v[0]) / det
                t = (u[0] * r[1] - u[1] * r[0]) / det
                if s >= -ON_EDGE and t >= -ON_EDGE and s + t <= 1.0 + ON_EDGE:
                    hit = True
                    above = r[2] - s * u[2] - t * v[2]
        return hit, above

    @ti.kernel
    def query(
        points: floats,
        distance: ti.types.ndarray(dtype=ti.f64, ndim=1),
        normal: floats,
        starts: ints,
        items: ints,
        ranges: floats,
        corners: floats,
        facet_normal: floats,
        facets: int_rows,
        vertex_normal: floats,
        joint: int_rows,
        joint_normal: floats,
        reach: ti.f64,
        bin_size: ti.f64,
        lower_x: ti.f64,
        lower_y: ti.f64,
        n_x: ti.i32,
        n_y: ti.i32,
        closed: ti.i32,
        at_surface: ti.f64,
    ):
        n_tasks = (points.shape[0] + POINTS_PER_TASK - 1) // POINTS_PER_TASK
        for task in range(n_tasks * TASK_STRIDE):
            if task % TASK_STRIDE == 0:
                first = task // TASK_STRIDE * POINTS_PER_TASK
                for i in range(first, ti.min(first + POINTS_PER_TASK, points.shape[0])):
                    p = row(points, i)
                    offset_x, offset_y = (p[0] - lower_x) / bin_size, 0.5
                    if ti.static(dim == 3):
                        offset_y = (p[1] - lower_y) / bin_size
                    # Far outside the bins the ring search must neither overflow nor run long.
                    far = reach / bin_size + 2.0
                    near = offset_x > -far and offset_x < n_x + far and offset_y > -far and offset_y < n_y + far
                    d, n = reach, ti.Vector.zero(ti.f64, dim)
                    n[dim - 1] = 1.0

                    # The facet straight above or below: is there ground at all, and on which side of it are we?
                    column, gap, side = -1, 0.0, 1.0
                    bx, by = 0, 0
                    if near:
                        bx, by = ti.floor(offset_x, ti.i32), ti.floor(offset_y, ti.i32)
                        if bx >= 0 and bx < n_x and by >= 0 and by < n_y:
                            b = bx * n_y + by
                            for k in range(starts[b], starts[b + 1]):
                                f = items[k]
                                hit, above = height_over(p, corners, f)
                                if hit and (column < 0 or ti.abs(above) < gap):
                                    column, gap = f, ti.abs(above)
                                    side = 1.0 if above * facet_normal[f, dim - 1] >= 0.0 else -1.0

                    if near and (closed == 1 or column >= 0):
                        best, nearest, part, q = reach * reach, -1, 0, p
                        inner = ti.min(offset_x - bx, bx + 1.0 - offset_x)
                        if ti.static(dim == 3):
                            inner = ti.min(inner, ti.min(offset_y - by, by + 1.0 - offset_y))
                        ring = 0
                        while ring == 0 or (ring - 1.0 + inner) * bin_size < ti.sqrt(best):
                            rows = ring if ti.static(dim == 3) else 0
                            for jy in range(by - rows, by + rows + 1):
                                step = 1
                                if ring > 0 and (ti.static(dim == 2) or ti.abs(jy - by) < ring):
                                    step = 2 * ring
                                jx = bx - ring
                                while jx <= bx + ring:
                                    if jx >= 0 and jx < n_x and jy >= 0 and jy < n_y:
                                        b = jx * n_y + jy
                                        gx = ti.max(0.0, ti.max(jx - offset_x, offset_x - jx - 1.0)) * bin_size
                                        gy = 0.0
                                        if ti.static(dim == 3):
                                            gy = ti.max(0.0, ti.max(jy - offset_y, offset_y - jy - 1.0)) * bin_size
                                        gz = ti.max(0.0, ti.max(ranges[b, 0] - p[dim - 1], p[dim - 1] - ranges[b, 1]))
                                        if gx * gx + gy * gy + gz * gz < best:
                                            for k in range(starts[b], starts[b + 1]):
                                                f = items[k]
                                                c, where = closest(p, corners, f)
                                                square = (p - c).norm_sqr()
                                                if square < best:
                                                    best, nearest, part, q = square, f, where, c
                                    jx += step
                            ring += 1

                        if nearest < 0:
                            d = side * reach
                            if column >= 0:
                                n = row(facet_normal, column)
                        else:
                            n = row(facet_normal, nearest)
                            if part > dim:
                                n = row(joint_normal, joint[nearest, part - 4])
                            elif part > 0:
                                n = row(vertex_normal, facets[nearest, part - 1])
                            away = p - q
                            side = 1.0 if away.dot(n) >= 0.0 else -1.0
                            d = ti.sqrt(best)
                            if part > 0 and d > at_surface:
                                n = side / d * away
                            d *= side
                    distance[i] = d
                    for k in ti.static(range(dim)):
                        normal[i, k] = n[k]

    return query
