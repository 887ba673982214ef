"""Layers on a terrain in 3-D: volumes, spacing along the slope, no holes, regions and what is refused."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from snowmpm.errors import InputError
from snowmpm.seeding import seed_body
from snowmpm.terrain import DistanceField, TerrainSurface, load_terrain
from tests.support.made_path import THICKNESS, write_path
from tests.support.tables import Table as Spec

SLOPE = Path(__file__).parents[2] / "scenes" / "library" / "slope.stl"


def layer(surface, bottom, top, region=None, *, dx=0.5, ppc=8, sampling="regular", seed=1, base_dir="."):
    spec = Spec(kind="layer", bottom=bottom, top=top, region=region)
    rng = np.random.default_rng(seed)
    return seed_body(spec, surface, dim=3, dx=dx, particles_per_cell=ppc, sampling=sampling, rng=rng, base_dir=base_dir)


def plane(angle, azimuth):
    spec = Spec(kind="plane", point=(0.0, 0.0, 50.0), angle=angle, azimuth=azimuth)
    return load_terrain(spec, extent=([0, 0], [40, 40]))


@pytest.fixture(scope="module")
def slope():
    return load_terrain(Spec(kind="mesh", file=str(SLOPE)))


OCTAGON = Spec(polygon=[(20 + 8 * np.cos(a), 20 + 6 * np.sin(a)) for a in np.arange(8) * np.pi / 4])


@pytest.mark.parametrize("sampling", ["regular", "jittered", "poisson"])
@pytest.mark.parametrize("azimuth", [0.0, 30.0, 135.0])
@pytest.mark.parametrize("region", ["rectangle", "polygon"])
def test_volume_on_a_plane_is_area_times_thickness(azimuth, region, sampling):
    surface = plane(38.0, azimuth)
    where, area = (
        (Spec(x=(10.0, 25.0), y=(12.0, 20.0)), 120.0) if region == "rectangle" else (OCTAGON, 48 * 2 * np.sqrt(2))
    )
    seeds = layer(surface, 0.2, 1.2, where, sampling=sampling)
    along_the_slope = area / np.cos(np.radians(38.0))
    assert seeds.volumes.sum() == pytest.approx(along_the_slope * 1.0, rel=1e-9)  # normals by differences of heights
    d, _ = DistanceField(surface, reach=5.0).query(seeds.positions)
    assert d.min() > 0.2
    assert d.max() < 1.2
    if sampling == "regular":
        # On a lattice the polygon's rim adds or drops cells; the exact area is shared out, so the count is what varies.
        assert seeds.volumes.mean() == pytest.approx(0.5**3 / 8, rel=0.05)
        sheet = seeds.positions[np.abs(d - d.min()) < 1e-6]
        step = cKDTree(sheet).query(sheet, 2)[0][:, 1]
        assert step.min() > 0.2  # 0.25 m along the slope; axis-aligned lattices are skewed by at most 16 degrees here
        assert step.max() < 0.26


@pytest.mark.parametrize("seed", range(3))
def test_weak_layer_of_one_sheet_has_no_hole(slope, seed):
    """Every cell that the sheet's mid-surface passes through well inside the release area holds a particle."""
    dx = 0.3
    seeds = layer(
        slope, 0.0, 0.15, Spec(x=(2.0, 20.0), y=(3.0, 23.0)), dx=dx, sampling=["regular", "jittered", "poisson"][seed]
    )
    rng = np.random.default_rng(seed)
    plan = rng.uniform([3.0, 4.0], [19.0, 22.0], (4000, 2))
    middle = np.column_stack([plan, slope.height(plan)]) + 0.075 * slope.normal(plan)
    gap = cKDTree(seeds.positions).query(middle)[0]
    assert gap.max() < 0.75 * dx  # a quadratic B-spline reaches 1.5 dx: neighbours share at least one cell
    assert len(seeds.volumes) == pytest.approx(18 * 20 / np.cos(np.radians(39.5)) / (dx / 2) ** 2, rel=0.05)


def test_stacked_layers_share_their_border(slope):
    where = Spec(x=(2.0, 40.0), y=(3.0, 23.0))
    whole = layer(slope, 0.0, 1.0, where)
    parts = [layer(slope, 0.0, 0.25, where), layer(slope, 0.25, 1.0, where)]
    assert sum(p.volumes.sum() for p in parts) == pytest.approx(whole.volumes.sum(), rel=1e-9)  # same columns
    x, v = (np.concatenate([getattr(p, name) for p in parts]) for name in ("positions", "volumes"))
    # Every point well inside is surrounded by the volume that a ball holds: neither gap nor overlap at the border.
    d, _ = DistanceField(slope, reach=3.0).query(x)
    centre = np.flatnonzero((np.abs(d - 0.5) < 0.2) & (np.abs(x[:, 0] - 20) < 15) & (np.abs(x[:, 1] - 13) < 7))[::37]
    tree = cKDTree(x)
    radius = 0.3
    near = [v[i].sum() for i in tree.query_ball_point(x[centre], radius)]
    assert len(centre) > 50
    assert np.mean(near) / (4 / 3 * np.pi * radius**3) == pytest.approx(
        1.0, abs=0.12
    )  # about 8 points, centre included


def test_volume_on_the_library_slope_follows_the_ground(slope):
    seeds = layer(slope, 0.0, 0.6, Spec(x=(1.0, 59.0), y=(1.0, 25.0)))
    plan = np.random.default_rng(0).uniform([1, 1], [59, 25], (20000, 2))
    area = 58 * 24 * (1 / slope.facet_normals[slope.locate(plan)[0], 2]).mean()
    # Hollow ground narrows a layer: mean curvature of the bend and the gully, about 0.6 / 2 x 0.04; and the sample.
    assert seeds.volumes.sum() == pytest.approx(area * 0.6, rel=0.015)
    d, _ = DistanceField(slope, reach=2.0).query(seeds.positions)
    assert d.min() > 0.1
    assert d.max() < 0.5 + 1e-3
    shares = seeds.volumes / (0.5**3 / 8)
    assert shares.min() > 0.6
    assert shares.max() < 1.4


def test_volume_in_a_trough_in_closed_form():
    """In a trough of radius R a layer narrows upwards: angle ((R - a)^2 - (R - b)^2) / 2 a metre of length."""
    phi = np.radians(np.arange(-50.0, 50.5))
    ring = np.column_stack([20 * np.sin(phi), 0 * phi, -20 * np.cos(phi)])
    n, k = len(phi), np.arange(len(phi) - 1)
    triangles = np.concatenate([np.column_stack([k, k + 1, k + 1 + n]), np.column_stack([k, k + 1 + n, k + n])])
    surface = TerrainSurface.of(np.concatenate([ring, ring + np.array([0, 12, 0])]), triangles)
    x = 20 * np.sin(np.radians(30.0))
    for bottom, top in ((0.0, 0.7), (0.7, 3.0)):  # one sheet; five sheets
        seeds = layer(surface, bottom, top, Spec(x=(-x, x), y=(2.0, 10.0)), dx=1.0)
        exact = 8.0 * np.radians(60.0) * ((20 - bottom) ** 2 - (20 - top) ** 2) / 2
        assert seeds.volumes.sum() == pytest.approx(exact, rel=2e-3)  # slope by differences over 2 m: (2/20)^2 / 6


def test_a_sharp_kink_between_large_facets_is_followed():
    """Hockey stick of four triangles: normals turn near the kink only, and a thick layer does not fold."""
    vertices = [[0, 0, 20], [30, 0, 0], [60, 0, 0], [0, 10, 20], [30, 10, 0], [60, 10, 0]]
    surface = TerrainSurface.of(vertices, [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    for top in (0.5, 4.0):
        seeds = layer(surface, 0.0, top, Spec(x=(5.0, 50.0), y=(1.0, 9.0)))
        assert seeds.volumes.min() > 0
        far = np.abs(seeds.positions[:, 0] - 30.0) > 12.0
        d, _ = DistanceField(surface, reach=9.0).query(seeds.positions[far])
        rows = np.unique(np.round(d, 6))
        np.testing.assert_allclose(rows, (np.arange(4 * top) + 0.5) * 0.25, atol=1e-6)
        half = np.arctan2(2, 3) / 2
        strip = np.hypot(25, 25 * 2 / 3) + 20.0
        exact = 8.0 * (strip * top - np.tan(half) * top**2)
        assert seeds.volumes.sum() == pytest.approx(exact, rel=0.01 * max(top, 1.0))  # the mitre, rounded by smoothing


def write_geojson(path, polygons, thickness=None):
    properties = [{} if thickness is None else {"thickness": t} for t in (thickness or [None] * len(polygons))]
    features = [
        {"type": "Feature", "properties": p, "geometry": {"type": "Polygon", "coordinates": rings}}
        for p, rings in zip(properties, polygons, strict=True)
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return Spec(file=path.name)


SQUARE = [[5, 5], [15, 5], [15, 15], [5, 15], [5, 5]]
HOLE = [[8, 8], [12, 8], [12, 12], [8, 12], [8, 8]]
NEXT = [[12, 5], [22, 5], [22, 15], [12, 15], [12, 5]]


def test_geojson_with_a_hole_and_thickness_by_polygon(tmp_path):
    surface = plane(30.0, 0.0)
    region = write_geojson(tmp_path / "release.geojson", [[SQUARE, HOLE], [[[25, 25], [30, 25], [30, 30]]]], [1.0, 2.0])
    seeds = layer(surface, 0.0, "file", region, base_dir=tmp_path)
    plan = (100 - 16) * 1.0 + 12.5 * 2.0
    assert seeds.volumes.sum() == pytest.approx(plan / np.cos(np.pi / 6), rel=1e-9)
    d, _ = DistanceField(surface, reach=5.0).query(seeds.positions)
    foot = seeds.positions - d[:, None] * surface.facet_normals[0]
    in_hole = (np.abs(foot[:, :2] - 10.0) < 2.0 - 1e-9).all(axis=1)
    assert not in_hole.any()
    assert d[foot[:, 0] < 20].max() < 1.0 < d[foot[:, 0] > 20].max() < 2.0


def test_overlapping_polygons_are_filled_once(tmp_path):
    region = write_geojson(tmp_path / "release.geojson", [[SQUARE], [NEXT]])
    with pytest.warns(UserWarning, match="its polygons overlap: the 30 m2 that two of them share count once"):
        seeds = layer(plane(0.0, 0.0), 0.0, 1.0, region, base_dir=tmp_path)
    assert seeds.volumes.sum() == pytest.approx(100 + 70, rel=1e-9)


def test_shapefile_with_thickness(tmp_path):
    shapefile = pytest.importorskip("shapefile")
    with shapefile.Writer(str(tmp_path / "release.shp")) as target:
        target.field("Name", "C", 10)
        target.field("THICKNESS", "N", 11, 3)
        target.poly([SQUARE[::-1], HOLE])
        target.record("a", 1.5)
    seeds = layer(plane(20.0, 90.0), 0.0, "file", Spec(file="release.shp"), base_dir=tmp_path)
    assert seeds.volumes.sum() == pytest.approx(84 * 1.5 / np.cos(np.radians(20.0)), rel=1e-9)


def test_missing_gis_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "shapefile", None)
    (tmp_path / "release.shp").write_bytes(b"")
    with pytest.raises(InputError, match=r"pip install 'snowmpm\[gis\]'"):
        layer(plane(0.0, 0.0), 0.0, 1.0, Spec(file="release.shp"), base_dir=tmp_path)
    overlap = write_geojson(tmp_path / "release.geojson", [[SQUARE, HOLE], [NEXT]])
    assert len(layer(plane(0.0, 0.0), 0.0, 1.0, overlap, base_dir=tmp_path).volumes)  # needs no extra


def test_without_region_the_layer_ends_where_the_terrain_does():
    vertices = [[0, 0, 5], [20, 0, 0], [0, 20, 5]]
    seeds = layer(TerrainSurface.of(vertices, [[0, 1, 2]]), 0.0, 0.5)
    assert seeds.volumes.sum() == pytest.approx(200 * np.sqrt(1 + 1 / 16) * 0.5, rel=0.01)  # rim cells in or out


def test_bad_regions_are_named(tmp_path):
    surface = plane(30.0, 0.0)
    (tmp_path / "junk.geojson").write_text("{")
    (tmp_path / "points.geojson").write_text('{"type": "Point", "coordinates": [1, 2]}')
    (tmp_path / "list.geojson").write_text("[1, 2]")
    (tmp_path / "junk.shp").write_text("junk")
    (tmp_path / "release.kml").write_text("<kml/>")
    off = [[[100, 5], [115, 5], [115, 15]]]
    plain = write_geojson(tmp_path / "plain.geojson", [[SQUARE]])
    cases = [
        (Spec(file="none.shp"), 1.0, r"shape.region.file = 'none.shp': no such file"),
        (Spec(file="junk.geojson"), 1.0, "not a readable GeoJSON"),
        (Spec(file="list.geojson"), 1.0, "not a readable GeoJSON"),
        (Spec(file="points.geojson"), 1.0, "holds no polygon"),
        (Spec(file="junk.shp"), 1.0, "not a readable shapefile|gis extra"),
        (Spec(file="release.kml"), 1.0, "must be a .shp, .geojson or .gpkg file"),
        (Spec(polygon=[[0, 0], [1, 1], [2, 2]]), 1.0, "no area"),
        (Spec(polygon=[[0, 0], [1, 1]]), 1.0, "no area"),
        (Spec(x=(5.0, 6.0), polygon=SQUARE), 1.0, "give one of"),
        (Spec(x=(30.0, 50.0), y=(1.0, 2.0)), 1.0, r"lies off the terrain .*the terrain from \(0, 0\) to \(40, 40\)"),
        (write_geojson(tmp_path / "off.geojson", [off]), 1.0, "100 % of it lies off the terrain"),
        (plain, "file", "no attribute 'thickness'"),
        (Spec(polygon=[[1, 1], [1.1, 1], [1.1, 1.1], [1.099, 1.001]]), 1.0, "too small for a particle"),
    ]
    for region, top, message in cases:
        with pytest.raises(InputError, match=message) as caught:
            layer(surface, 0.0, top, region, base_dir=tmp_path)
        assert len(str(caught.value).splitlines()) == 1


def test_polygon_on_no_data_is_refused(tmp_path):
    rows = np.full((12, 12), 100.0)
    rows[4:6, 4:6] = -9999
    text = "ncols 12\nnrows 12\nxllcenter 0\nyllcenter 0\ncellsize 5\nNODATA_value -9999\n"
    (tmp_path / "dem.asc").write_text(text + "\n".join(" ".join(map(str, row)) for row in rows))
    surface = load_terrain(Spec(kind="dem", file="dem.asc"), tmp_path)
    with pytest.raises(InputError, match=r"% of it lies off the terrain \(outside, or where there is no data\)"):
        layer(surface, 0.0, 1.0, Spec(polygon=[[10, 10], [50, 10], [50, 50], [10, 50]]), dx=2.0)


def test_layer_too_thin_says_how_fine_dx_must_be(slope):
    with pytest.raises(InputError, match=r"less than half a cell of dx = 0.5 m: it needs solver.dx <= 0.4 m"):
        layer(slope, 0.0, 0.2, Spec(x=(2.0, 20.0), y=(3.0, 23.0)))


def test_terrain_and_release_polygon_from_files(tmp_path):
    """Raster in map coordinates, 41 % of it without data, and a shapefile that tells the thickness."""
    pytest.importorskip("shapefile")
    path = write_path(tmp_path)
    assert (np.loadtxt(path.dem, skiprows=6) == -9999.0).mean() == pytest.approx(0.41, abs=0.02)
    surface = load_terrain(Spec(kind="dem", file=path.dem.name), tmp_path)
    seeds = layer(surface, 0.0, "file", Spec(file=path.release.name), dx=2.0, base_dir=tmp_path)
    assert seeds.volumes.sum() == pytest.approx(THICKNESS * path.release_area(), rel=2e-3)
    d, _ = DistanceField(surface, reach=4.0).query(seeds.positions)
    assert np.quantile(np.abs(d - 0.5 * THICKNESS), 0.99) < 0.05  # one sheet


def test_real_terrain_with_its_release_polygon():
    """Elevation model and release polygon of an Alpine avalanche path (5 m cells, map coordinates, 41 % no data)."""
    pytest.importorskip("shapefile")
    folder = Path(__file__).parents[3] / "shared" / "data" / "terrain"
    if not folder.is_dir():
        pytest.skip("the elevation model is not part of the project")
    box = (np.array([247_600.0, 351_850.0]), np.array([248_100.0, 352_300.0]))
    surface = load_terrain(Spec(kind="dem", file="avaGar.asc"), folder, extent=box)
    seeds = layer(surface, 0.0, "file", Spec(file="relGar.shp"), dx=2.0, base_dir=folder)
    # 40 678 m2 in plan; 51 400 m2 along the ground, on which 1.2 m are laid.
    assert seeds.volumes.sum() == pytest.approx(51_400 * 1.2, rel=0.01)
    d, _ = DistanceField(surface, reach=4.0).query(seeds.positions)
    assert np.quantile(np.abs(d - 0.6), 0.99) < 0.05  # one sheet; normals are smoothed over two cells
