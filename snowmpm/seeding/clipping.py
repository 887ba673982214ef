"""The part of a body on the inner side of the domain's symmetric sides: half and quarter bodies of exact mass."""

import itertools
from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError

SEGMENTS = 1440
"""Sides of the polygon for the circle of a leaning cylinder; it gives only the share that is kept."""


def clipped(shape, spec, lower, upper, key):
    """Part of a `Shape` between the corners lower, upper (dim,) [m], infinite without a cut.

    spec: the scene's shape table, for its kind. The volume is exact, that of a leaning cylinder to 1e-5. An uncut
    shape is returned as it is. InputError: nothing is left.
    """
    corners = shape.origin + np.array(list(itertools.product([0.0, 1.0], repeat=len(lower)))) * shape.size @ shape.axes
    low, high = np.maximum(lower, corners.min(axis=0)), np.minimum(upper, corners.max(axis=0))
    slack = 1e-9 * shape.size.max()
    cuts = np.r_[lower > corners.min(axis=0) + slack, upper < corners.max(axis=0) - slack]
    if not cuts.any():
        return shape
    volume = 0.0 if (high <= low).any() else _volume(shape, spec, np.where(cuts[: len(lower)], lower, -np.inf),
                                                     np.where(cuts[len(lower):], upper, np.inf), key)
    if not volume > 1e-9 * shape.volume:
        raise InputError(f"{key}: lies wholly beyond a side of the domain")
    inside = shape.contains or (lambda points: np.ones(len(points), bool))

    def contains(points):
        return ((points >= lower) & (points < upper)).all(axis=1) & inside(points)

    axis_of = np.argmax(shape.axes, axis=1)
    if np.array_equal(shape.axes, np.eye(len(lower))[axis_of]):
        # The box shrinks to the cut, so that rows of particles align with it as with a wall
        origin, size = low, (high - low)[axis_of]
    else:
        origin, size = shape.origin, shape.size
    return replace(shape, origin=origin, size=size, volume=volume,
                   contains=None if spec.kind == "box" else contains)


def _volume(shape, spec, lower, upper, key):
    """Volume between two corners, infinite without a cut."""
    kind, dim = spec.kind, len(lower)
    if kind == "box":
        return float(np.prod(np.minimum(upper, spec.max) - np.maximum(lower, spec.min)))
    if shape.part is not None:
        return shape.part(lower, upper)
    if kind == "sphere":
        centre, radius = np.asarray(spec.centre, float), float(spec.radius)
        lower, upper = (lower - centre) / radius, (upper - centre) / radius
        return radius**dim * (disc_part(1.0, lower, upper) if dim == 2 else ball_part(lower, upper))
    if kind == "cylinder":
        return _of_cylinder(spec, lower, upper) * shape.volume
    if shape.facets is None:
        raise InputError(f"{key}: a side of the domain cuts it, and a {kind} does not say what volume is left: keep it"
                         " away from slip and symmetric sides")
    return part_of_mesh(shape.facets, lower, upper)


def _of_cylinder(spec, lower, upper):
    """Share of a cylinder's volume."""
    base, axis = np.asarray(spec.base, float), np.asarray(spec.axis, float)
    axis = spec.height * axis / np.linalg.norm(axis)
    along = np.flatnonzero(np.abs(axis) > 1e-12 * spec.height)
    if len(along) == 1:
        a, across = along[0], [b for b in range(3) if b != along[0]]
        ends = np.sort([base[a], base[a] + axis[a]])
        length = min(ends[1], upper[a]) - max(ends[0], lower[a])
        disc = disc_part(1.0, (lower - base)[across] / spec.radius, (upper - base)[across] / spec.radius)
        return disc / np.pi * length / spec.height
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u *= spec.radius / np.linalg.norm(u)
    turn = 2.0 * np.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    ring = base + np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * np.cross(axis, u) / spec.height
    a, b, first = ring[:-1], ring[1:], np.broadcast_to(base, ring[1:].shape)
    facets = np.concatenate([np.stack(corners, axis=1) for corners in (
        (first, b, a), (first + axis, a + axis, b + axis), (a, b, b + axis), (a, b + axis, a + axis))])
    free = np.full(3, np.inf)
    return part_of_mesh(facets, lower, upper) / part_of_mesh(facets, -free, free)


def disc_part(radius, lower, upper):
    """Area of a disc around the origin within a rectangle."""
    if not radius > 0.0:
        return 0.0
    (x0, y0), (x1, y1) = np.clip(lower / radius, -1.0, 1.0), np.clip(upper / radius, -1.0, 1.0)
    return radius**2 * (_quadrant(x1, y1) - _quadrant(x0, y1) - _quadrant(x1, y0) + _quadrant(x0, y0))


def _quadrant(a, b):
    """Area of the unit disc with x < a and y < b, both from -1 to 1."""

    def half(x):  # integral of sqrt(1 - x^2)
        return 0.5 * (x * np.sqrt(max(0.0, 1.0 - x * x)) + np.arcsin(x))

    edge = np.sqrt(1.0 - b * b)
    middle = np.clip(a, -edge, edge)
    area = b * (middle + edge) + half(middle) - half(-edge)
    if b > 0.0:
        area += 2.0 * (half(min(a, -edge)) - half(-1.0)) + 2.0 * (half(max(a, edge)) - half(edge))
    return area


def ball_part(lower, upper):
    """Volume of the unit ball around the origin within a block."""
    from scipy.integrate import quad  # slow to import, and few scenes need it

    bottom, top = np.clip([lower[2], upper[2]], -1.0, 1.0)
    # Where the circle of a slice begins to reach a side or an edge of the block
    ends = [np.abs(v) for v in (*lower[:2], *upper[:2])] + [np.hypot(x, y) for x in (lower[0], upper[0])
                                                             for y in (lower[1], upper[1])]
    kinks = {s * np.sqrt(1.0 - e * e) for e in ends if e < 1.0 for s in (-1.0, 1.0)}
    inner = sorted(k for k in kinks if bottom < k < top)
    return quad(lambda z: disc_part(np.sqrt(max(0.0, 1.0 - z * z)), lower[:2], upper[:2]), bottom, top,
                points=inner or None, limit=200, epsabs=1e-12)[0]


def _planes(lower, upper):
    """(axis, level, side kept) of the bounds that are finite."""
    return [(axis, level, sign) for sign, bounds in ((1.0, lower), (-1.0, upper))
            for axis, level in enumerate(bounds) if np.isfinite(level)]


def part_of_mesh(facets, lower, upper):
    """Volume within a block of what a closed mesh of facets (n, 3 corners, 3) encloses.

    As seen from a point in all cutting planes, the cut faces span no volume, so the remaining facets give the whole.
    """
    for axis in range(3):
        if np.isfinite(lower[axis]) and np.isfinite(upper[axis]):
            beyond, free = lower.copy(), upper.copy()
            beyond[axis], free[axis] = upper[axis], np.inf
            return part_of_mesh(facets, lower, free) - part_of_mesh(facets, beyond, free)
    planes, eye = _planes(lower, upper), facets.reshape(-1, 3).mean(axis=0)
    for axis, level, sign in planes:
        facets, eye[axis] = _cut(facets, axis, level, sign), level
    a, b, c = np.moveaxis(facets - eye, 1, 0)
    return float((np.cross(a, b) * c).sum() / 6.0)


def _cut(facets, axis, level, sign):
    """Facets (n, 3, 3) on one side of a plane across an axis; those that cross it are cut."""
    height = sign * (facets[:, :, axis] - level)
    inner = (height >= 0.0).sum(axis=1)
    parts = [facets[inner == 3]]
    for count in (1, 2):
        own, h = facets[inner == count], height[inner == count]
        # The corner that is alone on its side comes first
        alone = np.argmax(h >= 0.0 if count == 1 else h < 0.0, axis=1)
        order = (alone[:, None] + np.arange(3)) % 3
        (a, b, c), (ha, hb, hc) = (np.moveaxis(np.take_along_axis(own, order[:, :, None], axis=1), 1, 0),
                                   np.take_along_axis(h, order, axis=1).T[:, :, None])
        ab, ac = a + ha / (ha - hb) * (b - a), a + ha / (ha - hc) * (c - a)
        parts += [np.stack([a, ab, ac], axis=1)] if count == 1 else [np.stack([ab, b, c], axis=1),
                                                                     np.stack([ab, c, ac], axis=1)]
    return np.concatenate(parts)
