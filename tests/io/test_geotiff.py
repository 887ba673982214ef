"""Maps as GeoTIFF: place, projection, no-data, and what is said without rasterio."""

import sys

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.io import Map
from snowmpm.io.geotiff import write_geotiff
from snowmpm.terrain.reference_system import reference_system

VALUES = np.arange(12.0).reshape(3, 4)
ORIGIN = np.array([247000.0, 352000.0, 1200.0])


def test_place_and_values(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    values = VALUES.copy()
    values[0, 0] = np.nan
    crs = rasterio.crs.CRS.from_epsg(31287).to_wkt()
    path = write_geotiff(tmp_path / "depth.tif", Map(values, 5.0, 15.0, 10.0, "m"), ORIGIN, crs, "peak depth [m]")
    with rasterio.open(path) as file:
        assert file.crs.to_epsg() == 31287 and file.descriptions == ("peak depth [m]",) and file.units == ("m",)
        assert file.transform.a == 10.0 and file.bounds.left == 247000.0 and file.bounds.bottom == 352010.0
        # Row 1, column 2 of the map: its centre is at x0 + 2 cells, y0 + 1 cell
        (sample,) = file.sample([(247025.0, 352025.0)])
        assert sample == values[1, 2]
        band = file.read(1, masked=True)
        assert band.mask.sum() == 1 and band.mask[2, 0]
    assert [entry.name for entry in tmp_path.iterdir()] == ["depth.tif"]
    assert reference_system([path]) == crs or "31287" in reference_system([path])


def test_no_projection_is_none(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    path = write_geotiff(tmp_path / "a.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN)
    with rasterio.open(path) as file:
        assert file.crs is None
    assert reference_system([path]) is None
    with pytest.raises(InputError, match="cannot be written"):
        write_geotiff(tmp_path / "b.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN, "PROJCS[nonsense")


def test_projection_beside_the_file(tmp_path):
    (tmp_path / "dem.asc").write_text("")
    assert reference_system([tmp_path / "dem.asc"]) is None
    (tmp_path / "release.prj").write_text('PROJCS["x"]\n')
    assert reference_system([tmp_path / "dem.asc", tmp_path / "release.shp"]) == 'PROJCS["x"]'


def test_without_rasterio(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(InputError, match=r"gis extra: pip install 'snowmpm\[gis\]'"):
        write_geotiff(tmp_path / "a.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN)
