"""Signed distance and normal against closed forms and against trimesh (validation case M23)."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from snowmpm.terrain import DistanceField, TerrainSurface


def grid_mesh(height, n=12, size=6.0):
    """Vertices and triangles of z = height(x, y) on an n x n grid of cells over [0, size] squared."""
    s = np.linspace(0.0, size, n + 1)
    xx, yy = np.meshgrid(s, s, indexing="ij")
    number = np.arange(xx.size).reshape(xx.shape)
    a, b, c, d = (v.ravel() for v in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.column_stack([xx.ravel(), yy.ravel(), height(xx, yy).ravel()]), triangles


def hilly(x, y):
    return np.sin(1.3 * x) + 0.7 * np.cos(1.7 * y + 0.4 * x) - 0.5 * x


@pytest.fixture(scope="module")
def rng():
    return np.random.default_rng(7)


@pytest.fixture(scope="module")
def hills():
    return grid_mesh(hilly)


@pytest.mark.parametrize("seed", range(5))
def test_rotated_plane_is_exact(seed):
    rng = np.random.default_rng(seed)
    turn = Rotation.from_euler("zyx", [rng.uniform(0, 360), *rng.uniform(-60, 60, 2)], degrees=True)
    flat, triangles = grid_mesh(lambda x, y: 0.0 * x)
    shift = np.array([247_000.0, 350_000.0, 1500.0])  # map coordinates
    field = DistanceField(TerrainSurface.of(turn.apply(flat) + shift, triangles), reach=2.0)
    inner = np.column_stack([rng.uniform(2.0, 4.0, (500, 2)), np.zeros(500)])
    h = rng.uniform(-0.5, 0.5, 500)  # feet and heads stay over the plane: 2 m inside its rim
    normal = turn.apply([0.0, 0.0, 1.0])
    d, n = field.query(turn.apply(inner) + shift + h[:, None] * normal)
    assert np.abs(d - h).max() < 1e-6 * 6.0 * 1e-3  # M23 allows 1e-6 L; map coordinates carry 6e-11 m
    assert np.linalg.norm(n - normal, axis=1).max() < 1e-6  # M23


@pytest.mark.parametrize("reach", [0.3, 5.0])
def test_hills_agree_with_trimesh(hills, rng, reach):
    vertices, triangles = hills
    field = DistanceField(TerrainSurface.of(vertices, triangles), reach=reach)
    plan = rng.uniform(0.0, 6.0, (2000, 2))
    surface = TerrainSurface.of(vertices, triangles)
    ground = surface.height(plan)
    points = np.column_stack([plan, ground + rng.uniform(-1.5, 1.5, 2000)])
    d, n = field.query(points)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    foot, distance, _ = trimesh.proximity.closest_point(mesh, points)
    excess = np.abs(d) - np.minimum(distance, reach)
    assert excess.max() < 1e-12  # float64 round-off
    assert excess.min() > -1e-6  # trimesh takes any of several points that are about as near
    assert np.median(np.abs(excess)) < 1e-15  # ... seldom
    assert (np.sign(d) == np.sign(points[:, 2] - ground)).all()
    # The gradient: wherever the nearest point is unique the normal is the direction away from it.
    near = (distance < reach) & (distance > 1e-6) & (np.abs(excess) < 1e-12)
    away = (points - foot)[near] / d[near, None]
    assert np.linalg.norm(n[near] - away, axis=1).max() < 1e-8  # 1e-14 / 1e-6: direction from rounded coordinates


def test_out_of_reach_is_clamped_with_the_right_sign(hills):
    field = DistanceField(TerrainSurface.of(*hills), reach=0.4)
    plan = np.random.default_rng(1).uniform(0.1, 5.9, (300, 2))
    for height, sign in ((30.0, 1.0), (-30.0, -1.0)):
        d, n = field.query(np.column_stack([plan, np.full(300, height)]))
        assert (d == sign * 0.4).all()
        assert (n[:, 2] > 0).all()


def test_bowl_of_an_icosphere_within_its_sagitta():
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=2.0)
    facets = sphere.faces[(sphere.triangles[:, :, 2] <= 1e-9).all(axis=1)]  # lower half: open, seen from above
    surface = TerrainSurface.of(sphere.vertices, facets)
    assert not surface.closed
    corner = surface.vertices[surface.facets]
    sagitta = 2.0 - np.abs((corner[:, 0] * surface.facet_normals).sum(axis=1)).min()
    rng = np.random.default_rng(3)
    direction = rng.normal(size=(3000, 3))
    direction[:, 2] = -np.abs(direction[:, 2]) - 0.3 * np.linalg.norm(direction, axis=1)  # away from the rim
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    r = rng.uniform(1.2, 2.6, 3000)
    plan_r = np.linalg.norm(direction[:, :2] * r[:, None], axis=1)
    keep = plan_r < 1.9
    d, n = DistanceField(surface, reach=3.0).query((direction * r[:, None])[keep])
    exact = (2.0 - r)[keep]  # positive inside the bowl: that is above the ground
    assert np.abs(d - exact).max() <= sagitta  # M23
    inside = exact > 0.05  # below a hollow the gradient jumps between facets; above it follows the sphere
    tilt = np.arccos(np.clip(-(n * direction[keep]).sum(axis=1), -1, 1))[inside]
    assert tilt.max() < 0.1  # rad: half the angle between two facets (0.12) and the edge between them


@pytest.mark.parametrize("damage", ["flipped", "all flipped", "duplicated", "duplicated and flipped", "soup"])
def test_damaged_meshes_give_the_same_distance(hills, damage):
    vertices, triangles = hills
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(0, 6, (1500, 2)), rng.uniform(-5, 3, 1500)])
    expected = DistanceField(TerrainSurface.of(vertices, triangles), reach=1.5).query(points)
    some = rng.random(len(triangles)) < 0.4
    broken = triangles.copy()
    if "flipped" in damage:
        broken[some | (damage == "all flipped")] = broken[some | (damage == "all flipped")][:, ::-1]
    if "duplicated" in damage:
        broken = np.concatenate([triangles, broken[some], triangles[some][:, ::-1]])
    if damage == "soup":
        vertices, broken = vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
    got = DistanceField(TerrainSurface.of(vertices, broken), reach=1.5).query(points)
    assert np.abs(got[0] - expected[0]).max() < 1e-12  # the same facets in another order
    assert np.abs(got[1] - expected[1]).max() < 1e-9


def test_overhang_is_told_from_the_ground_below():
    """A wave that breaks: ground, a face leaning over it, and a lip; oriented by its neighbours, not by n_z alone."""
    line = np.array([[0, 0], [4, 0], [5, 1], [4, 2], [3, 2.5], [5, 4], [8, 4]], float)
    surface = TerrainSurface.of(line, np.column_stack([np.arange(6), np.arange(1, 7)]))
    points = np.array([[2.0, 0.5], [4.2, 1.0], [4.8, 1.5], [3.6, 2.6], [6.0, 3.0], [6.0, 4.5], [4.5, 0.2]])
    d, _ = DistanceField(surface, reach=10.0).query(points)
    assert (np.sign(d) == [1, 1, -1, -1, -1, 1, -1]).all()


def test_closed_solid_agrees_with_trimesh(rng):
    solid = trimesh.util.concatenate(
        [trimesh.creation.icosphere(subdivisions=2), trimesh.creation.box(bounds=[[2.0, -0.5, -1.0], [3.0, 0.8, 0.4]])]
    )
    flipped = solid.faces.copy()
    flipped[::3] = flipped[::3, ::-1]
    surface = TerrainSurface.of(solid.vertices, flipped)
    assert surface.closed
    assert surface.volume() == pytest.approx(solid.volume, rel=1e-12)  # round-off
    points = rng.uniform([-2, -2, -2], [4, 2, 2], (1500, 3))
    d, _ = DistanceField(surface, reach=5.0).query(points)
    assert np.abs(d + trimesh.proximity.signed_distance(solid, points)).max() < 1e-9  # trimesh is positive inside
    short, _ = DistanceField(surface, reach=0.2).query(points)
    assert np.abs(short - np.clip(d, -0.2, 0.2)).max() < 1e-12  # clamping keeps the sign


def test_profile_with_kinks_against_closed_form():
    line = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 2.0], [6.0, 0.0]])
    field = DistanceField(TerrainSurface.of(line, [[0, 1], [1, 2], [2, 3]]), reach=3.0)
    diagonal = np.sqrt(0.5)
    cases = [
        ([1.0, 0.5], 0.5, [0, 1]),  # over a side
        ([4.0, 3.0], 1.0, [0, 1]),  # over the ridge: nearest to the corner
        ([4.3, 2.8], np.hypot(0.3, 0.8), np.array([0.3, 0.8]) / np.hypot(0.3, 0.8)),
        ([4.0, 1.0], -diagonal, None),  # below the ridge: two nearest points
        ([2.0, 0.0], 0.0, [-np.sin(np.pi / 8), np.cos(np.pi / 8)]),  # in the hollow itself: mean normal
        ([3.0, 1.0], 0.0, [-diagonal, diagonal]),  # on a side
        ([2.0, -1.0], -1.0, [0, 1]),  # below the hollow: nearest to its corner or the flat side
    ]
    d, n = field.query([point for point, _, _ in cases])
    assert np.abs(d - [distance for _, distance, _ in cases]).max() < 1e-14  # round-off
    for got, (_, _, normal) in zip(n, cases, strict=True):
        assert normal is None or np.abs(got - normal).max() < 1e-12  # round-off


def test_sharp_edge_and_tip():
    """On a roof of 30 degrees and on a spire one face alone would give the wrong sign off the edge and off the tip."""
    h = 1.0 / np.tan(np.radians(15.0))
    roof = [[-1, -9, -h], [0, -9, 0], [1, -9, -h], [-1, 9, -h], [0, 9, 0], [1, 9, -h]]
    field = DistanceField(TerrainSurface.of(roof, [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]), reach=3.0)
    rng = np.random.default_rng(2)
    phi = rng.uniform(-np.radians(74), np.radians(74), 200)  # within 75 degrees of upright the edge is nearest
    r = rng.uniform(0.1, 0.9, 200)
    away = np.column_stack([np.sin(phi), np.zeros(200), np.cos(phi)])
    d, n = field.query(r[:, None] * away + np.column_stack([np.zeros(200), rng.uniform(-5, 5, 200), np.zeros(200)]))
    assert np.abs(d - r).max() < 1e-12  # round-off
    assert np.abs(n - away).max() < 1e-12
    on_the_edge = field.query([[0.0, 1.0, 0.0]])
    np.testing.assert_allclose(on_the_edge[1], [[0, 0, 1]], atol=1e-12)
    assert on_the_edge[0][0] == 0.0

    spire = [[0, 0, 0], [1, 0, -h], [0, 1, -h], [-1, 0, -h], [0, -1, -h]]
    field = DistanceField(TerrainSurface.of(spire, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]), reach=3.0)
    points = rng.normal(size=(200, 3)) * [0.3, 0.3, 0.1] + [0, 0, 0.25]
    r = np.linalg.norm(points[:, :2], axis=1)
    points = points[(points[:, 2] > r * np.tan(np.radians(16))) & (r < 0.7)]  # nearest to the tip, over the spire
    d, n = field.query(points)
    assert len(points) > 50
    assert np.abs(d - np.linalg.norm(points, axis=1)).max() < 1e-12


def test_nothing_to_stand_on_beyond_the_border_and_over_holes(hills):
    vertices, triangles = hills
    centre = vertices[triangles].mean(axis=1)
    hole = (np.abs(centre[:, :2] - 3.0) < 1.0).all(axis=1)
    field = DistanceField(TerrainSurface.of(vertices, triangles[~hole]), reach=3.0)
    plan = np.array([[3.0, 3.0], [2.1, 3.0], [3.0, 3.9], [-0.1, 3.0], [6.1, 3.0], [3.0, -1e-6], [1e9, 0.0]])
    rim = [DistanceField(TerrainSurface.of(vertices, triangles), reach=3.0).query([[2.1, 3.0, hilly(2.1, 3.0)]])[0]]
    assert np.abs(rim) < 0.2  # there was ground where the hole is now
    for below in (-0.2, 0.2):
        d, n = field.query(np.column_stack([plan, hilly(*plan.clip(0, 6).T) + below]))
        assert (d == 3.0).all()
    assert (n == [0.0, 0.0, 1.0]).all()


def test_bins_do_not_change_the_answer(hills, rng):
    surface = TerrainSurface.of(*hills)
    points = np.column_stack([rng.uniform(-1, 7, (500, 2)), rng.uniform(-4, 3, 500)])
    expected = DistanceField(surface, reach=2.0).query(points)[0]
    for size in (0.05, 0.37, 100.0):
        assert (DistanceField(surface, reach=2.0, bin_size=size).query(points)[0] == expected).all()


def test_no_points():
    d, n = DistanceField(TerrainSurface.of([[0, 0], [1, 0]], [[0, 1]]), reach=1.0).query(np.empty((0, 2)))
    assert d.shape == (0,)
    assert n.shape == (0, 2)
