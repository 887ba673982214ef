"""Layers on a profile: volumes in closed form, even rows, borders shared by stacked layers."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding import seed_body
from snowmpm.seeding.profile_layer import OffsetLine
from snowmpm.terrain import DistanceField, TerrainSurface, load_terrain
from tests.support.tables import Table as Spec

DX = 0.1


def layer(surface, bottom, top, x=None, sampling="regular", dx=DX, ppc=4, seed=1):
    spec = Spec(kind="layer", bottom=bottom, top=top, region=None if x is None else Spec(x=x, y=None))
    rng = np.random.default_rng(seed)
    return seed_body(spec, surface, dim=2, dx=dx, particles_per_cell=ppc, sampling=sampling, rng=rng)


def polyline(*points):
    n = np.arange(len(points) - 1)
    return TerrainSurface.of(np.array(points, float), np.column_stack([n, n + 1]))


@pytest.fixture
def slope():
    """Steep slope, arc of 8 m radius, flat run-out."""
    return load_terrain(Spec(kind="profile", points=[[0, 30], [40, 5], [60, 5]], fillet=8.0))


@pytest.mark.parametrize("sampling", ["regular", "jittered", "poisson"])
def test_volume_on_a_straight_slope(sampling):
    surface = polyline([0, 20], [40, 0])
    seeds = layer(surface, 0.1, 0.6, [10.0, 30.0], sampling)
    assert seeds.volumes.sum() == pytest.approx(0.5 * np.hypot(20, 10), rel=1e-12)  # round-off
    normal = np.array([1.0, 2.0]) / np.sqrt(5.0)
    h = (seeds.positions - [0.0, 20.0]) @ normal
    assert h.min() > 0.1
    assert h.max() < 0.6
    along = (seeds.positions - [0.0, 20.0]) @ [2.0, -1.0] / np.sqrt(5.0)
    assert along.min() > np.hypot(10, 5)  # the ends are cut square to the slope, where x is 10 and 30 on the ground
    assert along.max() < np.hypot(30, 15)


def test_layer_on_an_arc_has_the_area_of_the_ring_sector(slope):
    """Inside an arc of radius R the layer is R - h wide: area = angle ((R - a)^2 - (R - b)^2) / 2."""
    angle = np.arctan2(25.0, 40.0)
    tangent = 8.0 * np.tan(angle / 2)
    start, end = 40.0 - (tangent + 1.0) * np.cos(angle), 40.0 + tangent + 1.0  # and 1 m straight on both sides
    seeds = layer(slope, 0.5, 1.5, [start, end])
    exact = 0.5 * angle * ((8.0 - 0.5) ** 2 - (8.0 - 1.5) ** 2) + 2.0 * 1.0
    assert seeds.volumes.sum() == pytest.approx(exact, rel=5e-5)  # chords of 1 degree: (1 degree)^2 / 12 = 2.5e-5


def test_ridge_and_hollow_in_closed_form():
    """At a ridge the offset line runs round the corner, in a hollow it is mitred: length changes by +-h times ..."""
    theta = np.arctan2(1.0, 2.0)
    for sign, change in ((1.0, 2 * theta), (-1.0, -2 * np.tan(theta))):
        ground = np.array([[0.0, 0.0], [4.0, 2.0 * sign], [8.0, 0.0]])
        for h in (0.3, 1.0):
            assert OffsetLine(ground, h).length == pytest.approx(2 * np.hypot(4, 2) + change * h, rel=1e-13)


def test_short_sides_vanish_in_a_hollow():
    """A ditch of radius 1 made of short sides, seen from 2 m above, is just the corner of its banks."""
    phi = np.linspace(-np.pi / 4, np.pi / 4, 31)
    arc = np.column_stack([np.sin(phi), -np.cos(phi)])
    ground = np.concatenate([[arc[0] + [-5, 5]], arc, [arc[-1] + [5, 5]]])
    line = OffsetLine(ground, 2.0)
    straight = np.hypot(5, 5)
    chord_radius = np.cos(np.pi / 120)  # the banks touch the circle's chords, a little inside it
    assert line.length == pytest.approx(2 * (straight - 1.0), abs=2 * (1 - chord_radius) + 2e-3)
    x = line.points(np.linspace(0.01, line.length - 0.01, 400), np.zeros(400))
    field = DistanceField(polyline(*ground), reach=5.0)
    assert field.query(x)[0].min() > 2.0 - 2e-3  # no point nearer to the ground than the line's distance; chords


@pytest.mark.parametrize("sampling", ["regular", "jittered", "poisson"])
def test_points_lie_between_the_two_distances(slope, sampling):
    seeds = layer(slope, 0.1, 0.6, [5.0, 55.0], sampling)
    d, _ = DistanceField(slope, reach=3.0).query(seeds.positions)
    assert d.min() > 0.1 - 1e-9  # round-off
    assert d.max() < 0.6 + 1e-9


def test_rows_are_even_through_the_arc(slope):
    seeds = layer(slope, 0.0, 0.1, [5.0, 55.0])
    rows = seeds.positions.reshape(2, -1, 2) if len(seeds.positions) % 2 == 0 else None
    rows = rows if rows is not None else [seeds.positions[: len(seeds.positions) // 2]]
    for row in rows:
        step = np.linalg.norm(np.diff(row, axis=0), axis=1)
        assert step.max() < 0.05 * 1.01  # spacing dx / 2; a per cent for rounding to a whole number of points
        assert step.min() > 0.05 * 0.98  # chords of the offset arc


def test_weak_layer_thinner_than_the_spacing_stays_closed(slope):
    seeds = layer(slope, 0.0, 0.03, [5.0, 55.0], dx=0.06, ppc=1)
    step = np.linalg.norm(np.diff(seeds.positions, axis=0), axis=1)
    assert step.max() < 0.0601  # one row, no more than a cell apart
    d, _ = DistanceField(slope, reach=1.0).query(seeds.positions)
    np.testing.assert_allclose(d, 0.015, atol=1e-9)


def test_stacked_layers_share_their_border(slope):
    """Thin layers stacked up hold as much as one thick layer, and their rows follow on at equal steps."""
    whole = layer(slope, 0.0, 0.6, [5.0, 55.0])
    parts = [layer(slope, a, b, [5.0, 55.0]) for a, b in ((0.0, 0.1), (0.1, 0.35), (0.35, 0.6))]
    assert sum(p.volumes.sum() for p in parts) == pytest.approx(whole.volumes.sum(), rel=1e-9)  # round-off
    d = np.concatenate([DistanceField(slope, reach=2.0).query(p.positions)[0] for p in parts])
    rows = np.unique(np.round(d, 6))
    np.testing.assert_allclose(np.diff(rows), 0.05, atol=1e-6)  # rounding above


def test_density_of_points_is_even_across_stacked_layers(slope):
    """Volume of points falling into cells well inside the body is the cell's own: no gap, no overlap."""
    parts = [layer(slope, a, b, [5.0, 55.0]) for a, b in ((0.0, 0.3), (0.3, 0.9))]
    x, v = (np.concatenate([getattr(p, name) for p in parts]) for name in ("positions", "volumes"))
    size = 0.3
    cell = np.floor(x / size).astype(int)
    keys, inverse = np.unique(cell, axis=0, return_inverse=True)
    filled = np.bincount(inverse.ravel(), weights=v)
    corners = (keys[:, None] + [[0, 0], [0, 1], [1, 0], [1, 1]]) * size
    d = DistanceField(slope, reach=3.0).query(corners.reshape(-1, 2))[0].reshape(-1, 4)
    inner = (d > 0).all(axis=1) & (d < 0.9).all(axis=1) & (keys[:, 0] > 20) & (keys[:, 0] < 180)
    assert inner.sum() > 100
    # 36 points a cell: those on its rim (24 half-spacings) count in or out as a whole.
    assert np.abs(filled[inner] / size**2 - 1).max() < 0.2
    assert filled[inner].mean() / size**2 == pytest.approx(1.0, rel=0.01)


def test_layer_too_thin_for_the_grid_says_how_fine_it_must_be(slope):
    with pytest.raises(InputError, match=r"shape.top = 0.04: .* solver.dx <= 0.08 m"):
        layer(slope, 0.0, 0.04, [5.0, 55.0])
    assert len(layer(slope, 0.0, 0.05, [5.0, 55.0]).volumes)  # exactly half a cell is allowed


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"bottom": 0.5, "top": 0.2}, "must be larger than bottom"),
        ({"bottom": -0.5, "top": 0.2}, "shape.bottom = -0.5"),
        ({"bottom": 0.0, "top": 0.5, "region": Spec(x=(50.0, 70.0))}, "off the terrain, which goes from 0 to 60"),
        ({"bottom": 0.0, "top": 0.5, "region": Spec(x=(20.0, 10.0))}, "from small to large"),
        ({"bottom": 0.0, "top": 0.5, "region": Spec(polygon=((0, 0), (1, 1), (0, 1)))}, "in 2-D only x"),
        ({"bottom": 0.0, "top": "file", "region": Spec(x=(5.0, 10.0))}, "no attribute 'thickness'"),
    ],
)
def test_bad_layers(slope, table, message):
    with pytest.raises(InputError, match=message) as caught:
        seed_body(Spec(kind="layer", **table), slope, dim=2, dx=DX, particles_per_cell=4, sampling="regular", rng=None)
    assert len(str(caught.value).splitlines()) == 1
