"""The surface as a map: heights, normals, areas, clipping; and what it repairs."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.terrain import TerrainSurface


@pytest.fixture
def roof():
    """Two rectangles of 2 m x 3 m in plan that meet in a ridge at x = 2, z = 1; slopes 1:2."""
    vertices = [[0, 0, 0], [2, 0, 1], [4, 0, 0], [0, 3, 0], [2, 3, 1], [4, 3, 0]]
    triangles = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
    return np.array(vertices, float), np.array(triangles)


def test_heights_and_normals_of_a_roof(roof):
    surface = TerrainSurface.of(*roof)
    plan = np.array([[0.0, 0.0], [1.0, 1.5], [2.0, 3.0], [3.5, 0.1], [4.0, 3.0], [4.01, 1.0], [1.0, -0.1]])
    expected = [0.0, 0.5, 1.0, 0.25, 0.0, np.nan, np.nan]
    np.testing.assert_allclose(surface.height(plan), expected, atol=1e-14)  # round-off
    normal = surface.normal(plan)
    assert np.isnan(normal[5:]).all()
    np.testing.assert_allclose(normal[2], [0, 0, 1], atol=1e-14)  # on the ridge: between both sides
    np.testing.assert_allclose(np.linalg.norm(normal[:5], axis=1), 1.0, atol=1e-14)
    side = np.array([-1.0, 0.0, 2.0]) / np.sqrt(5.0)
    np.testing.assert_allclose(surface.smooth_normal([[1.0, 1.0]], 0.5)[0], side, atol=1e-14)  # no kink within 0.5 m
    np.testing.assert_allclose(surface.smooth_normal([[2.0, 1.0]], 0.5)[0], [0, 0, 1], atol=1e-14)
    np.testing.assert_allclose(surface.smooth_normal([[0.0, 3.0]], 0.5)[0], side, atol=1e-14)  # one-sided in a corner


def test_area_is_measured_along_the_slope(roof):
    assert TerrainSurface.of(*roof).area() == pytest.approx(4 * 3 * np.sqrt(5) / 2, rel=1e-14)  # round-off
    assert TerrainSurface.of([[0, 0], [3, 4]], [[0, 1]]).area() == pytest.approx(5.0, rel=1e-14)


def test_clipping_keeps_what_touches_the_box(roof):
    surface = TerrainSurface.of(*roof).clipped([0.5, 1.0, -9], [1.0, 2.0, 9])
    assert len(surface.facets) == 2
    assert surface.upper[0] == 2.0
    with pytest.raises(InputError, match="nothing of it"):
        surface.clipped([10, 0], [12, 5])


def test_recentring_moves_everything(roof):
    far = np.array([500_000.0, 5_200_000.0, 2000.0])
    surface = TerrainSurface.of(roof[0] + far, roof[1]).recentred(far)
    np.testing.assert_allclose(surface.height([[1.0, 1.5]]), 0.5, atol=1e-9)  # ulp of 5.2e6 m is 9e-10 m
    assert surface.lower.tolist() == [0.0, 0.0, 0.0]


def test_repeated_flipped_and_degenerate_facets_are_put_right(roof):
    vertices, triangles = roof
    soup = np.concatenate([vertices[triangles], vertices[triangles][:2, ::-1], vertices[[[0, 0, 1], [0, 2, 2]]]])
    surface = TerrainSurface.of(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
    assert (len(surface.vertices), len(surface.facets)) == (6, 4)
    assert (surface.facet_normals[:, 2] > 0).all()
    assert not surface.closed


def test_cliffs_and_overhangs_are_oriented_by_their_neighbours():
    line = np.array([[0, 2], [3, 2], [3, 0], [2, 0], [2, -1], [5, -1]], float)  # top, cliff, undercut, ground
    segments = np.array([[0, 1], [2, 1], [2, 3], [4, 3], [4, 5]])  # two of them the wrong way round
    surface = TerrainSurface.of(line, segments)
    np.testing.assert_allclose(surface.facet_normals, [[0, 1], [1, 0], [0, -1], [1, 0], [0, 1]], atol=1e-15)
    np.testing.assert_allclose(surface.height([[2.5], [3.5]]), [2.0, -1.0], atol=1e-15)  # the highest surface


@pytest.mark.parametrize(
    ("vertices", "facets"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int)),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]]),
    ],
)
def test_surfaces_without_area_are_refused(vertices, facets):
    with pytest.raises(InputError, match="terrain: "):
        TerrainSurface.of(vertices, facets)
