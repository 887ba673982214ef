"""Rasters that are not what their names or headers say: refused in one line, in little time and memory."""

import struct
import subprocess
import sys
import time

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget
from snowmpm.terrain import load_terrain
from snowmpm.terrain.raster import read_raster
from tests.support.tables import Table as Spec

VRT = """<VRTDataset rasterXSize="4" rasterYSize="4">
<SRS>EPSG:32632</SRS><GeoTransform>600000, 5, 0, 5200000, 0, -5</GeoTransform>
<VRTRasterBand dataType="Float64" band="1"><SimpleSource><SourceFilename relativeToVRT="0">{}</SourceFilename>
<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"""


@pytest.fixture(autouse=True)
def _small_budget(monkeypatch):
    monkeypatch.setenv(read_budget.VARIABLE, "1")


def good_tif(path, **options):
    rasterio = pytest.importorskip("rasterio")
    z = np.add.outer(np.arange(4.0), np.zeros(4))
    profile = {"driver": "GTiff", "width": 4, "height": 4, "count": 1, "dtype": "float64", "crs": "EPSG:32632",
               "transform": rasterio.Affine(5, 0, 6e5, 0, -5, 5.2e6), **options}
    with rasterio.open(path, "w", **profile) as target:
        target.write(z, 1)
    return path


def refused(path, words):
    start = time.process_time()
    with pytest.raises(InputError, match=words) as caught:
        read_raster(path)
    assert path.name in str(caught.value) and len(str(caught.value).splitlines()) == 1
    assert time.process_time() - start < 10.0
    return str(caught.value)


@pytest.mark.parametrize("source", ["secret.tif", "http://127.0.0.1:9/secret.tif", "/vsicurl/http://127.0.0.1:9/a.tif"])
@pytest.mark.parametrize("suffix", [".tif", ".tiff", ".asc"])
def test_a_vrt_by_another_name_reads_nothing_else(tmp_path, source, suffix):
    good_tif(tmp_path / "secret.tif")
    path = tmp_path / f"dem{suffix}"
    path.write_text(VRT.format(tmp_path / source if source == "secret.tif" else source))
    refused(path, "is not a readable GeoTIFF|is not an ESRI ASCII grid")


def test_a_mask_beside_the_raster_is_no_vrt_either(tmp_path):
    path = good_tif(tmp_path / "dem.tif")
    read_raster(path)
    (tmp_path / "dem.tif.msk").write_text(VRT.format("http://127.0.0.1:9/secret.tif"))
    refused(path, "a mask dem.tif.msk beside it that is no TIFF")


@pytest.mark.parametrize("driver", ["PNG", "JPEG"])
def test_other_formats_by_the_name_of_a_tif(tmp_path, driver):
    rasterio = pytest.importorskip("rasterio")
    with rasterio.MemoryFile() as memory:
        good_tif(tmp_path / "dem.tif", dtype="uint8", crs=None)
        with rasterio.open(tmp_path / "dem.tif") as source, memory.open(
                driver=driver, width=4, height=4, count=1, dtype="uint8") as target:
            target.write(source.read())
        (tmp_path / "dem.tif").write_bytes(memory.read())
    refused(tmp_path / "dem.tif", "is not a readable GeoTIFF")


@pytest.mark.parametrize("name", ["http:/127.0.0.1:9/dem.tif", "zip://dem.tif", "/vsicurl/http://127.0.0.1:9/dem.tif",
                                  "GTIFF_DIR:1:dem.tif", "dem.tif\0.tif", "s3://bucket/dem.tif"])
def test_a_name_that_is_an_address_is_a_missing_file(tmp_path, name):
    with pytest.raises(InputError, match="no such file"):
        load_terrain(Spec(kind="dem", file=name), tmp_path)


def test_a_sparse_raster_of_kilobytes_is_refused_by_its_header(tmp_path):
    path = _sparse(tmp_path / "dem.tif")
    assert path.stat().st_size < 200_000
    message = refused(path, r"100000 x 100000 cells need 559 GiB of memory, and 1 GiB are allowed for a file")
    assert "terrain.region or domain cut it" in message
    # A part of it is read, in memory for that part
    box = (np.array([600_100.0, 4_900_000.0]), np.array([600_200.0, 4_900_100.0]))
    with pytest.raises(InputError, match="has no elevation in the part"):
        read_raster(path, box)


def _sparse(path):
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(path, "w", driver="GTiff", width=100_000, height=100_000, count=1, dtype="float32", tiled=True,
                       blockxsize=1024, blockysize=1024, SPARSE_OK=True, BIGTIFF="YES", nodata=-9999.0,
                       crs="EPSG:32632", transform=rasterio.Affine(5, 0, 6e5, 0, -5, 5.2e6)):
        pass
    return path


def test_one_huge_block_counts_though_a_small_part_is_wanted(tmp_path):
    """A block is unpacked whole: a strip of 20 000 rows for a window of a few cells."""
    rasterio = pytest.importorskip("rasterio")
    path = tmp_path / "dem.tif"
    with rasterio.open(path, "w", driver="GTiff", width=20_000, height=20_000, count=1, dtype="float32", tiled=True,
                       blockxsize=20_000 // 16 * 16, blockysize=20_000 // 16 * 16, SPARSE_OK=True, nodata=-9999.0,
                       crs="EPSG:32632", transform=rasterio.Affine(5, 0, 6e5, 0, -5, 5.2e6)):
        pass
    box = (np.array([600_100.0, 5_190_000.0]), np.array([600_200.0, 5_190_100.0]))
    with pytest.raises(InputError, match="of memory, and 1 GiB are allowed"):
        read_raster(path, box)


def test_pages_of_a_tiff_are_not_read(tmp_path):
    """The first page is the raster; others, however large, cost nothing."""
    path = good_tif(tmp_path / "dem.tif")
    rasterio = pytest.importorskip("rasterio")
    for _ in range(3):
        with rasterio.open(path, "w", driver="GTiff", width=60_000, height=60_000, count=1, dtype="float32", tiled=True,
                           blockxsize=4096, blockysize=4096, SPARSE_OK=True, APPEND_SUBDATASET="YES"):
            pass
    with pytest.warns(UserWarning, match="the first of its 4 pages"):
        np.testing.assert_array_equal(read_raster(path).z[:, 0], [3.0, 2.0, 1.0, 0.0])


def tiff(entries):
    """Bytes of a little TIFF whose first directory has these entries (tag, type, count, value)."""
    body = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *entry) for entry in entries)
    return b"II*\0" + struct.pack("<I", 8) + body + struct.pack("<I", 0) + b"\0" * 64


HEAD = [(258, 3, 1, 32), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 150), (277, 3, 1, 1), (279, 4, 1, 16)]


@pytest.mark.parametrize("entries", [
    [(256, 4, 1, 2**31 - 1), (257, 4, 1, 2**31 - 1), *HEAD], [(256, 4, 1, 0), (257, 4, 1, 0), *HEAD],
    [(256, 4, 1, 2**32 - 1), (257, 4, 1, 1), *HEAD], [(256, 4, 1, 4), *HEAD], [],
    [(256, 4, 1, 4), (257, 4, 1, 4), (273, 4, 2**31, 8), *HEAD[:3]]])
def test_tiff_headers_that_lie(tmp_path, entries):
    pytest.importorskip("rasterio")
    path = tmp_path / "dem.tif"
    path.write_bytes(tiff(entries))
    refused(path, "GeoTIFF|no place on the map|of memory")


def test_a_tiff_whose_directories_run_in_a_circle(tmp_path):
    pytest.importorskip("rasterio")
    data = bytearray(tiff([(256, 4, 1, 4), (257, 4, 1, 4), *HEAD]))
    end = 8 + 2 + 12 * (2 + len(HEAD))
    data[end : end + 4] = struct.pack("<I", 8)
    path = tmp_path / "dem.tif"
    path.write_bytes(data)
    refused(path, "GeoTIFF|no place on the map")


def asc(path, **header):
    lines = {"ncols": "2", "nrows": "2", "xllcorner": "0", "yllcorner": "0", "cellsize": "5", **header}
    rows = "1 2\n3 4\n"
    path.write_text("\n".join(f"{key} {value}" for key, value in lines.items() if value is not None) + "\n" + rows)
    return path


@pytest.mark.parametrize(("key", "value"), [
    *((key, value) for key in ("ncols", "nrows") for value in
      ("nan", "inf", "-inf", "0", "-2", "2.5", "1e9", "1e300", "1e-300", "9" * 5000, "99999999999999999999", "0x2")),
    *((key, value) for key in ("cellsize", "dx", "dy") for value in ("nan", "inf", "0", "-5", "9" * 5000)),
    *((key, value) for key in ("xllcorner", "yllcorner", "xllcenter") for value in ("nan", "inf", "1e400")),
    ("ncols", None), ("cellsize", None), ("ncols", ""), ("ncols", "\t"), ("cellsize", "five")])
def test_headers_of_ascii_grids_that_lie(tmp_path, key, value):
    with np.errstate(all="ignore"):
        message = refused(asc(tmp_path / "dem.asc", **{key: value}), "header|needs one number|too short|holds")
    assert len(message) < 400


@pytest.mark.parametrize("value", ["nan", "inf", "-9999", "9" * 5000])
def test_any_no_data_value_is_a_value(tmp_path, value):
    assert np.isfinite(read_raster(asc(tmp_path / "dem.asc", nodata_value=value)).z).all()


def test_a_file_of_terabytes_is_not_read(tmp_path):
    path = asc(tmp_path / "dem.asc")
    with open(path, "r+b") as file:
        file.truncate(10**12)  # sparse on the disk
    refused(path, r"its text need 2.79e\+03 GiB of memory, and 1 GiB are allowed")


def test_memory_stays_small(tmp_path):
    """What the program takes to refuse 100 000 x 100 000 cells, measured."""
    _sparse(tmp_path / "dem.tif")
    code = ("import resource, sys; from pathlib import Path; from snowmpm.terrain.raster import read_raster\n"
            "from snowmpm.errors import InputError\nimport rasterio\n"
            "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
            "try: read_raster(Path(sys.argv[1]))\nexcept InputError: pass\n"
            "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)")
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "dem.tif")], capture_output=True, text=True,
                          timeout=120, check=True)
    assert int(done.stdout) < 100_000  # kB
