"""Meshes, rasters, polygons and images that promise more than they hold, or hold what no ground has."""

import gzip
import io
import json
import struct
import zipfile

import numpy as np
import pytest
from scenes_under_attack import GRID, of_voxels, on_region, on_terrain, written

BILLION = 4_000_000_000
NESTED = "[" * 100_000
LONG = "x" * 1_000_000


def stl(count, triangles=()):
    body = b"".join(struct.pack("<12fH", *np.zeros(3), *np.ravel(t), 0) for t in triangles)
    return b"\0" * 80 + struct.pack("<I", count) + body


def ascii_stl(line):
    return ("solid x\nfacet normal 0 0 1\nouter loop\n" + line * 3 + "endloop\nendfacet\nendsolid x\n").encode()


def ply(head, body=b""):
    return b"ply\n" + head.encode() + b"end_header\n" + body


VERTEX = "property float x\nproperty float y\nproperty float z\n"
FACE = "property list uchar int vertex_indices\n"
MESHES = {
    "count.stl": stl(BILLION), "count_less.stl": stl(1, [np.eye(3)] * 5), "nan.stl": stl(1, [np.full((3, 3), np.nan)]),
    "inf.stl": stl(1, [np.full((3, 3), np.inf)]), "huge.stl": stl(1, [np.eye(3) * 1e38]),
    "point.stl": stl(1, [np.ones((3, 3))]),
    "line.stl": stl(1, [[[0, 0, 0], [1, 1, 1], [2, 2, 2]]]), "nothing.stl": b"", "header.stl": b"solid " + b"\0" * 74,
    "words.stl": ascii_stl("vertex a b c\n"), "nan_words.stl": ascii_stl("vertex nan nan nan\n"),
    "digits.stl": ascii_stl("vertex " + "9" * 5000 + " 0 0\n"), "long.stl": b"solid " + LONG.encode(),
    "count.ply": ply(f"format binary_little_endian 1.0\nelement vertex {BILLION}\n{VERTEX}element face 1\n{FACE}"),
    "faces.ply": ply(f"format binary_little_endian 1.0\nelement vertex 0\n{VERTEX}element face {BILLION}\n{FACE}"),
    "digits.ply": ply(f"format ascii 1.0\nelement vertex {'9' * 5000}\n{VERTEX}element face 1\n{FACE}"),
    "below.ply": ply(f"format ascii 1.0\nelement vertex -5\n{VERTEX}element face -1\n{FACE}"),
    "list.ply": ply(f"format binary_little_endian 1.0\nelement vertex 3\n{VERTEX}element face 1\n"
                    "property list uint int v\n", b"\0" * 36 + struct.pack("<I", BILLION)),
    "properties.ply": ply("format ascii 1.0\nelement vertex 1\n" + "property float x\n" * 20_000),
    "long.ply": b"ply\n" + LONG.encode(), "nothing.ply": b"", "endless.ply": b"ply\n" + b"comment x\n" * 100_000,
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999\n",
    "below.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9 -8 -7\n",
    "zero.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 0 0\n", "digits.obj": b"v " + b"9" * 5000 + b" 0 0\nf 1 1 1\n",
    "face_digits.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 " + b"9" * 5000 + b"\n",
    "nan.obj": b"v nan nan nan\n" * 3 + b"f 1 2 3\n",
    "library.obj": b"mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 1 1\n", "long.obj": LONG.encode(),
    "polygon.obj": b"v 0 0 0\n" * 3 + b"f" + b" 1" * 200_000 + b"\n", "nul.obj": b"v 0 0 0\0\nf 1 1 1\0\n",
    "xml.obj": b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><x>&a;</x>',
    "gzip.stl": lambda: gzip.compress(b"\0" * 50_000_000),
}


@pytest.mark.parametrize("name", MESHES)
def test_mesh(withstood, tmp_path, name):
    written(tmp_path / name, MESHES[name])
    on_terrain(tmp_path, name, "mesh")
    withstood("check", "scene.toml", code=2)


def test_mesh_without_an_end(withstood, tmp_path):
    for name in ("sparse.stl", "sparse.ply", "sparse.obj"):
        with open(tmp_path / name, "wb") as file:
            file.truncate(1 << 40)
        on_terrain(tmp_path, name, "mesh")
        withstood("check", "scene.toml", code=2)
        withstood("new", "own", "--terrain", name, code=2)


def grid(**header):
    lines = GRID.split("\n")
    for key, value in header.items():
        lines = [f"{key} {value}" if line.split()[:1] == [key] else line for line in lines]
    return "\n".join(lines)


GRIDS = {
    **{f"ncols_{i}": grid(ncols=value) for i, value in enumerate(
        ["nan", "inf", "-inf", "-1", "0", "1e300", "9" * 5000, "1.5", "", "x", "1e9", "2 3", "0x10", "1_2"])},
    **{f"cellsize_{i}": grid(cellsize=value) for i, value in enumerate(["nan", "inf", "0", "-1", "1e-320",
                                                                         "9" * 5000])},
    **{f"xllcorner_{i}": grid(xllcorner=value) for i, value in enumerate(["nan", "inf", "1e308", "x"])},
    "nrows_nan": grid(nrows="nan"), "both_large": grid(ncols="1e6", nrows="1e6"), "nothing": "", "nul": "\0" * 1000,
    "long_line": "ncols " + LONG, "long_number": GRID.replace("5 ", "9" * 5000 + " ", 1),
    "words": GRID.replace("5 ", "x ", 1),
    "short": GRID[:-30], "long": GRID + " 1 1 1", "only_header": "".join(line + "\n" for line in GRID.split("\n")[:6]),
    "header_twice": "ncols 5\n" * 100_000 + GRID, "infinite_values": GRID.replace("5 ", "inf "),
    "no_data_nan": grid(NODATA_value="nan"), "control": "\x1b[2J 1\n" + GRID, "utf16": GRID.encode("utf-16"),
}


HARMLESS = ("no_data_nan", "header_twice", "ncols_13", "long_number", "infinite_values")


@pytest.mark.parametrize("name", GRIDS)
def test_grid(withstood, tmp_path, name):
    written(tmp_path / "grid.asc", GRIDS[name])
    on_terrain(tmp_path, "grid.asc", "dem")
    withstood("check", "scene.toml", code=(0, 2) if name in HARMLESS else 2)


RING = [[2, 2], [8, 2], [8, 8], [2, 8], [2, 2]]


def feature(coordinates, kind="Polygon", **properties):
    return json.dumps({"type": "Feature", "properties": properties, "geometry": {"type": kind,
                                                                                  "coordinates": coordinates}})


POLYGONS = {
    "nested": NESTED, "nested_object": '{"a":' * 50_000, "list": "[]", "null": "null", "number": "1", "empty": "",
    "no_features": '{"type": "FeatureCollection"}', "features_text": '{"type": "FeatureCollection", "features": "x"}',
    "features_null": '{"type": "FeatureCollection", "features": [null]}', "type_list": '{"type": []}',
    "digits": feature([RING]).replace("8", "9" * 5000, 1), "nan": feature([RING]).replace("8", "NaN"),
    "infinite": feature([RING]).replace("8", "Infinity"), "huge": feature([[[1e300 * x, 1e300 * y] for x, y in RING]]),
    "one_point": feature([[[0, 0]] * 50]), "line": feature([[[0, 0], [5, 5], [9, 9], [0, 0]]]), "no_rings": feature([]),
    "ring_of_text": feature([["x"]]), "coordinates_deep": feature([[[[RING]]]]), "coordinates_null": feature(None),
    "kind_curve": feature([RING], "CurvePolygon"), "point": feature([1, 1], "Point"), "bom": "\ufeff" + feature([RING]),
    "collection": '{"type": "GeometryCollection", "geometries": []}', "binary": b"\xff\xfe" * 500,
    "many_features": '{"type": "FeatureCollection", "features": [' + ",".join(["null"] * 200_000) + "]}",
    "outside": feature([[[x + 1000, y] for x, y in RING]]), "thickness_text": feature([RING], thickness="\x1b[2J"),
    "crs": feature([RING]).replace("{", '{"crs": {"type": "name", "properties": {"name": "\\u001b[2J"}}, ', 1),
    "crs_long": feature([RING]).replace("{", '{"crs": {"type": "name", "properties": {"name": "' + LONG + '"}}, ', 1),
    "crs_file": feature([RING]).replace("{", '{"crs": {"type": "link", "properties": {"href": "file:///etc/x"}}, ', 1),
}


@pytest.mark.parametrize("name", POLYGONS)
def test_geojson(withstood, tmp_path, name):
    written(tmp_path / "release.geojson", POLYGONS[name])
    on_region(tmp_path, "release.geojson")
    accepted = ("bom", "thickness_text", "crs", "crs_long", "crs_file")
    withstood("check", "scene.toml", code=(0, 2) if name in accepted else 2)


@pytest.fixture(scope="session")
def shapes(tmp_path_factory):
    shapefile = pytest.importorskip("shapefile")
    folder = tmp_path_factory.mktemp("shapes")
    with shapefile.Writer(str(folder / "release")) as writer:
        writer.field("thickness", "N", decimal=2)
        writer.poly([RING[::-1]])
        writer.record(2.0)
    return {path.suffix: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(("ending", "at", "value"), [
    *(("shp", at, value) for at in (0, 24, 28, 32, 36, 100, 104, 108, 144, 148, 152)
      for value in (b"\xff\xff\xff\x7f", b"\x7f\xff\xff\xff")),
    *(("shx", at, b"\x7f\xff\xff\xff") for at in (0, 24, 100, 104)),
    *(("dbf", at, value) for at in (0, 4, 8, 10, 43, 48) for value in (b"\xff\xff\xff\x7f", b"\0\0\0\0")),
])
def test_shapefile(withstood, tmp_path, shapes, ending, at, value):
    """Counts and lengths in the headers that are not those of what follows."""
    for suffix, content in shapes.items():
        if suffix == f".{ending}":
            content = content[:at] + value + content[at + 4:]
        written(tmp_path / f"release{suffix}", content)
    on_region(tmp_path, "release.shp")
    withstood("check", "scene.toml")


def npy(shape, descr="|u1", body=b"\1" * 64, version=(1, 0)):
    head = shape
    if isinstance(shape, tuple):
        head = repr({"descr": descr, "fortran_order": False, "shape": shape}).encode()
    length = struct.pack("<H" if version == (1, 0) else "<I", len(head) + 1)
    return b"\x93NUMPY" + bytes(version) + length + head + b"\n" + body


def npz(*members, compression=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return file.getvalue()


IMAGES = {
    "declared.npy": npy((100_000, 100_000, 100_000)), "below.npy": npy((-1, 8, 8)), "empty.npy": npy((0, 8, 8)),
    "scalar.npy": npy(()), "flat.npy": npy((64,)), "axes.npy": npy((1,) * 60), "object.npy": npy((4, 4, 4), "|O"),
    "fields.npy": npy((4, 4, 4), [("a", "<f8"), ("b", "|O")]), "head.npy": npy(b"{'descr': __import__('os')}"),
    "deep.npy": npy(b"(" * 5000), "long_head.npy": npy(b" " * 60_000), "version.npy": npy((4, 4, 4), version=(9, 9)),
    "text.npy": npy((4, 4, 4), "<U1000"), "nothing.npy": b"", "nan.npy": npy((4, 4, 4), "<f8", b"\xff" * 512),
    "bomb.npz": lambda: npz(("arr.npy", npy((1024, 1024, 512), body=b"\0" * (1 << 29)))), "nothing.npz": npz(),
    "bytes.npz": b"PK",
    "declared.npz": npz(("arr.npy", npy((100_000, 100_000, 100_000)))), "text.npz": npz(("readme", b"hello")),
    "path.npz": npz(("../../arr.npy", npy((8, 8), body=b"\1" * 64))),
    "many.npz": lambda: npz(*((f"{i}", b"") for i in range(20_000))),
    "short.raw": b"\1" * 10, "nothing.tif": b"", "words.tif": b"II*\0" + b"\xff" * 500, "vrt.tif": b"<VRTDataset/>",
    "loop.tif": b"II*\0\x08\0\0\0\0\0\x08\0\0\0", "png.tif": b"\x89PNG\r\n\x1a\n" + b"\0" * 100,
    "eps.tif": b"%!PS-Adobe-3.0 EPSF-3.0\n",
}


@pytest.mark.parametrize("name", IMAGES)
def test_image(withstood, tmp_path, name):
    written(tmp_path / name, IMAGES[name])
    of_voxels(tmp_path, name)
    withstood("check", "scene.toml", code=2)


GEOTIFFS = ["nothing", "vrt", "vrt_network", "loop", "words", "pipe_name"]


@pytest.mark.parametrize("kind", GEOTIFFS)
def test_geotiff(withstood, tmp_path, kind):
    pytest.importorskip("rasterio")
    (tmp_path / "secret.asc").write_text(GRID)
    vrt = ('<VRTDataset rasterXSize="12" rasterYSize="12"><GeoTransform>0,1,0,12,0,-1</GeoTransform><VRTRasterBand'
           ' dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="0">{}</SourceFilename>'
           '<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>')
    content = {"nothing": b"", "vrt": vrt.format(tmp_path / "secret.asc"), "words": b"II*\0" + b"\xff" * 500,
               "vrt_network": vrt.format("/vsicurl/http://127.0.0.1:9/x.tif"), "pipe_name": b"x",
               "loop": b"II*\0\x08\0\0\0\0\0\x08\0\0\0"}[kind]
    written(tmp_path / "ground.tif", content)
    on_terrain(tmp_path, "ground.tif" if kind != "pipe_name" else "/vsicurl/http://127.0.0.1:9/x.tif", "dem")
    withstood("check", "scene.toml", code=2)


def test_geotiff_of_terabytes(withstood, tmp_path):
    """A few kilobytes that declare a raster of 10^6 by 10^6 cells."""
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(tmp_path / "ground.tif", "w", driver="GTiff", width=300_000, height=300_000, count=1,
                       dtype="float32", tiled=True, sparse_ok=True, bigtiff=True,
                       transform=rasterio.transform.from_origin(0, 12, 1, 1)):
        pass
    on_terrain(tmp_path, "ground.tif", "dem")
    withstood("new", "own", "--terrain", "ground.tif", code=2)
    withstood("check", "scene.toml", code=(0, 2))
