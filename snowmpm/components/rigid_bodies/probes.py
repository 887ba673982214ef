"""Points on the surface of a rigid body at which it feels what it touches."""

import numpy as np

from snowmpm.solids.primitives import BALL, CYLINDER

MOST = {2: 65, 3: 9}
"""Points along a side, at most, by dimension."""

AROUND = 96
"""Points around the rim of a cylinder."""


def probes(shape, spacing):
    """Points (k, dim) [m] of a `SolidShape` where it is at the start, about `spacing` [m] apart, and the radius [m] of
    the ball around each that belongs to the body: 0, but for a ball, whose only point is its centre.

    Corners and edges are always among them, so what lies flat on a plane rests on its outermost points whatever the
    spacing is.
    """
    if shape.surface is not None:
        return _on_facets(shape.surface, spacing), 0.0
    if shape.kind == BALL:
        return shape.origin[None], float(shape.size[0])
    unit = _on_cylinder(shape, spacing) if shape.kind == CYLINDER else _on_box(shape, spacing)
    return shape.origin + (unit * shape.size) @ shape.axes, 0.0


def _along(half, spacing, dim):
    n = min(MOST[dim], int(np.ceil(2.0 * half / spacing)) + 1)
    return np.linspace(-1.0, 1.0, max(2, n))


def _on_box(shape, spacing):
    """Points of the surface of [-1, 1]^dim."""
    axes = [_along(half, spacing, shape.dim) for half in shape.size]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, shape.dim)
    return grid[(np.abs(grid) == 1.0).any(axis=1)]


def _on_cylinder(shape, spacing):
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    side = [np.column_stack([rim, np.full(AROUND, z)]) for z in _along(shape.size[2], spacing, 3)]
    ends = [np.column_stack([share * rim[::8], np.full(AROUND // 8, z)]) for share in (0.0, 0.5) for z in (-1.0, 1.0)]
    return np.concatenate([*side, *ends])


def _on_facets(surface, spacing):
    """Corners of a polygon or mesh, and points between them."""
    corners = surface.vertices[surface.facets]
    if corners.shape[1] == 3:
        middle = corners.mean(axis=1)
        large = np.sqrt(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                                       axis=1)) > spacing
        return np.concatenate([surface.vertices, middle[large]])
    points = [surface.vertices]
    for start, end in corners:
        share = _along(0.5 * np.linalg.norm(end - start), spacing, 2)[1:-1, None]
        points.append(0.5 * (start + end) + 0.5 * share * (end - start))
    return np.concatenate(points)
