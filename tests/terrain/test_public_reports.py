"""Input files of the kinds that tripped up other programs, as their public reports have them."""

import json
import sqlite3
import struct

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding.region_files import read_features
from snowmpm.terrain.mesh import mesh_facets
from snowmpm.terrain.raster import read_raster

rasterio, shapefile = pytest.importorskip("rasterio"), pytest.importorskip("shapefile")
pyogrio, shapely = pytest.importorskip("pyogrio"), pytest.importorskip("shapely")

HEAD = "ncols 4\nnrows 4\nxllcorner 600000\nyllcorner 5200000\n"
V = np.array([[1000.0 + 10 * r + c for c in range(4)] for r in range(4)])
"""Heights from north to south."""


def text(rows=V, cell="cellsize 10", none="-9999"):
    return f"{HEAD}{cell}\nNODATA_value {none}\n" + "\n".join(" ".join(map(str, row)) for row in rows) + "\n"


def tif(path, z=V, transform=(10.0, 0.0, 600000.0, 0.0, -10.0, 5200040.0), **more):
    z = np.asarray(z, "float32")
    return rasterio.open(path, "w", driver="GTiff", width=z.shape[1], height=z.shape[0], count=1, dtype="float32",
                         crs="EPSG:32632", transform=rasterio.Affine(*transform), **more)


def square(x, y=5200010.0, side=10.0):
    return [[x, y], [x, y + side], [x + side, y + side], [x + side, y], [x, y]]


def areas(features):
    return [sum(shapely.Polygon(part[0], part[1:]).area for part in one.parts) for one in features]


@pytest.mark.parametrize("word", ["null", "NA", "none"])
def test_words_for_none(tmp_path, word):
    """GDAL 5095."""
    rows = V.astype(int).astype(str).astype(object)
    rows[0, 0] = rows[2, 3] = word
    (tmp_path / "dem.asc").write_text(text(rows, none=word))
    z = read_raster(tmp_path / "dem.asc").z[::-1]
    assert np.argwhere(np.isnan(z)).tolist() == [[0, 0], [2, 3]] and z[0, 1] == 1001.0


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_byte_order_marks(tmp_path, encoding):
    """GDAL 11272."""
    (tmp_path / "dem.asc").write_text(text(), encoding=encoding)
    assert (read_raster(tmp_path / "dem.asc").z[::-1] == V).all()


def test_two_numbers_for_a_cell(tmp_path):
    """geoclaw 137, AvaFrame 425: the second was left out in silence."""
    (tmp_path / "dem.asc").write_text(text(cell="cellsize 10 20"))
    with pytest.raises(InputError, match="line 5: 'cellsize 10 20' needs one number"):
        read_raster(tmp_path / "dem.asc")
    (tmp_path / "dem.asc").write_text(text(cell="dx 10\ndy 20"))
    assert np.diff(read_raster(tmp_path / "dem.asc").y).tolist() == [20.0] * 3


def test_rows_that_do_not_end_with_lines(tmp_path):
    """PVGeo 67: as many lines as rows by accident; a part was read from the wrong rows."""
    flat = [f"{v:g}" for v in V.ravel()]
    lines = [" ".join(flat[a:b]) for a, b in ((0, 2), (2, 6), (6, 10), (10, 16))]
    (tmp_path / "dem.asc").write_text(f"{HEAD}cellsize 10\n" + "\n".join(lines))
    part = read_raster(tmp_path / "dem.asc", ((600006.0, 5200016.0), (600034.0, 5200024.0)))
    assert (read_raster(tmp_path / "dem.asc").z[::-1] == V).all()
    assert (part.z[::-1] == V[1:3]).all()


@pytest.mark.filterwarnings("error:.*does not declare")
@pytest.mark.parametrize("name", ["dem.asc", "dem.tif"])
def test_no_data_that_is_rounded(tmp_path, name):
    """WindNinja 576: -3.4e38 in the tag, -3.4028235e38 in the cells."""
    z = V.copy()
    z[0] = np.finfo("float32").min
    if name == "dem.asc":
        (tmp_path / name).write_text(text(z, none="-3.4e+38"))
    else:
        with tif(tmp_path / name, nodata=float(np.finfo("float32").min)) as target:
            target.write(z.astype("float32"), 1)
    assert np.isnan(read_raster(tmp_path / name).z[::-1]).sum(axis=1).tolist() == [4, 0, 0, 0]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_feet_south_up_and_quarter_turns(tmp_path):
    """stac-3dep-1m 34, whitebox_next_gen 36, GDAL 1474."""
    with tif(tmp_path / "feet.tif") as target:
        target.write((V / 0.3048006096).astype("float32"), 1)
        target.units = ("US survey foot",)
    with tif(tmp_path / "south.tif", transform=(10.0, 0.0, 600000.0, 0.0, 10.0, 5200000.0)) as target:
        target.write(V[::-1].astype("float32"), 1)
    with tif(tmp_path / "turned.tif", transform=(0.0, 10.0, 600000.0, 10.0, 0.0, 5200000.0)) as target:
        target.write(np.ascontiguousarray(V[::-1].T).astype("float32"), 1)
    for name in ("feet", "south", "turned"):
        assert read_raster(tmp_path / f"{name}.tif").z[::-1] == pytest.approx(V, abs=1e-3)


def test_a_stale_file_beside_a_raster_is_told(tmp_path):
    """xarray-spatial 3595: GDAL obeys it."""
    with tif(tmp_path / "dem.tif") as target:
        target.write(V.astype("float32"), 1)
    (tmp_path / "dem.tif.aux.xml").write_text(
        "<PAMDataset><GeoTransform>700000,5,0,5300020,0,-5</GeoTransform><PAMRasterBand band=\"1\"><NoDataValue>1011"
        "</NoDataValue><Offset>100</Offset><Scale>2</Scale></PAMRasterBand></PAMDataset>")
    with pytest.warns(UserWarning, match="place and number for no data and scale come from dem.tif.aux.xml"):
        read_raster(tmp_path / "dem.tif")
    (tmp_path / "dem.tif.aux.xml").write_text("<PAMDataset></PAMDataset>")
    assert (read_raster(tmp_path / "dem.tif").z[::-1] == V).all()


def test_an_internal_mask(tmp_path):
    """rasterstats 197."""
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True), tif(tmp_path / "dem.tif") as target:
        target.write(np.where(np.arange(4)[:, None] == 0, 5.0, V).astype("float32"), 1)
        target.write_mask(np.where(np.arange(4)[:, None] == 0, 0, 255) * np.ones((4, 4), "uint8"))
    assert np.isnan(read_raster(tmp_path / "dem.tif").z[::-1]).sum(axis=1).tolist() == [4, 0, 0, 0]


def shapes(path, xs, values):
    with shapefile.Writer(str(path)) as writer:
        writer.field("thickness", "N", 8, 2)
        for x, value in zip(xs, values, strict=True):
            writer.poly([square(x)])
            writer.record(value)
    return path


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_shapes_that_only_the_index_leaves_out(tmp_path):
    """pyshp 119: a deleted shape stays in the .shp."""
    path = shapes(tmp_path / "r.shp", (600000.0, 600015.0, 600030.0), (1.0, 2.0, 3.0))
    index, table = path.with_suffix(".shx").read_bytes(), bytearray(path.with_suffix(".dbf").read_bytes())
    path.with_suffix(".shx").write_bytes(index[:24] + struct.pack(">i", 58) + index[28:108] + index[116:124])
    head, row = struct.unpack("<2H", table[8:12])
    table[4:8] = struct.pack("<I", 2)
    path.with_suffix(".dbf").write_bytes(table[:head] + table[head:head + row] + table[head + 2 * row:])
    found = read_features(path, "file")
    assert [(one.parts[0][0][:, 0].min(), one.thickness) for one in found] == [(600000.0, 1.0), (600030.0, 3.0)]
    path.with_suffix(".shx").unlink()
    with pytest.warns(UserWarning, match="has 2 rows for 3 shapes: which belong together is unknown"):
        assert [one.thickness for one in read_features(path, "file")] == [None] * 3


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_decimal_comma_in_a_table_of_numbers(tmp_path):
    """mapshaper 83."""
    path = shapes(tmp_path / "r.shp", (600000.0, 600015.0), (1.5, 2.0))
    table = path.with_suffix(".dbf")
    table.write_bytes(table.read_bytes().replace(b"1.50", b"1,50"))
    flaws = [one.flaw for one in read_features(path, "file")]
    assert flaws == ["polygon 1: thickness = '1,50': must be a number of metres; with a point: 1.50", ""]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("rings", [1, 2])
def test_rings_that_are_not_closed(tmp_path, rings):
    """AvaFrame 1103."""
    corners = [[(600000.0 + 50.0 * k, 5200005.0), (600010.0 + 50.0 * k, 5200035.0), (600030.0 + 50.0 * k, 5200005.0)]
               for k in range(rings)]
    points = [p for ring in corners for p in ring]
    body = struct.pack("<i4d2i", 5, 600000.0, 5200005.0, 600080.0, 5200035.0, rings, len(points))
    body += struct.pack(f"<{rings}i", *(3 * k for k in range(rings))) + b"".join(struct.pack("<2d", *p) for p in points)
    record = struct.pack(">2i", 1, len(body) // 2) + body
    head = struct.pack(">7i", 9994, 0, 0, 0, 0, 0, (100 + len(record)) // 2) + struct.pack(
        "<2i8d", 1000, 5, 600000.0, 5200005.0, 600080.0, 5200035.0, 0.0, 0.0, 0.0, 0.0)
    (tmp_path / "r.shp").write_bytes(head + record)
    assert areas(read_features(tmp_path / "r.shp", "file")) == [pytest.approx(450.0 * rings)]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_layers_of_any_type_and_curves(tmp_path):
    """GDAL 14863, geoparquet-io 643."""
    box = shapely.box(600000.0, 5200000.0, 600010.0, 5200010.0)
    for name, kind, rows in (("any", "Unknown", [box]), ("curved", "MultiPolygon", [shapely.MultiPolygon([box])] * 2)):
        pyogrio.raw.write(tmp_path / f"{name}.gpkg", shapely.to_wkb(rows), [np.ones(len(rows))], ["thickness"],
                          layer="rel", driver="GPKG", geometry_type=kind, crs="EPSG:32632")
    assert areas(read_features(tmp_path / "any.gpkg", "file")) == [100.0]
    circle = [(600020, 5200030), (600025, 5200035), (600030, 5200030), (600025, 5200025), (600020, 5200030)]
    curve = struct.pack("<BII", 1, 12, 1) + struct.pack("<BII", 1, 10, 1) + struct.pack("<BII", 1, 8, 5) + b"".join(
        struct.pack("<2d", *point) for point in circle)
    with sqlite3.connect(tmp_path / "curved.gpkg") as base:
        names = base.execute("select name from sqlite_master where type='trigger' and tbl_name='rel'").fetchall()
        for (name,) in names:
            base.execute(f'drop trigger "{name}"')
        base.execute("update rel set geom=? where fid=2", (b"GP\0\1" + struct.pack("<i", 32632) + curve,))
    try:
        found = areas(read_features(tmp_path / "curved.gpkg", "file"))
    except InputError as refused:  # an older library
        assert "GeoPackage" in str(refused)
    else:
        assert found == [100.0, pytest.approx(25.0 * np.pi, rel=0.01)]


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_system_as_older_geojson_names_it(tmp_path):
    """GeoJSON.Net 98."""
    polygon = {"type": "Polygon", "coordinates": [square(600010.0)]}
    (tmp_path / "r.geojson").write_text(json.dumps({
        "type": "FeatureCollection", "crs": {"type": "EPSG", "properties": {"code": 32632}},
        "features": [{"type": "Feature", "properties": {}, "geometry": polygon}]}))
    with pytest.warns(UserWarning, match="is in WGS 84 / UTM zone 32N"):
        assert areas(read_features(tmp_path / "r.geojson", "file")) == [100.0]


def test_corners_that_count_backwards(tmp_path):
    """trimesh 2364: all faces became the last one."""
    blocks = [f"v {x} 0 {z}\nv {x + 10} 0 {z}\nv {x} 10 {z}\nf -3 -2 -1\n" for x, z in ((0, 0), (20, 5), (40, 10))]
    (tmp_path / "slope.obj").write_text("".join(blocks))
    vertices, faces = mesh_facets(tmp_path / "slope.obj")
    assert sorted(vertices[faces][:, :, 0].min(axis=1).tolist()) == [0.0, 20.0, 40.0]
    mixed = "v 0 0 0\nv 10 0 0\nv 0 10 0\nvn 0 0 1\nf -3//-1 -2//-1 -1//-1\nv 20 0 0\nf 2 -1 3\n"
    (tmp_path / "slope.obj").write_text(mixed)
    vertices, faces = mesh_facets(tmp_path / "slope.obj")
    assert sorted(map(sorted, vertices[faces][:, :, 0].tolist())) == [[0.0, 0.0, 10.0], [0.0, 10.0, 20.0]]


@pytest.mark.parametrize(("east", "told"), [(2_600_000.0, True), (0.0, False)])
def test_places_that_single_precision_does_not_hold(tmp_path, east, told):
    """TouchTerrain 86."""
    x, y = east + 0.1 * np.arange(5), 0.1 * np.arange(5)
    corners = np.array([[(x[i], y[j], 5.0), (x[i + 1], y[j], 5.0), (x[i + 1], y[j + 1], 5.0)]
                        for i in range(4) for j in range(4)])
    table = np.zeros(len(corners), [("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    table["c"] = corners
    (tmp_path / "slope.stl").write_bytes(b"terrain".ljust(80) + struct.pack("<I", len(table)) + table.tobytes())
    if told:
        with pytest.warns(UserWarning, match=r"single precision holds places to 0.25 m there, and sides are"):
            mesh_facets(tmp_path / "slope.stl")
    else:
        mesh_facets(tmp_path / "slope.stl")


@pytest.mark.parametrize("order", ["little", "big"])
def test_ply_in_both_orders_and_line_ends(tmp_path, order):
    """algodat 57."""
    sign = "<" if order == "little" else ">"
    head = (f"ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
            "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n")
    places = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 1], [0, 10, 1]], f"{sign}f4")
    faces = b"".join(struct.pack(f"{sign}B3i", 3, *face) for face in ((0, 1, 2), (0, 2, 3)))
    (tmp_path / "slope.ply").write_bytes(head.replace("\n", "\r\n" if order == "little" else "\n").encode()
                                         + places.tobytes() + faces)
    vertices, found = mesh_facets(tmp_path / "slope.ply")
    assert (vertices == places).all() and found.tolist() == [[0, 1, 2], [0, 2, 3]]
