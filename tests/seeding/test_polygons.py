"""Polygons as people draw them: what is weighed is what is filled, and a repair is told."""

import json
import warnings

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding import seed_body
from snowmpm.seeding.polygons import Polygons
from snowmpm.terrain import load_terrain
from tests.support.tables import Table as Spec

BOW_TIE = [(0, 0), (6, 6), (6, 0), (0, 3)]
"""Lobes of 3 and 12 m2; by the shoelace formula 9 m2."""

STAR = [(5 + 5 * np.sin(4 * np.pi * k / 5), 5 + 5 * np.cos(4 * np.pi * k / 5)) for k in range(5)]
SQUARE = [(0, 0), (6, 0), (6, 6), (0, 6)]

FLAWED = {
    "bow-tie": (BOW_TIE, 15.0),
    "bow-tie closed": ([*BOW_TIE, BOW_TIE[0]], 15.0),
    "bow-tie turned round": (BOW_TIE[::-1], 15.0),
    "spike": ([(0, 0), (6, 0), (6, 6), (9, 6), (6, 6), (0, 6)], 36.0),
    "spike to the inside": ([(0, 0), (6, 0), (6, 3), (2, 3), (6, 3), (6, 6), (0, 6)], 36.0),
    "star": (STAR, 25.0 * 0.775676752166744),  # five triangles: the middle is gone round twice
    "touches itself": ([(0, 0), (2, 2), (4, 0), (4, 4), (2, 2), (0, 4)], 8.0),
    "same ring twice": ([*SQUARE, SQUARE[0], *SQUARE], 36.0),
}
SOUND = {
    "repeated corners": ([(0, 0), (0, 0), (6, 0), (6, 6), (6, 6), (6, 6), (0, 6), (0, 0)], 36.0),
    "clockwise": (SQUARE[::-1], 36.0),
    "corners in a line": ([(0, 0), (3, 0), (6, 0), (6, 6), (0, 6)], 36.0),
}


def flat():
    spec = Spec(kind="plane", point=(0.0, 0.0, 0.0), angle=0.0, azimuth=0.0)
    return load_terrain(spec, extent=([-5, -5], [40, 40]))


def plan_area(region, base_dir=".", dx=0.4):
    """Plan area [m2] by the volume of a layer 1 m thick on flat ground, and by the cells that hold a particle of it."""
    layer = Spec(kind="layer", bottom=0.0, top=1.0, region=region)
    seeds = seed_body(layer, flat(), dim=3, dx=dx, particles_per_cell=8, sampling="regular",
                      rng=np.random.default_rng(0), base_dir=base_dir)
    cells = np.unique(np.floor(seeds.positions[:, :2] / (0.5 * dx)), axis=0)
    return seeds.volumes.sum(), len(cells) * (0.5 * dx) ** 2


def write_geojson(path, geometries):
    features = [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in geometries]
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": None, "features": features}))
    return Spec(file=path.name)


def polygon(*rings):
    return {"type": "Polygon", "coordinates": [[list(map(float, c)) for c in (*r, r[0])] for r in rings]}


@pytest.mark.parametrize("name", FLAWED)
def test_mass_of_a_repaired_outline_is_area_times_thickness(name):
    points, area = FLAWED[name]
    with pytest.warns(UserWarning, match=r"region\.polygon: the polygon is repaired \(its outline crosses or touches"):
        weighed, filled = plan_area(Spec(polygon=points))
    assert weighed == pytest.approx(area, rel=1e-9)
    assert filled == pytest.approx(area, rel=0.06)  # squares of 0.2 m along 20 m of outline


@pytest.mark.parametrize("name", FLAWED)
@pytest.mark.parametrize("kind", ["polygon", "prism"])
def test_mass_of_a_repaired_shape(name, kind):
    points, area = FLAWED[name]
    spec = Spec(kind=kind, points=points, y=(1.0, 3.0))
    dim, width = (2, 1.0) if kind == "polygon" else (3, 2.0)
    with pytest.warns(UserWarning, match=r"shape\.points: the polygon is repaired"):
        seeds = seed_body(spec, None, dim=dim, dx=0.5, particles_per_cell=2**dim, sampling="regular",
                          rng=np.random.default_rng(0))
    assert seeds.volumes.sum() == pytest.approx(area * width, rel=1e-9)
    assert seeds.volumes.mean() == pytest.approx(0.25**dim, rel=0.1)  # as dense as anywhere: what is filled is weighed


def test_the_warning_says_what_is_left():
    with pytest.warns(UserWarning) as told:
        Polygons.of([[BOW_TIE]], "region.polygon")
    assert str(told[0].message) == ("region.polygon: the polygon is repaired (its outline crosses or touches itself"
                                    " near (2, 2)): 15 m2 in 2 parts")


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_outline_is_taken_as_it_is(name):
    points, area = SOUND[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        weighed, filled = plan_area(Spec(polygon=points))
    assert weighed == pytest.approx(area, rel=1e-9) and filled == pytest.approx(area, rel=0.05)


@pytest.mark.parametrize("points", [
    [(0, 0), (1, 1), (2, 2)], [(0, 0), (1, 0)], [(1, 1)] * 5,
    [(0, 0), (1, 0), (0, 0), (1, 0)], [(0, 0), (1e-9, 0), (1e6, 1e6), (1e-9, 1e-9)]])
@pytest.mark.filterwarnings("ignore")
def test_no_area_is_refused(points):
    with pytest.raises(InputError, match="no area"):
        Polygons.of([[points]], "region.polygon")


def test_corners_too_near_each_other_for_the_library_are_refused():
    corners = [[2.0, 2.0000000002328306], [2.0, 8.0], [1.6561861379855516e-76, 2.0763366e-317],
               [2.076309e-317, 2.076309e-317], [2.0722615e-317, 2.0722615e-317]]  # from a shapefile with changed bytes
    with pytest.raises(InputError, match="region: no area can be made of the polygon's corners"):
        Polygons.of([[corners]], "region")


@pytest.mark.parametrize("corner", [(np.nan, 0), (0, np.inf), (1e300, 0), ("a", 0), (1,), None, ((1, 2), 3)])
def test_a_corner_that_is_no_point_is_refused(corner):
    with pytest.raises(InputError, match="a list of points"):
        Polygons.of([[[(0, 0), (1, 0), corner, (0, 1)]]], "region.polygon")


def square(x, y, side):
    return [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]


GEOMETRIES = {
    "hole": ([polygon(square(0, 0, 8), square(2, 2, 3))], 64 - 9),
    "hole that runs the same way": ([polygon(square(0, 0, 8), square(2, 2, 3)[::-1])], 64 - 9),
    "holes that overlap": ([polygon(square(0, 0, 8), square(2, 2, 3), square(4, 2, 3))], 64 - 15),
    "hole across the outline": ([polygon(square(0, 0, 8), square(6, 2, 4))], 64 - 8),
    "parts": ([{"type": "MultiPolygon", "coordinates": [polygon(square(0, 0, 4))["coordinates"],
                                                        polygon(square(10, 0, 4))["coordinates"]]}], 32),
    "parts that overlap": ([{"type": "MultiPolygon", "coordinates": [polygon(square(0, 0, 4))["coordinates"],
                                                                     polygon(square(2, 0, 4))["coordinates"]]}], 24),
    "features that overlap": ([polygon(square(0, 0, 4)), polygon(square(2, 0, 4))], 24),
    "three features that overlap": ([polygon(square(x, 0, 4)) for x in (0, 1, 2)], 24),
    "a feature inside another": ([polygon(square(0, 0, 8)), polygon(square(2, 2, 3))], 64),
    "a feature around another": ([polygon(square(2, 2, 3)), polygon(square(0, 0, 8))], 64),
    "the same feature twice": ([polygon(square(0, 0, 4)), polygon(square(0, 0, 4))], 16),
    "features with a common side": ([polygon(square(0, 0, 4)), polygon(square(4, 0, 4))], 32),
    "bow-tie over a square": ([polygon(BOW_TIE), polygon(square(0, 0, 6))], 36),
    "collection": ([{"type": "GeometryCollection", "geometries": [
        polygon(square(0, 0, 4)), {"type": "Point", "coordinates": [1, 2]}, polygon(square(10, 0, 4))]}], 32),
}
SILENT = {"hole", "hole that runs the same way", "parts", "features with a common side", "holes that overlap"}


@pytest.mark.parametrize("name", GEOMETRIES)
def test_mass_of_geojson(name, tmp_path):
    geometries, area = GEOMETRIES[name]
    region = write_geojson(tmp_path / "release.geojson", geometries)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        weighed, filled = plan_area(region, tmp_path)
    assert weighed == pytest.approx(area, rel=1e-9) and filled == pytest.approx(area, rel=0.06)
    said = " ".join(str(one.message) for one in told)
    assert any(word in said for word in ("repaired", "overlap", "left out")) == (name not in SILENT), said


@pytest.mark.parametrize(("rings", "area"), [
    ([square(0, 0, 8)[::-1], square(2, 2, 3)], 55),  # as the format wants it: outlines clockwise, holes not
    ([square(0, 0, 8), square(2, 2, 3)], 55),  # outline the wrong way round
    ([square(2, 2, 3), square(0, 0, 8)], 55),  # the hole first
    ([square(0, 0, 8)[::-1], square(1, 1, 6), square(3, 3, 2)[::-1]], 64 - 36 + 4),  # an island in a lake
    ([square(0, 0, 4)[::-1], square(10, 0, 4)[::-1]], 32),
    ([square(0, 0, 4)[::-1], square(2, 0, 4)[::-1]], 24),  # parts that overlap
    ([BOW_TIE], 15)])
def test_mass_of_a_shapefile(rings, area, tmp_path):
    shapefile = pytest.importorskip("shapefile")
    with shapefile.Writer(str(tmp_path / "release.shp")) as target:
        target.field("Name", "C", 10)
        target.poly([[list(map(float, c)) for c in (*ring, ring[0])] for ring in rings])
        target.record("a")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        weighed, filled = plan_area(Spec(file="release.shp"), tmp_path)
    assert weighed == pytest.approx(area, rel=1e-9) and filled == pytest.approx(area, rel=0.06)


@pytest.mark.parametrize("text", [
    '{"type": "Polygon", "coordinates": [[[NaN, 0], [1, 0], [1, 1]]]}', '{"type": "Polygon", "coordinates": [[]]}',
    '{"type": "Polygon", "coordinates": []}', '{"type": "Polygon", "coordinates": [[[1e999, 0], [1, 0], [1, 1]]]}',
    '{"type": "Polygon", "coordinates": [["a", "b"]]}', '{"type": "Polygon", "coordinates": 5}',
    '{"type": "FeatureCollection", "features": {}}',
    '{"type": "Polygon", "crs": 5, "coordinates": [[[0,0],[1,0],[1,1]]]}',
    '{"type": "GeometryCollection", "geometries": ' + "[" * 100_000 + "]" * 100_000 + "}", "[" * 100_000, "",
    '{"type": "Polygon", "coordinates": [[[' + "9" * 5000 + ", 0], [1, 0], [1, 1]]]}"])
@pytest.mark.filterwarnings("ignore")
def test_hostile_geojson_is_refused(text, tmp_path):
    (tmp_path / "release.geojson").write_text(text)
    with pytest.raises(InputError, match=r"release\.geojson|no area|list of points"):
        plan_area(Spec(file="release.geojson"), tmp_path)
