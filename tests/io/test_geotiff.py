"""Maps as GeoTIFF: place, projection, no-data, and what is said without rasterio."""

import sys
from types import SimpleNamespace

import numpy as np
import pyproj
import pytest

from snowmpm.errors import InputError
from snowmpm.io import Map
from snowmpm.io.geotiff import write_geotiff
from snowmpm.running.recorder import map_origin
from snowmpm.terrain.raster import system_of
from snowmpm.terrain.reference_system import ReferenceSystem
from tests.support.tables import Table

VALUES = np.arange(12.0).reshape(3, 4)
ORIGIN = np.array([247000.0, 352000.0, 1200.0])


def test_place_and_values(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    values = VALUES.copy()
    values[0, 0] = np.nan
    crs = rasterio.crs.CRS.from_epsg(31287).to_wkt()
    path = write_geotiff(tmp_path / "depth.tif", Map(values, 5.0, 15.0, 10.0, "m"), ORIGIN, crs, "peak depth [m]",
                         {"final": False, "status": "NOT FINAL: still moving"})
    with rasterio.open(path) as file:
        assert file.crs.to_epsg() == 31287 and file.descriptions == ("peak depth [m]",) and file.units == ("m",)
        assert file.tags()["final"] == "False" and file.tags()["status"] == "NOT FINAL: still moving"
        assert file.transform.a == 10.0 and file.bounds.left == 247000.0 and file.bounds.bottom == 352010.0
        # Row 1, column 2 of the map: its centre is at x0 + 2 cells, y0 + 1 cell
        (sample,) = file.sample([(247025.0, 352025.0)])
        assert sample == values[1, 2]
        band = file.read(1, masked=True)
        assert band.mask.sum() == 1 and band.mask[2, 0]
    assert [entry.name for entry in tmp_path.iterdir()] == ["depth.tif"]
    assert system_of(path).name == ReferenceSystem.of_text(crs, "it").name


def test_no_projection_is_none(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    path = write_geotiff(tmp_path / "a.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN)
    with rasterio.open(path) as file:
        assert file.crs is None
    assert system_of(path) is None
    with pytest.raises(InputError, match="cannot be written"):
        write_geotiff(tmp_path / "b.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN, "PROJCS[nonsense")


def test_system_of_a_scene(tmp_path):
    """That of the terrain; of a terrain that names none, that of the first release file that does."""
    (tmp_path / "dem.asc").write_text("")
    (tmp_path / "release.shp").write_text("")
    layer = SimpleNamespace(shape=Table(region=Table(file="release.shp")))
    scene = SimpleNamespace(base_dir=tmp_path, terrain=Table(kind="dem", file="dem.asc"), bodies=[layer])
    assert map_origin(scene) == {"crs": None}
    (tmp_path / "release.prj").write_text(pyproj.CRS(31287).to_wkt("WKT1_ESRI"))
    assert "Austria Lambert" in map_origin(scene)["crs"]
    (tmp_path / "dem.prj").write_text(pyproj.CRS(32632).to_wkt("WKT1_ESRI"))
    assert "UTM zone 32N" in map_origin(scene)["crs"]
    (tmp_path / "dem.prj").write_text('PROJCS["x"]')
    with pytest.raises(InputError, match="names no coordinate system"):
        map_origin(scene)


def test_without_rasterio(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(InputError, match=r"gis extra: pip install 'snowmpm\[gis\]'"):
        write_geotiff(tmp_path / "a.tif", Map(VALUES, 0.0, 0.0, 1.0, "m"), ORIGIN)
