"""Terrain tables to surfaces: plane, profile, mesh, raster; and what is refused."""

import sys
import warnings

import numpy as np
import pyproj
import pytest
import trimesh

from snowmpm.errors import InputError
from snowmpm.terrain import load_terrain
from snowmpm.terrain.raster import read_raster
from snowmpm.terrain.surface import TerrainSurface
from tests.support.tables import Table as Spec


def load(tmp_path, **table):
    return load_terrain(Spec(**table), tmp_path)


def write_asc(path, z, x="xllcenter 1000", y="yllcenter 2000", size="cellsize 5"):
    """Rows of z from north to south."""
    rows = "\n".join(" ".join(str(v) for v in row) for row in z)
    header = f"ncols {len(z[0])}\nnrows {len(z)}\n{x}\n{y}\n{size}\nNODATA_value -9999\n"
    path.write_text(header + rows + "\n")
    return path.name


def test_plane_dips_towards_x_and_reaches_as_far_as_the_scene():
    spec = Spec(kind="plane", point=(10.0, 4.0), angle=30.0)
    surface = load_terrain(spec, extent=([-5.0, 0.0], [40.0, 9.0]), dimension=2)
    assert (surface.lower[0], surface.upper[0]) == (-5.0, 40.0)
    np.testing.assert_allclose(surface.height([[10.0], [13.0]]), [4.0, 4.0 - 3.0 * np.tan(np.pi / 6)], rtol=1e-14)


def test_plane_dips_towards_its_azimuth():
    spec = Spec(kind="plane", point=(1.0, 2.0, 3.0), angle=45.0, azimuth=90.0)
    surface = load_terrain(spec, extent=([0.0, 0.0], [5.0, 8.0]))
    np.testing.assert_allclose(surface.height([[4.0, 2.0], [1.0, 5.0]]), [3.0, 0.0], atol=1e-14)  # round-off


def test_plane_needs_to_know_how_far(tmp_path):
    with pytest.raises(InputError, match="domain"):
        load(tmp_path, kind="plane", point=(0.0, 0.0), angle=10.0)


def test_profile_is_what_it_says_whatever_its_direction(tmp_path):
    points = [[0.0, 30.0], [40.0, 5.0], [60.0, 5.0]]
    for order in (points, points[::-1]):
        surface = load(tmp_path, kind="profile", points=order)
        np.testing.assert_allclose(surface.height([[20.0], [50.0]]), [17.5, 5.0], rtol=1e-14)
        assert (surface.facet_normals[:, 1] > 0).all()


def test_profile_is_drawn_out_along_y(tmp_path):
    points = [[0.0, 30.0], [40.0, 5.0], [60.0, 5.0]]
    flat = load(tmp_path, kind="profile", points=points, fillet=15.0)
    table = Spec(kind="profile", points=points, fillet=15.0)
    deep = load_terrain(table, tmp_path, dimension=3, extent=([0.0, -2.0, 0.0], [60.0, 3.0, 40.0]))
    assert deep.area() == pytest.approx(5.0 * flat.area(), rel=1e-12)
    np.testing.assert_allclose([deep.lower, deep.upper], [[0.0, -2.0, 5.0], [60.0, 3.0, 30.0]], atol=1e-12)
    x = np.linspace(0.5, 59.5, 50)
    for y in (-1.9, 0.0, 2.9):
        np.testing.assert_allclose(deep.height(np.column_stack([x, np.full(50, y)])), flat.height(x[:, None]),
                                   rtol=1e-12)
    assert (deep.facet_normals[:, 2] > 0).all() and (np.abs(deep.facet_normals[:, 1]) < 1e-14).all()


def test_fillet_is_an_arc_tangent_to_both_sides(tmp_path):
    points = np.array([[0.0, 30.0], [40.0, 5.0], [60.0, 5.0]])
    surface = load(tmp_path, kind="profile", points=points, fillet=15.0)
    turn = np.arctan2(25.0, 40.0)
    tangent = 15.0 * np.tan(turn / 2)
    centre = np.array([40.0 + tangent, 20.0])
    arc = surface.vertices[np.abs(np.linalg.norm(surface.vertices - centre, axis=1) - 15.0) < 1e-9]
    assert len(arc) == len(surface.vertices) - 2  # all but the ends
    np.testing.assert_allclose(arc[-1], [40.0 + tangent, 5.0], atol=1e-12)  # round-off
    along = np.hypot(25.0, 40.0) - tangent
    np.testing.assert_allclose(
        arc[0], [40.0, 30.0] * np.array([along / np.hypot(25, 40), 1]) - [0, 25 * along / np.hypot(25, 40)], atol=1e-12
    )
    expected = along + 15.0 * turn + 20.0 - tangent
    assert surface.area() == pytest.approx(
        expected, rel=2e-6
    )  # chords of 1 degree: 1 - 1.3e-5 of the arc's 8.4 m in 67


def test_fillet_that_does_not_fit_says_what_fits(tmp_path):
    points = [[0.0, 10.0], [10.0, 0.0], [12.0, 0.0], [20.0, -8.0]]
    with pytest.raises(InputError, match=r"terrain.fillet = 30.0: .* at most 2.414 m"):
        load(tmp_path, kind="profile", points=points, fillet=30.0)
    load(tmp_path, kind="profile", points=points, fillet=2.414)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_open_meshes_of_every_format(tmp_path, suffix):
    vertices = np.array([[0, 0, 0], [4, 0, 1], [4, 4, 2], [0, 4, 1]], float)
    trimesh.Trimesh(vertices, [[0, 2, 1], [0, 2, 3]], process=False).export(tmp_path / f"slope.{suffix}")
    surface = load(tmp_path, kind="mesh", file=f"slope.{suffix}")
    assert (len(surface.vertices), len(surface.facets), surface.closed) == (4, 2, False)
    np.testing.assert_allclose(surface.height([[3.0, 1.0]]), 1.0, atol=1e-6)  # STL is float32
    assert (surface.facet_normals[:, 2] > 0).all()


def test_mesh_is_cut_to_what_the_scene_reaches(tmp_path):
    trimesh.creation.box((100.0, 100.0, 2.0)).subdivide().subdivide().export(tmp_path / "block.stl")
    surface = load_terrain(Spec(kind="mesh", file="block.stl"), tmp_path, extent=([0, 0, -5], [10, 10, 5]))
    assert surface.upper[0] < 40.0
    assert surface.height([[5.0, 5.0]])[0] == 1.0


@pytest.mark.parametrize("registration", ["center", "corner"])
def test_ascii_grid_in_both_registrations(tmp_path, registration):
    shift = 0.0 if registration == "center" else 2.5
    z = [[30, 31, 32], [20, 21, 22], [10, 11, 12]]
    name = write_asc(
        tmp_path / "dem.asc", z, f"xll{registration} {1000 - shift}", f"YLL{registration.upper()} {2000 - shift}"
    )
    surface = load(tmp_path, kind="dem", file=name)
    assert surface.lower.tolist() == [1000.0, 2000.0, 10.0]
    np.testing.assert_allclose(surface.height([[1000, 2000], [1010, 2010], [1002.5, 2005]]), [10, 32, 20.5], rtol=1e-14)


def test_no_data_cells_are_holes(tmp_path):
    z = np.full((6, 6), 100.0)
    z[2:4, 2:4] = -9999
    z[0, 0] = np.nan
    surface = load(tmp_path, kind="dem", file=write_asc(tmp_path / "dem.asc", z))
    height = surface.height([[1012.5, 2012.5], [1007.0, 2012.5], [1002.0, 2002.0], [1000.5, 2024.5], [1003.0, 2023.0]])
    np.testing.assert_array_equal(height, [np.nan, np.nan, 100.0, np.nan, 100.0])  # three cells make half a square


@pytest.mark.parametrize("sign", [1, -1])
def test_diagonals_follow_ridges_and_gullies(tmp_path, sign):
    """z = (x - y)^2 and (x + y)^2 are constant along one diagonal: split along it, cell middles are exact."""
    i = np.arange(8.0)
    z = (i - sign * i[::-1, None] + 0.5 * sign) ** 2 * sign  # rows from north to south
    surface = load(tmp_path, kind="dem", file=write_asc(tmp_path / "dem.asc", z))
    middle = np.stack(np.meshgrid(i[1:-2], i[1:-2]), axis=-1).reshape(-1, 2) + 0.5
    exact = (middle[:, 0] - sign * middle[:, 1] + 0.5 * sign) ** 2 * sign
    np.testing.assert_allclose(surface.height(middle * 5.0 + [1000.0, 2000.0]), exact, rtol=1e-12)  # round-off


def test_only_the_part_that_is_used_is_read(tmp_path):
    z = np.add.outer(np.arange(400.0)[::-1], np.arange(300.0) * 0.1)
    name = write_asc(tmp_path / "dem.asc", z)
    box = (np.array([1500.0, 2600.0]), np.array([1520.0, 2651.0]))
    raster = read_raster(tmp_path / name, box)
    assert raster.z.shape == (12, 5)  # 2600 to 2655, 1500 to 1520
    surface = load_terrain(Spec(kind="dem", file=name), tmp_path, extent=box)
    np.testing.assert_allclose(surface.height([[1510.0, 2625.0]]), 125.0 + 10.2, rtol=1e-14)
    part = load(tmp_path, kind="dem", file=name, region=Spec(x=(1500.0, 1520.0), y=None))
    assert (part.lower[0], part.upper[0], part.upper[1]) == (1500.0, 1520.0, 3995.0)


def test_geotiff_gives_the_same_as_the_ascii_grid(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    z = np.array([[30.0, 31, 32], [20, -9999, 22], [10, 11, 12], [0, 1, 2]])
    profile = {"driver": "GTiff", "width": 3, "height": 4, "count": 1, "dtype": "float64", "nodata": -9999}
    with rasterio.open(
        tmp_path / "dem.tif",
        "w",
        **profile,
        crs="EPSG:31287",
        transform=rasterio.transform.from_origin(997.5, 2017.5, 5, 5),
    ) as target:
        target.write(z, 1)
    write_asc(tmp_path / "dem.asc", z)
    for box in (None, (np.array([1000.0, 2000.0]), np.array([1004.0, 2003.0]))):
        a, b = (read_raster(tmp_path / f"dem.{suffix}", box) for suffix in ("asc", "tif"))
        for name in ("x", "y", "z"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    with rasterio.open(
        tmp_path / "degrees.tif",
        "w",
        **profile,
        crs="EPSG:4326",
        transform=rasterio.transform.from_origin(11, 47, 1, 1),
    ) as target:
        target.write(z, 1)
    with pytest.raises(InputError, match="degrees"):
        load(tmp_path, kind="dem", file="degrees.tif")


def test_missing_gis_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    (tmp_path / "dem.tif").write_bytes(b"")
    with pytest.raises(InputError, match=r"pip install 'snowmpm\[gis\]'"):
        load(tmp_path, kind="dem", file="dem.tif")


def test_bad_files_are_named(tmp_path):
    (tmp_path / "junk.stl").write_text("hello, this is no mesh")
    (tmp_path / "junk.obj").write_bytes(bytes(range(256)) * 4)
    (tmp_path / "junk.ply").write_text("ply\nformat ascii 1.0\nelement vertex two\n")
    (tmp_path / "short.stl").write_bytes(b"x" * 80 + (1000).to_bytes(4, "little") + b"y" * 100)
    (tmp_path / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        "0 0 0\n1 1 1\n"
    )
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\n")
    (tmp_path / "line.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    (tmp_path / "scene.py").write_text("raise SystemExit")
    (tmp_path / "binary.asc").write_bytes(bytes(range(256)))
    (tmp_path / "text.asc").write_text("name value\n1 2\n")
    (tmp_path / "junk.tif").write_text("no tiff")
    write_asc(tmp_path / "empty.asc", [[-9999, -9999], [-9999, -9999]])
    write_asc(tmp_path / "words.asc", [[1, 2], ["three", 4]])
    write_asc(tmp_path / "few.asc", [[1, 2, 3], [4, 5]])
    write_asc(tmp_path / "single.asc", [[1, -9999], [-9999, 2]])
    write_asc(tmp_path / "negative.asc", [[1, 2], [3, 4]], size="cellsize -5")
    write_asc(tmp_path / "no_number.asc", [[1, 2], [3, 4]], size="cellsize five")
    cases = {
        "missing.stl": "no such file",
        "junk.stl": "no triangles|not a readable STL",
        "junk.obj": "no triangles|not a readable OBJ",
        "junk.ply": "not a readable PLY",
        "short.stl": "no triangles|not a readable STL",
        "cloud.ply": "no triangles",
        "points.obj": "no triangles|not a readable OBJ",
        "line.obj": "no triangles with an area",
        "scene.py": "must be an .stl, .obj, .ply or .glb file",
        "binary.asc": "not an ESRI ASCII grid",
        "text.asc": "header line 'ncols' is missing",
        "junk.tif": "not a readable GeoTIFF|gis extra",
        "empty.asc": "only no-data",
        "words.asc": "not a number",
        "few.asc": "holds 5 values where its header promises 6",
        "single.asc": "no three neighbouring cells",
        "negative.asc": "positive",
        "no_number.asc": "line 5.*needs one number",
    }
    for file, message in cases.items():
        kind = "dem" if file.endswith(("asc", "tif")) else "mesh"
        with pytest.raises(InputError, match=message) as caught:
            load(tmp_path, kind=kind, file=file)
        assert str(caught.value).startswith("terrain.file = "), file
        assert len(str(caught.value).splitlines()) == 1, file
        assert file in str(caught.value)


def test_mesh_materials_are_not_opened(tmp_path):
    """A mesh file may name other files; nothing of them is read."""
    (tmp_path / "secret.mtl").write_text("newmtl a\nmap_Kd http://example.invalid/texture.png\n")
    (tmp_path / "tri.obj").write_text("mtllib secret.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert len(load(tmp_path, kind="mesh", file="tri.obj").facets) == 1


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "hill"}, "terrain.kind = 'hill'"),
        ({"kind": "profile", "points": [[0, 1]]}, "at least two points"),
        ({"kind": "profile", "points": [[0, 1], [2, 0], [1, -1], [5, -1]]}, "x must not turn back, but 1 follows 2"),
        ({"kind": "profile", "points": [[0, 1], [0, 0]]}, "no horizontal extent"),
    ],
)
def test_bad_tables(tmp_path, table, message):
    with pytest.raises(InputError, match=message):
        load(tmp_path, **table)


def test_dimension_must_fit_the_scene(tmp_path):
    with pytest.raises(InputError, match="needs the domain, to know how far it is drawn out"):
        load_terrain(Spec(kind="profile", points=[[0, 1], [2, 0]]), dimension=3)
    with pytest.raises(InputError, match="must have 2 numbers"):
        load_terrain(Spec(kind="plane", point=(0, 0, 0)), dimension=2, extent=([0, 0], [1, 1]))


@pytest.mark.parametrize(("suffix", "remark", "metre"), [
    ("stl", "COLOR=abcd UNITS=mm ", 0.001), ("stl", "made by x, UNITS= inch", 0.0254), ("stl", "made by a unit", 1.0),
    ("obj", "# File units = feet", 0.3048), ("obj", "# units: meters", 1.0), ("obj", "# 3 units in all", 1.0),
    ("obj", "# Units: US survey feet", 1200 / 3937), ("obj", "# all units are in centimetres", 0.01),
    ("obj", "# the units in the east are new", 1.0), ("obj", "# the unit in question", 1.0),
    ("ply", "comment unit = mm", 0.001), ("ply", "comment unit: m", 1.0)])
def test_a_mesh_that_names_its_unit_is_converted(tmp_path, suffix, remark, metre):
    vertices = np.array([[0, 0, 0], [4, 0, 1], [4, 4, 2], [0, 4, 1]], float)
    path = tmp_path / f"slope.{suffix}"
    trimesh.Trimesh(vertices, [[0, 2, 1], [0, 2, 3]], process=False).export(path)
    data = path.read_bytes()
    if suffix == "stl":
        data = remark.encode().ljust(80) + data[80:]
    elif suffix == "obj":
        data = remark.encode() + b"\n" + data
    else:
        data = data.replace(b"element vertex", remark.encode() + b"\nelement vertex", 1)
    path.write_bytes(data)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        surface = load(tmp_path, kind="mesh", file=path.name)
    np.testing.assert_allclose(surface.upper, np.array([4.0, 4.0, 2.0]) * metre, rtol=1e-6)
    assert any("converted to metres" in str(one.message) for one in told) == (metre != 1.0)


def test_a_mesh_in_a_unit_that_is_no_length_is_refused(tmp_path):
    (tmp_path / "tri.obj").write_text("# units: parsec\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(InputError, match="'parsec': must be a length"):
        load(tmp_path, kind="mesh", file="tri.obj")


@pytest.mark.parametrize(("epsg", "message"), [(4326, "degrees"), (2927, "US survey foot: must be in metres"),
                                               (32632, None)])
def test_a_mesh_with_a_projection_beside_it(tmp_path, epsg, message):
    x, y = (400_000.0, 250_000.0) if epsg == 2927 else (660_000.0, 5_217_000.0)
    (tmp_path / "tri.obj").write_text(f"v {x} {y} 0\nv {x + 9} {y} 0\nv {x} {y + 9} 5\nf 1 2 3\n")
    (tmp_path / "tri.prj").write_text(pyproj.CRS(epsg).to_wkt("WKT1_ESRI"))
    if message:
        with pytest.raises(InputError, match=message):
            load(tmp_path, kind="mesh", file="tri.obj")
    else:
        assert load(tmp_path, kind="mesh", file="tri.obj").system.name == "WGS 84 / UTM zone 32N"


def test_a_raster_without_gaps_is_the_surface_that_its_facets_would_be_put_right_to(tmp_path):
    z = np.random.default_rng(3).uniform(0.0, 40.0, (7, 9)).round(3)
    surface = load(tmp_path, kind="dem", file=write_asc(tmp_path / "rough.asc", z))
    looked_at = TerrainSurface.of(surface.vertices[::-1], len(surface.vertices) - 1 - surface.facets[:, ::-1])
    np.testing.assert_array_equal(surface.vertices, looked_at.vertices)
    corners = [np.sort(facets, axis=1)[np.lexsort(np.sort(facets, axis=1).T)] for facets in (
        surface.facets, looked_at.facets)]
    np.testing.assert_array_equal(*corners)
    assert not looked_at.closed
    assert (surface.facet_normals[:, 2] > 0.0).all()
