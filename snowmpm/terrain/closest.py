"""Nearest point of a segment or a triangle, and on which of its parts it lies."""

from snowmpm.compiler import ti

FACE = 0  # inner points; corner k is 1 + k, in 3-D edge k (from corner k to k + 1) is 4 + k


@ti.func
def closest_on_segment(p, a, b):
    """Nearest point of segment a-b to p (ti vectors, 2-D) and the part: FACE, 1 (at a) or 2 (at b)."""
    edge = b - a
    s = (p - a).dot(edge) / edge.dot(edge)
    part = 0
    if s <= 0.0:
        s = 0.0
        part = 1
    elif s >= 1.0:
        s = 1.0
        part = 2
    q = a + s * edge
    if part == 2:
        q = b
    return q, part


@ti.func
def closest_on_triangle(p, a, b, c):
    """Nearest point of triangle a-b-c to p (ti vectors, 3-D) and the part: FACE, 1..3 corners, 4..6 edges ab, bc, ca.

    Voronoi regions of the triangle; C. Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    ab, ac = b - a, c - a
    ap, bp, cp = p - a, p - b, p - c
    d1, d2 = ab.dot(ap), ac.dot(ap)
    d3, d4 = ab.dot(bp), ac.dot(bp)
    d5, d6 = ab.dot(cp), ac.dot(cp)
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    q = a
    part = 0
    if d1 <= 0.0 and d2 <= 0.0:
        part = 1
    elif d3 >= 0.0 and d4 <= d3:
        q = b
        part = 2
    elif d6 >= 0.0 and d5 <= d6:
        q = c
        part = 3
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        q = a + d1 / (d1 - d3) * ab
        part = 4
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        q = b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)
        part = 5
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        q = a + d2 / (d2 - d6) * ac
        part = 6
    else:
        w = 1.0 / (va + vb + vc)
        q = a + (vb * w) * ab + (vc * w) * ac
    return q, part
