"""Signed distance and outward normal of box, ball and cylinder, in the frame of the solid: Taichi functions.

Points are relative to the middle of the solid, along its axes. Distance > 0 outside; n = grad d where that exists, else
one of its limits. Lengths in any one unit.
"""

from snowmpm.compiler import ti

BOX, BALL, CYLINDER, SAMPLED = range(4)


@ti.func
def sign(a):
    """-1 for negative numbers, else 1."""
    return ti.select(a < 0.0, a * 0.0 - 1.0, a * 0.0 + 1.0)


@ti.func
def box_distance(dim: ti.template(), x, half):
    """Box of half sides `half`; -> d, n. Outside beyond an edge or a corner the distance to that."""
    out = ti.abs(x) - half
    away = ti.max(out, 0.0)
    d = away.norm()
    n = away / ti.max(d, 1e-30)
    if d == 0.0:
        nearest = 0
        for k in ti.static(range(1, dim)):
            if out[k] > out[nearest]:
                nearest = k
        d = out[nearest]
        for k in ti.static(range(dim)):
            n[k] = ti.select(k == nearest, d * 0.0 + 1.0, d * 0.0)
    for k in ti.static(range(dim)):
        n[k] *= sign(x[k])
    return d, n


@ti.func
def ball_distance(dim: ti.template(), x, radius):
    """Ball, a disc in 2-D; -> d, n."""
    r = x.norm()
    n = x / ti.max(r, 1e-30)
    if r == 0.0:
        n[dim - 1] = 1.0
    return r - radius, n


@ti.func
def cylinder_distance(x, radius, half_height):
    """Cylinder along the last axis (3-D); -> d, n. A box in the plane of radius and height, turned about the axis."""
    r = ti.sqrt(x[0] ** 2 + x[1] ** 2)
    d, m = box_distance(2, ti.Vector([r, x[2]]), ti.Vector([radius, half_height]))
    across = m[0] / ti.max(r, 1e-30)
    n = ti.Vector([across * x[0], across * x[1], m[1]])
    if r == 0.0:
        n[0] = m[0]
    return d, n


@ti.func
def primitive_distance(dim: ti.template(), kind, x, size):
    """d, n of a primitive; size (3,): half sides of a box, (radius, -, -) or (radius, -, half height)."""
    d, n = x[0], x
    if kind == BALL:
        d, n = ball_distance(dim, x, size[0])
    elif kind == CYLINDER:
        if ti.static(dim == 3):
            d, n = cylinder_distance(x, size[0], size[2])
    else:
        half = x
        for k in ti.static(range(dim)):
            half[k] = size[k]
        d, n = box_distance(dim, x, half)
    return d, n
