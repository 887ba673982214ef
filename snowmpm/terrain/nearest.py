"""The facet nearest to a point: of all facets, the search visits only the bins that can hold it."""

from snowmpm.compiler import ti
from snowmpm.terrain.closest import closest_on_segment, closest_on_triangle

ON_EDGE = 1e-9  # barycentric slack of the vertical line through a point: no gap between neighbouring facets

# Tables of one surface, all made by `DistanceField`: starts (n_bins + 1,), items: facets of each bin; ranges (n_bins,
# 2): lowest and highest height in each bin; corners (m, dim * dim): coordinates of each facet's corners, one after the
# other.


@ti.func
def corner(dim: ti.template(), corners: ti.template(), f, k: ti.template()):
    """Corner k of facet f, from the table of corners (facets, dim * dim) [m]."""
    return ti.Vector([corners[f, k * dim + j] for j in ti.static(range(dim))])


@ti.func
def closest(dim: ti.template(), p, corners: ti.template(), f):
    """Nearest point of facet f and the part of it (see `closest.py`)."""
    q = corner(dim, corners, f, 0)
    part = 0
    if ti.static(dim == 2):
        q, part = closest_on_segment(p, q, corner(dim, corners, f, 1))
    else:
        q, part = closest_on_triangle(p, q, corner(dim, corners, f, 1), corner(dim, corners, f, 2))
    return q, part


@ti.func
def height_over(dim: ti.template(), p, corners: ti.template(), f):
    """Whether the vertical line through p meets facet f, and p's height above that point."""
    a = corner(dim, corners, f, 0)
    u, r = corner(dim, corners, f, 1) - a, p - a
    hit, above = False, 0.0
    if ti.static(dim == 2):
        if u[0] != 0.0:
            s = r[0] / u[0]
            if s >= -ON_EDGE and s <= 1.0 + ON_EDGE:
                hit = True
                above = r[1] - s * u[1]
    else:
        v = corner(dim, corners, f, 2) - a
        det = u[0] * v[1] - u[1] * v[0]
        if ti.abs(det) > 1e-12 * (u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1]):
            s = (r[0] * v[1] - r[1] * v[0]) / det
            t = (u[0] * r[1] - u[1] * r[0]) / det
            if s >= -ON_EDGE and t >= -ON_EDGE and s + t <= 1.0 + ON_EDGE:
                hit = True
                above = r[2] - s * u[2] - t * v[2]
    return hit, above


@ti.func
def facet_in_column(dim: ti.template(), p, b, starts: ti.template(), items: ti.template(), corners: ti.template()):
    """The facet of bin b that the vertical line through p meets nearest to p, -1 if none, and p's height above it."""
    column, height = -1, 0.0
    for k in range(starts[b], starts[b + 1]):
        hit, above = height_over(dim, p, corners, items[k])
        if hit and (column < 0 or ti.abs(above) < ti.abs(height)):
            column, height = items[k], above
    return column, height


@ti.func
def bin_gap(dim: ti.template(), p, at, j, size, lowest, highest):
    """Square of the distance from p to the part of space that bin j occupies; at: p in bins."""
    gx = ti.max(0.0, ti.max(j[0] - at[0], at[0] - j[0] - 1.0)) * size
    gz = ti.max(0.0, ti.max(lowest - p[dim - 1], p[dim - 1] - highest))
    gap = gx * gx + gz * gz
    if ti.static(dim == 3):
        gy = ti.max(0.0, ti.max(j[1] - at[1], at[1] - j[1] - 1.0)) * size
        gap += gy * gy
    return gap


@ti.func
def nearest_facet(dim: ti.template(), p, at, facets: ti.template(), bins: ti.template()):
    """Nearest facet within reach (-1 if none), part, nearest point, square of the distance.

    at: p in bins; facets, bins: `distance.Facets`, `distance.Bins`. Bins are visited in square rings about p's own
    until the next ring is further than the best facet so far.
    """
    best, nearest, part, q = bins.reach * bins.reach, -1, 0, p
    bx, by = ti.floor(at[0], ti.i32), ti.floor(at[1], ti.i32)
    inner = ti.min(at[0] - bx, bx + 1.0 - at[0])
    if ti.static(dim == 3):
        inner = ti.min(inner, ti.min(at[1] - by, by + 1.0 - at[1]))
    ring = 0
    while ring == 0 or (ring - 1.0 + inner) * bins.size < ti.sqrt(best):
        rows = ring if ti.static(dim == 3) else 0
        for jy in range(ti.max(by - rows, 0), ti.min(by + rows, bins.n_y - 1) + 1):
            # Inner rows of a ring have only its two ends.
            step = 1
            if ring > 0 and (ti.static(dim == 2) or ti.abs(jy - by) < ring):
                step = 2 * ring
            jx = bx - ring
            while jx <= bx + ring:
                if jx >= 0 and jx < bins.n_x:
                    b = jx * bins.n_y + jy
                    gap = bin_gap(dim, p, at, ti.Vector([jx, jy]), bins.size, facets.ranges[b, 0], facets.ranges[b, 1])
                    if gap < best:
                        for k in range(facets.starts[b], facets.starts[b + 1]):
                            c, where = closest(dim, p, facets.corners, facets.items[k])
                            square = (p - c).norm_sqr()
                            if square < best:
                                best, nearest, part, q = square, facets.items[k], where, c
                jx += step
        ring += 1
    return nearest, part, q, best
