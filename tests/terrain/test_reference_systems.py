"""Units and projections of rasters and release polygons: converted, carried over or refused, never taken as metres."""

import json
import re
import subprocess
import sys
import warnings

import numpy as np
import pyproj
import pytest
from pydantic import TypeAdapter

from snowmpm.components.forcing_and_damping.fields import Acceleration
from snowmpm.errors import InputError
from snowmpm.scenes.forces import AnyForce
from snowmpm.scenes.formula import compiled
from snowmpm.seeding.regions import read_regions
from snowmpm.terrain import load_terrain
from snowmpm.terrain.raster import read_raster
from snowmpm.terrain.reference_system import ReferenceSystem
from tests.support.tables import Table as Spec

rasterio = pytest.importorskip("rasterio")

SURVEY_FOOT = 1200.0 / 3937.0
UTM = "EPSG:32632"
WEST, SOUTH, CELL = 660_000.0, 5_217_000.0, 5.0
PLANE = (0.3, -0.2)  # slope along x and y


def heights(x, y):
    return 2000.0 + PLANE[0] * (x - WEST) + PLANE[1] * (y - SOUTH)


def write_tif(path, z, transform, crs=UTM, units=None, scale=1.0, offset=0.0, **profile):
    """Rows of z as they lie in the file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rasterio, of a raster without a place
        profile = {"nodata": -9999.0, "dtype": "float64", "crs": crs, "transform": transform, **profile}
        size = {"width": z.shape[1], "height": z.shape[0], "count": 1}
        with rasterio.open(path, "w", driver="GTiff", **size, **profile) as target:
            target.write(z, 1)
            target.units, target.scales, target.offsets = (units,), (scale,), (offset,)
    return path


def plane_tif(path, transform, shape=(40, 50), metre=1.0, height_unit=1.0, **options):
    """The plane PLANE on a raster of any affine `transform`; metre, height_unit: metres in its units."""
    j, i = np.meshgrid(np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5)
    x, y = (a * j + b * i + c for a, b, c in (transform[:3], transform[3:6]))
    return write_tif(path, heights(x * metre, y * metre) / height_unit, transform, **options)


def turned(angle, cell=CELL, shear=0.0):
    return (rasterio.Affine.translation(WEST + 100.0, SOUTH + 200.0) @ rasterio.Affine.rotation(angle)
            @ rasterio.Affine.shear(shear) @ rasterio.Affine.scale(cell, -cell))


def of_metres(metre, west=WEST, south=SOUTH):
    return rasterio.Affine(CELL / metre, 0.0, west / metre, 0.0, -CELL / metre, (south + 200.0) / metre)


IN_FEET = of_metres(SURVEY_FOOT, 400_000.0, 250_000.0)
"""A place in Washington South, US survey feet."""


def quiet(call, *args, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return call(*args, **options)


def assert_on_plane(raster, rtol=1e-9):
    known = np.isfinite(raster.z)
    xx, yy = np.meshgrid(raster.x, raster.y)
    assert known.sum() > 0.2 * known.size
    np.testing.assert_allclose(raster.z[known], heights(xx, yy)[known], rtol=rtol)
    assert (np.diff(raster.x) > 0).all() and (np.diff(raster.y) > 0).all()


@pytest.mark.parametrize("epsg", [2927, 6597])  # Washington South: US survey feet, NAD83(HARN) and (2011)
@pytest.mark.parametrize("box", [False, True])
def test_survey_feet_are_converted(tmp_path, epsg, box):
    metre = ReferenceSystem.named(f"EPSG:{epsg}", "").metre
    assert metre == pytest.approx(SURVEY_FOOT, rel=1e-9)
    west, south = 400_000.0, 250_000.0
    transform = rasterio.Affine(10.0, 0.0, west / metre, 0.0, -10.0, (south + 100.0) / metre)
    z = np.linspace(6000.0, 7000.0, 50)[None, :] + np.zeros((40, 1))
    path = write_tif(tmp_path / "dem.tif", z, transform, crs=f"EPSG:{epsg}", units="US survey foot")
    cut = (np.array([west + 30.0, south + 20.0]), np.array([west + 60.0, south + 50.0])) if box else None
    with pytest.warns(UserWarning, match=r"x and y are converted to metres.*elevations are converted to metres"):
        raster = read_raster(path, cut)
    assert np.diff(raster.x) == pytest.approx(10.0 * metre, rel=1e-9)
    if box:
        assert raster.x[0] <= west + 30.0 < raster.x[1] and raster.x[-2] < west + 60.0 <= raster.x[-1]
    else:
        assert raster.x[0] == pytest.approx(west + 5.0 * metre, abs=1e-6)
        assert raster.z[0, 0] == pytest.approx(6000.0 * metre, rel=1e-12)
    # The system that maps are written in: the same place on the Earth
    feet, metres = pyproj.CRS(epsg), pyproj.CRS.from_wkt(raster.system.wkt)
    assert metres.axis_info[0].unit_name == "metre"
    places = [pyproj.Transformer.from_crs(crs, feet.geodetic_crs, always_xy=True).transform(*at) for crs, at in
              ((feet, (west / metre, south / metre)), (metres, (west, south)))]
    np.testing.assert_allclose(*places, rtol=0.0, atol=1e-11)
    rasterio.crs.CRS.from_wkt(raster.system.wkt)


@pytest.mark.parametrize(("units", "crs", "key", "expected"), [
    ("ft", UTM, None, 0.3048), ("US survey foot", UTM, None, SURVEY_FOOT), ("us-ft", UTM, None, SURVEY_FOOT),
    ("metre", UTM, None, 1.0), ("cm", UTM, None, 0.01), (None, UTM, None, 1.0),
    (None, "EPSG:32632+6360", None, SURVEY_FOOT),  # NAVD88 height (ftUS)
    (None, "EPSG:32632+5773", None, 1.0), (None, UTM, "ft", 0.3048), ("ft", UTM, "m", 1.0),
    (None, "EPSG:2927", "us-ft", SURVEY_FOOT)])
def test_unit_of_elevations(tmp_path, units, crs, key, expected):
    transform = IN_FEET if crs == "EPSG:2927" else of_metres(1.0)
    path = write_tif(tmp_path / "dem.tif", np.full((4, 4), 1000.0), transform, crs=crs, units=units)
    raster = quiet(read_raster, path, elevation_unit=key)
    assert raster.z[0, 0] == pytest.approx(1000.0 * expected, rel=1e-12)
    assert raster.system.height_metre is None or raster.system.metre == 1.0


def test_feet_without_a_word_about_heights_are_refused_until_the_scene_says(tmp_path):
    write_tif(tmp_path / "dem.tif", np.full((4, 4), 1000.0), IN_FEET, crs="EPSG:2927")
    spec = Spec(kind="dem", file="dem.tif")
    with pytest.raises(InputError, match=r"give terrain\.elevation_unit, one of m, ft, us-ft"):
        load_terrain(spec, tmp_path)
    spec.elevation_unit = "ft"
    assert quiet(load_terrain, spec, tmp_path).upper[2] == pytest.approx(304.8)


def test_values_that_are_no_elevations_are_refused(tmp_path):
    path = write_tif(tmp_path / "pressure.tif", np.ones((4, 4)), of_metres(1.0), units="kPa")
    with pytest.raises(InputError, match="'kPa': must be elevations"):
        read_raster(path)
    path = write_tif(tmp_path / "complex.tif", np.ones((4, 4), complex), of_metres(1.0), dtype="complex64", nodata=None)
    with pytest.raises(InputError, match="must be real numbers"):
        read_raster(path)


def test_scale_and_offset_of_the_band(tmp_path):
    path = write_tif(tmp_path / "dem.tif", np.full((4, 4), 123, np.int16), of_metres(1.0), scale=0.1, offset=1000.0,
                     dtype="int16")
    assert read_raster(path).z[0, 0] == pytest.approx(1012.3)


@pytest.mark.parametrize(("name", "transform"), [
    ("south up", rasterio.Affine(CELL, 0.0, WEST, 0.0, CELL, SOUTH)),
    ("mirrored", rasterio.Affine(-CELL, 0.0, WEST + 250.0, 0.0, -CELL, SOUTH + 200.0)),
    ("oblong", rasterio.Affine(CELL, 0.0, WEST, 0.0, -2.0, SOUTH + 80.0)),
    *((f"turned by {angle}", turned(angle)) for angle in (1.0, 30.0, 45.0, 90.0, 180.0, 233.0)),
    ("sheared", turned(0.0, shear=20.0)), ("turned and sheared", turned(30.0, shear=-15.0))])
@pytest.mark.parametrize("box", [False, True])
def test_any_way_round(tmp_path, name, transform, box):
    path = plane_tif(tmp_path / "dem.tif", transform)
    whole = quiet(read_raster, path)
    assert_on_plane(whole)
    middle = np.array([0.5 * (whole.x[0] + whole.x[-1]), 0.5 * (whole.y[0] + whole.y[-1])])
    if box:
        part = quiet(read_raster, path, (middle - 22.0, middle + 17.0))
        assert_on_plane(part)
        assert part.x[0] <= middle[0] - 22.0 and part.x[-1] >= middle[0] + 17.0 and part.z.size < 0.6 * whole.z.size
    area = np.isfinite(whole.z).sum() * np.diff(whole.x[:2])[0] * np.diff(whole.y[:2])[0]
    assert area == pytest.approx(abs(transform.determinant) * 2000, rel=0.12)  # a rim of half a cell


def test_a_turned_raster_is_told_and_holes_stay_holes(tmp_path):
    z = np.full((40, 50), 1000.0)
    z[18:22, 23:27] = -9999.0
    write_tif(tmp_path / "dem.tif", z, turned(30.0))
    with pytest.warns(UserWarning, match="its rows do not run east: elevations are interpolated"):
        surface = load_terrain(Spec(kind="dem", file="dem.tif"), tmp_path)
    at = turned(30.0)
    hole = [at.a * 25 + at.b * 20 + at.c, at.d * 25 + at.e * 20 + at.f]
    assert np.isnan(surface.height([hole])[0])
    np.testing.assert_allclose([surface.upper[2], surface.lower[2]], 1000.0, rtol=1e-12)  # nothing of -9999 seeps in


def write_asc(path, z=((30.0, 31.0), (20.0, 21.0)), x=WEST, y=SOUTH, cell=5.0):
    rows = "\n".join(" ".join(map(str, row)) for row in z)
    path.write_text(f"ncols {len(z[0])}\nnrows {len(z)}\nxllcenter {x}\nyllcenter {y}\ncellsize {cell}\n{rows}\n")
    return path


@pytest.mark.parametrize("dialect", ["WKT1_ESRI", "WKT1_GDAL", "WKT2_2019"])
def test_ascii_grid_with_a_projection_beside_it(tmp_path, dialect):
    path = write_asc(tmp_path / "dem.asc")

    def beside(epsg):
        (tmp_path / "dem.prj").write_text(pyproj.CRS(epsg).to_wkt(dialect))

    beside(32632)
    assert read_raster(path).x[0] == WEST
    beside(4326)
    with pytest.raises(InputError, match="degrees"):
        read_raster(path)
    beside(2927)
    with pytest.raises(InputError, match="elevation_unit"):
        read_raster(path)
    raster = quiet(read_raster, path, elevation_unit="us-ft")
    assert raster.x[0] == pytest.approx(WEST * SURVEY_FOOT) and raster.z[0, 0] == pytest.approx(20.0 * SURVEY_FOOT)


@pytest.mark.parametrize("content", ["PROJCS[nonsense", "Projection UTM\nUnits FEET\n", "\0" * 50, "x" * 200_000])
def test_a_projection_that_none_can_read_is_refused(tmp_path, content):
    (tmp_path / "dem.prj").write_text(content)
    with pytest.raises(InputError, match=r"dem\.prj"):
        read_raster(write_asc(tmp_path / "dem.asc"))


@pytest.mark.parametrize(("crs", "west", "north", "cell"), [
    ("EPSG:4326", 11.4, 47.1, 3e-4), ("EPSG:4979", 11.4, 47.1, 3e-4), ("EPSG:3857", 1_269_000.0, 5_958_000.0, 5.0),
    ("EPSG:4326+5773", 11.4, 47.1, 3e-4), ("EPSG:4326", 11.4, -47.1, 3e-4)])
def test_degrees_and_web_mercator_are_refused_with_a_command_that_mends_them(tmp_path, crs, west, north, cell):
    z = np.add.outer(np.linspace(2500.0, 1000.0, 80), np.zeros(60))
    path = write_tif(tmp_path / "dem.tif", z, rasterio.transform.from_origin(west, north, cell, cell), crs=crs)
    with pytest.raises(InputError, match="project it to metres") as refused:
        read_raster(path)
    command = re.search(r"`rio (.*)`", str(refused.value))[1].split()
    assert f"EPSG:{32632 if north > 0 else 32732}" in command
    command = [str(path) if word == "FILE" else str(tmp_path / word) if word == "OUT.tif" else word for word in command]
    rio = "from rasterio.rio.main import main_group; main_group()"
    subprocess.run([sys.executable, "-c", rio, *command], check=True, timeout=60)
    raster = read_raster(tmp_path / "OUT.tif")
    metres = 80 * cell * (111_180.0 if cell < 1.0 else np.cos(np.radians(47.09)))
    known = np.isfinite(raster.z).any(axis=1).sum() * (raster.y[1] - raster.y[0])
    assert known == pytest.approx(metres, rel=0.03)


def test_a_raster_without_a_place_is_refused(tmp_path):
    path = write_tif(tmp_path / "dem.tif", np.ones((4, 4)), rasterio.Affine.identity(), crs=None)
    with pytest.raises(InputError, match="has no place on the map"):
        quiet(read_raster, path)
    corners = [rasterio.control.GroundControlPoint(*at) for at in ((0, 0, WEST, SOUTH), (0, 4, WEST + 9, SOUTH),
                                                                  (4, 0, WEST, SOUTH - 9))]
    with rasterio.open(path, "w", driver="GTiff", width=4, height=4, count=1, dtype="float32") as target:
        target.write(np.ones((4, 4), np.float32), 1)
        target.gcps = corners, rasterio.crs.CRS.from_epsg(32632)
    with pytest.raises(InputError, match="has no place on the map"):
        quiet(read_raster, path)


def test_a_missing_system_is_said(tmp_path):
    path = write_tif(tmp_path / "dem.tif", np.ones((4, 4)), of_metres(1.0), crs=None)
    with pytest.warns(UserWarning, match="names no coordinate system: x and y are taken as metres"):
        assert read_raster(path).system is None


def test_degrees_without_a_system_are_seen_by_their_steepness(tmp_path):
    z = np.add.outer(np.linspace(2500.0, 1000.0, 80), np.zeros(60))
    with pytest.raises(InputError, match="look like degrees"):
        read_raster(write_asc(tmp_path / "dem.asc", z.tolist(), 11.4, 47.1, 3e-4))


def test_maps_of_a_run_in_feet_lie_where_the_ground_does(tmp_path):
    from snowmpm.running.recorder import map_origin

    write_tif(tmp_path / "dem.tif", np.full((4, 4), 1000.0), IN_FEET, crs="EPSG:2927+6360")
    scene = Spec(terrain=Spec(kind="dem", file="dem.tif"), base_dir=tmp_path, bodies=[])
    system = pyproj.CRS.from_wkt(map_origin(scene)["crs"])
    assert system.axis_info[0].unit_name == "metre" and not system.is_compound


# Release polygons

RING = [[WEST + x, SOUTH + y] for x, y in ((50, 50), (150, 60), (140, 150), (60, 140))]
AREA = 8100.0


def carried(ring, epsg):
    change = pyproj.Transformer.from_crs(UTM, epsg, always_xy=True)
    return [list(change.transform(*corner)) for corner in ring]


def write_geojson(path, ring, crs="absent"):
    data = {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}
    if crs != "absent":
        data["crs"] = crs and {"type": "name", "properties": {"name": crs}}
    path.write_text(json.dumps(data))
    return path


def write_shp(path, ring, epsg=None):
    shapefile = pytest.importorskip("shapefile")
    with shapefile.Writer(str(path)) as target:
        target.field("Name", "C", 10)
        target.poly([[*ring, ring[0]]])
        target.record("a")
    if epsg:
        path.with_suffix(".prj").write_text(pyproj.CRS(epsg).to_wkt("WKT1_ESRI"))
    return path


TERRAIN = ReferenceSystem.named(UTM, "")


@pytest.mark.parametrize("epsg", [4326, 31287, 3857, 2927, 4258, 32632])
@pytest.mark.parametrize("kind", ["shapefile", "geojson"])
def test_release_polygons_are_carried_into_the_terrain_s_system(tmp_path, epsg, kind):
    ring = carried(RING, epsg)
    path = (write_shp(tmp_path / "release.shp", ring, epsg) if kind == "shapefile" else
            write_geojson(tmp_path / "release.geojson", ring, f"urn:ogc:def:crs:EPSG::{epsg}"))
    (region,) = read_regions(path, "region.file", TERRAIN)
    # Systems on another datum: the change of datum is as exact as PROJ's, without grids, to some metres
    place = 5.0 if epsg in (31287, 2927) else 0.01
    np.testing.assert_allclose([region.lower, region.upper], [np.min(RING, axis=0), np.max(RING, axis=0)], atol=place)
    assert region.area() == pytest.approx(AREA, rel=1e-3)


def test_plain_geojson_is_in_degrees_by_definition(tmp_path):
    path = write_geojson(tmp_path / "release.geojson", carried(RING, 4326))
    (region,) = read_regions(path, "region.file", TERRAIN)
    assert region.area() == pytest.approx(AREA, rel=1e-6)
    np.testing.assert_allclose(region.lower, np.min(RING, axis=0), atol=0.01)


def test_plain_geojson_that_cannot_be_degrees_is_the_terrain_s_and_told(tmp_path):
    path = write_geojson(tmp_path / "release.geojson", RING)
    with pytest.warns(UserWarning, match="should be in degrees and is not: taken as WGS 84 / UTM zone 32N"):
        (region,) = read_regions(path, "region.file", TERRAIN)
    assert region.area() == pytest.approx(AREA, rel=1e-12)


@pytest.mark.parametrize(("epsg", "refused"), [(4326, "is in degrees"), (2927, "is in US survey foot"), (31287, None)])
def test_polygons_beside_a_terrain_without_a_system(tmp_path, epsg, refused):
    path = write_shp(tmp_path / "release.shp", carried(RING, epsg), epsg)
    if refused:
        with pytest.raises(InputError, match=f"{refused}.*the terrain names no coordinate system"):
            read_regions(path, "region.file", None)
    else:
        with pytest.warns(UserWarning, match="MGI / Austria Lambert, and the terrain names no coordinate system"):
            read_regions(path, "region.file", None)


def test_a_shapefile_without_a_projection_is_the_terrain_s(tmp_path):
    (region,) = read_regions(write_shp(tmp_path / "release.shp", RING), "region.file", TERRAIN)
    assert region.area() == pytest.approx(AREA, rel=1e-12)


@pytest.mark.parametrize("crs", ["EPSG:999999", "nonsense", "+proj=utm +zone=32", "urn:ogc:def:crs:EPSG::", 5,
                                 "x" * 10**6])
def test_a_crs_member_that_names_none_is_refused(tmp_path, crs):
    with pytest.raises(InputError, match="must be the name of a coordinate system") as refused:
        read_regions(write_geojson(tmp_path / "release.geojson", RING, crs), "region.file", TERRAIN)
    assert len(str(refused.value)) < 500


def test_the_same_system_under_two_names_moves_nothing():
    """As GDAL and ESRI write it: coordinates stay as they are, to the bit."""
    ring = np.array([[247_650.123, 352_010.456], [247_950.0, 352_200.7]])
    national = ReferenceSystem.named("EPSG:31287", "")
    written = ReferenceSystem.of_text(pyproj.CRS(31287).to_wkt("WKT1_ESRI"), "")
    np.testing.assert_array_equal(written.carried(ring, national), ring)


def test_mass_of_a_release_does_not_depend_on_the_units_of_its_files(tmp_path):
    """The same ground and the same release, in metres, and the ground in feet with the release in degrees."""
    from snowmpm.seeding import seed_body

    masses = []
    ring = [[1_219_200.0 + 10 * x, 381_000.0 + 10 * y] for x, y in ((10, 10), (30, 10), (30, 25), (10, 25))]  # m
    metric = ReferenceSystem.named("EPSG:32149", "")  # Washington South in metres, NAD83
    for name, metre, epsg in (("m", 1.0, 32149), ("ft", SURVEY_FOOT, 2286)):
        z = np.add.outer(np.linspace(1500.0, 1300.0, 80), np.zeros(100)) / metre
        transform = rasterio.Affine(5.0 / metre, 0.0, 1_219_200.0 / metre, 0.0, -5.0 / metre, 381_400.0 / metre)
        write_tif(tmp_path / f"{name}.tif", z, transform, crs=f"EPSG:{epsg}", units="m" if metre == 1.0 else "us-ft")
        surface = quiet(load_terrain, Spec(kind="dem", file=f"{name}.tif"), tmp_path)
        lonlat = metric.carried(np.array(ring), ReferenceSystem.named("EPSG:4269", ""))
        path = write_geojson(tmp_path / "release.geojson", lonlat.tolist(), "EPSG:4269")
        layer = Spec(kind="layer", bottom=0.0, top=2.0, region=Spec(file=path.name))
        seeds = seed_body(layer, surface, dim=3, dx=4.0, particles_per_cell=8, sampling="regular",
                          rng=np.random.default_rng(0), base_dir=tmp_path)
        masses.append(seeds.volumes.sum())
    slope = np.arctan(200.0 / (79 * 5.0))
    assert masses[0] == pytest.approx(30_000.0 * 2.0 / np.cos(slope), rel=1e-4)
    assert masses[1] == pytest.approx(masses[0], rel=1e-6)


@pytest.mark.parametrize("epsg", [31287, 32632])
def test_regions_of_forces_are_carried_into_the_terrain_s_system(tmp_path, epsg):
    path = write_shp(tmp_path / "wind.shp", carried(RING, epsg), epsg)
    spec = TypeAdapter(AnyForce).validate_python({"kind": "acceleration", "value": [1.0, 0.0, 0.0],
                                               "region": {"file": str(path)}})
    field = Acceleration(spec, 3, ".", "forces.0", lambda text: compiled(text, 3), None, TERRAIN)
    x = np.array([[WEST + 100.0, SOUTH + 100.0, 0.0], [WEST + 10.0, SOUTH + 100.0, 0.0]])
    np.testing.assert_array_equal(field.acceleration(x, 0.0 * x, 0.0)[:, 0], [1.0, 0.0])
