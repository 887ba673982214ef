"""Points on the surface of a body: their areas, and how these follow a deformation."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.components.face_loads.face_points import FacePoints, cofactors
from snowmpm.components.face_loads.from_scene import points_on
from snowmpm.solids.shape import SolidShape

SHAPES = {
    "square": ({"kind": "box", "min": [0.1, 0.2], "max": [0.6, 1.0]}, 2, 2.6, 0.0),
    "disc": ({"kind": "sphere", "centre": [0.3, 0.2], "radius": 0.5}, 2, np.pi, 5e-4),
    "box": ({"kind": "box", "min": [0.0, 0.1, 0.2], "max": [0.5, 0.6, 0.9]}, 3, 1.9, 0.0),
    "ball": ({"kind": "sphere", "centre": [0.1, 0.2, 0.3], "radius": 0.5}, 3, np.pi, 3e-3),
    "corner": ({"kind": "polygon", "points": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.7, 1.0], [0.7, 0.3], [0.0, 0.3]]},
               2, 4.0, 0.0),
    "cylinder": ({"kind": "cylinder", "base": [0.0, 0.0, 0.0], "axis": [1.0, 1.0, 1.0], "radius": 0.3, "height": 0.7},
                 3, 2.0 * np.pi * 0.3 * 1.0, 2e-3),
}


@pytest.mark.parametrize("name", SHAPES)
def test_areas_of_a_closed_surface(name):
    """They add up to its area, as vectors to nothing, and with their places to the volume in each direction."""
    spec, dim, expected, tolerance = SHAPES[name]
    shape = SolidShape.of(SimpleNamespace(**spec), dim)
    rest, area = points_on(shape, 0.08)
    size = np.linalg.norm(area, axis=1)
    assert size.max() <= (0.08 if dim == 2 else 0.08**2) * (1.0 + 1e-9)
    assert size.sum() == pytest.approx(expected, rel=max(tolerance, 1e-12))
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-12)
    inside = np.einsum("ni,nj->ij", rest, area)
    np.testing.assert_allclose(inside, np.trace(inside) / dim * np.eye(dim), atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_areas_follow_by_nansons_formula(dim):
    """In steps as at once; a parallelogram that is carried along has the area of its sides."""
    rng = np.random.default_rng(1)
    steps = 0.3 * rng.standard_normal((3, 4, dim, dim))
    sides = rng.standard_normal((4, dim - 1, dim))
    normal = np.cross(sides[:, 0], sides[:, 1]) if dim == 3 else np.stack([sides[:, 0, 1], -sides[:, 0, 0]], axis=1)
    points = FacePoints.of(np.arange(4), np.ones((4, dim)), normal, np.zeros((4, dim)))
    for A in steps:
        points.move_with(A, np.zeros((4, dim)))
        sides = np.einsum("nij,nkj->nki", A + np.eye(dim), sides)
        np.testing.assert_allclose(cofactors(A), np.linalg.det(A + np.eye(dim))[:, None, None] * np.swapaxes(
            np.linalg.inv(A + np.eye(dim)), 1, 2), rtol=1e-9, atol=1e-12)
    now = np.cross(sides[:, 0], sides[:, 1]) if dim == 3 else np.stack([sides[:, 0, 1], -sides[:, 0, 0]], axis=1)
    np.testing.assert_allclose(points.area, now, rtol=1e-10, atol=1e-12)
