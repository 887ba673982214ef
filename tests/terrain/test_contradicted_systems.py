"""A coordinate system that the coordinates contradict is called wrong, and the advice works."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding.region_files import read_features
from snowmpm.terrain.raster import read_raster
from snowmpm.terrain.reference_system import ReferenceSystem

rasterio = pytest.importorskip("rasterio")

DEGREES, METRES = (11.2, 47.1, 1e-4), (-10800.0, 194700.0, 10.0)


def raster(path, place, system):
    """Heights of a slope as .tif, or as .asc with a .prj; place: its corner and cell."""
    x, y, cell = place
    z = np.add.outer(np.arange(20.0), np.zeros(20)) * 5.0 + 1000.0
    if path.suffix == ".tif":
        with rasterio.open(path, "w", driver="GTiff", width=20, height=20, count=1, dtype="float32", crs=system,
                           transform=rasterio.transform.from_origin(x, y + 20 * cell, cell, cell)) as target:
            target.write(z.astype("float32"), 1)
    else:
        path.write_text(f"ncols 20\nnrows 20\nxllcorner {x}\nyllcorner {y}\ncellsize {cell}\n"
                        + "\n".join(" ".join(f"{v:g}" for v in row) for row in z))
        path.with_suffix(".prj").write_text(rasterio.crs.CRS.from_string(system).to_wkt())
    return path


@pytest.mark.parametrize("name", ["dem.tif", "dem.asc"])
@pytest.mark.parametrize(("place", "system", "words"), [
    (METRES, "EPSG:4326", "is tagged WGS 84, but its coordinates, such as x = -10795, y = 194705, are no deg"),
    (DEGREES, "EPSG:31287", "is tagged MGI / Austria Lambert, but its coordinates, .*, look like deg"),
])
def test_a_raster_is_told_that_its_tag_is_wrong(tmp_path, name, place, system, words):
    with pytest.raises(InputError, match=words) as refused:
        read_raster(raster(tmp_path / name, place, system))
    assert "rio warp" not in str(refused.value)


def test_the_advice_is_accepted(tmp_path):
    path = raster(tmp_path / "dem.tif", (150000.0, 380000.0, 10.0), "EPSG:4326")
    with pytest.raises(InputError, match="rio edit-info --crs EPSG"):
        read_raster(path)
    rio = Path(sys.executable).with_name("rio")
    subprocess.run([rio, "edit-info", "--crs", "EPSG:31287", str(path)], check=True)
    assert read_raster(path).system.name == "MGI / Austria Lambert"


def test_degrees_are_still_projected_by_the_advice(tmp_path):
    with pytest.raises(InputError, match=r"is in degrees \(WGS 84\): project it to metres, as `rio warp"):
        read_raster(raster(tmp_path / "dem.tif", DEGREES, "EPSG:4326"))


@pytest.mark.parametrize(("system", "far"), [("EPSG:31287", True), ("EPSG:32632", False), ("EPSG:2056", True)])
def test_a_place_far_off_is_doubted(tmp_path, system, far):
    """A place at 11 degrees east, 47 north, in metres of UTM zone 32."""
    path = raster(tmp_path / "dem.tif", (650000.0, 5.22e6, 10.0), system)
    if far:
        with pytest.raises(InputError, match=r"lies .* degrees outside the area of .*: the tag is wrong"):
            read_raster(path)
    else:
        assert ReferenceSystem.named(system, "").far_off(650000.0, 5.22e6) == 0.0
        read_raster(path)


def test_a_place_beside_its_area_is_doubted(tmp_path):
    """Old Swiss coordinates by the name of the new ones."""
    with pytest.warns(UserWarning, match=r"lies 19 degrees outside the area of CH1903\+ / LV95: is this system right"):
        read_raster(raster(tmp_path / "dem.tif", (700000.0, 190000.0, 10.0), "EPSG:2056"))


@pytest.mark.parametrize(("place", "crs", "words"), [
    (METRES, "urn:ogc:def:crs:OGC::CRS84", "are no degrees: the tag is wrong"),
    (DEGREES, "urn:ogc:def:crs:EPSG::31287", "look like degrees: the tag is wrong")])
@pytest.mark.parametrize("kind", ["geojson", "shp"])
def test_a_vector_file_is_told(tmp_path, kind, place, crs, words):
    x, y, cell = place
    ring = [[x, y], [x + 9 * cell, y], [x + 9 * cell, y + 9 * cell], [x, y]]
    path = tmp_path / f"release.{kind}"
    if kind == "geojson":
        path.write_text(json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}},
                                    "features": [{"type": "Feature", "properties": {}, "geometry": {
                                        "type": "Polygon", "coordinates": [ring]}}]}))
    else:
        shapefile = pytest.importorskip("shapefile")
        with shapefile.Writer(str(path)) as writer:
            writer.field("thickness", "N", 8, 2)
            writer.poly([ring])
            writer.record(1.0)
        path.with_suffix(".prj").write_text(ReferenceSystem.named(crs, "").wkt)
    with pytest.raises(InputError, match=words):
        read_features(path, "file", ReferenceSystem.named("EPSG:31287", ""))
