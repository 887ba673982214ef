"""The EPSG code of a projection, also where its text went through a .prj file and lost details of its datum."""

import pyproj
import pytest

from snowmpm.io.projection import epsg_of, projection_name

rasterio = pytest.importorskip("rasterio")
CODES = (2056, 2154, 2193, 3006, 3035, 5514, 25832, 31254, 31287, 31467, 32632)


@pytest.mark.parametrize("code", CODES)
def test_a_raster_beside_a_prj_file_has_its_code(code, tmp_path):
    (tmp_path / "slope.prj").write_text(pyproj.CRS.from_epsg(code).to_wkt("WKT1_ESRI"))
    (tmp_path / "slope.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2\n3 4\n")
    with rasterio.open(tmp_path / "slope.asc") as raster:
        wkt = raster.crs.to_wkt()
    assert epsg_of(wkt) == code and projection_name(wkt).endswith(f"(EPSG:{code})")


@pytest.mark.parametrize(("was", "now"), [('"false_easting",400000', '"false_easting",410000'),
                                          ('"central_meridian",13.3333333333333', '"central_meridian",13.4'),
                                          ("299.1528128", "299.3"), ('"Greenwich",0', '"Paris",2.33722917'),
                                          ('UNIT["metre",1', 'UNIT["foot",0.3048'),
                                          ('PROJCS["MGI / Austria Lambert"', 'PROJCS["Another"')])
def test_a_projection_of_other_numbers_is_not_that_of_the_name(was, now, tmp_path):
    (tmp_path / "slope.prj").write_text(pyproj.CRS.from_epsg(31287).to_wkt("WKT1_ESRI"))
    (tmp_path / "slope.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2\n3 4\n")
    with rasterio.open(tmp_path / "slope.asc") as raster:
        wkt = raster.crs.to_wkt()
    assert was in wkt
    assert epsg_of(wkt.replace(was, now)) is None
    assert epsg_of("no projection") is None and epsg_of(None) is None
