"""Maps of a run as GeoTIFF, for a geographic information system. Needs rasterio, from the `gis` extra."""

import contextlib

import numpy as np

from snowmpm.draft import draft
from snowmpm.errors import InputError

NO_DATA = -9999.0


def require_rasterio():
    """The package that writes GeoTIFF. Raises InputError, with the command to install it."""
    try:
        import rasterio
        import rasterio.crs
        import rasterio.transform
    except ImportError:
        raise InputError("GeoTIFF needs the gis extra: pip install 'snowmpm[gis]'; --files pictures goes"
                         " without") from None
    return rasterio


def write_geotiff(path, raster, origin, crs=None, description="", tags=None):
    """Write a `Map` as float32, north up, with -9999 for no data; the file appears complete or not at all.

    origin: map coordinates of the run's origin [m]; crs: projection as well-known text, or None: then the file
    names no coordinate system; tags: texts by name, kept in the file. Raises InputError without rasterio
    or for an invalid projection.
    """
    rasterio = require_rasterio()
    rows, columns = raster.values.shape
    # Without the round-off of the origin, so that common cells of two files have the same corners
    west = round(float(origin[0] + raster.x0 - 0.5 * raster.cell), 6)
    north = round(float(origin[1] + raster.y0 + (rows - 0.5) * raster.cell), 6)
    profile = {"driver": "GTiff", "width": columns, "height": rows, "count": 1, "dtype": "float32", "nodata": NO_DATA,
               "transform": rasterio.transform.from_origin(west, north, raster.cell, raster.cell),
               "compress": "deflate"}
    values = np.where(np.isfinite(raster.values), raster.values, NO_DATA)[::-1].astype(np.float32)
    try:
        if crs:
            profile["crs"] = rasterio.crs.CRS.from_wkt(crs)
    except rasterio.errors.CRSError as error:
        raise InputError(f"{path}: cannot be written ({error})") from None
    with draft(path) as part, _as_os_error(rasterio.errors.RasterioError):
        with rasterio.open(part, "w", **profile) as file:
            file.write(values, 1)
            file.set_band_description(1, description)
            file.update_tags(**{name: str(value) for name, value in (tags or {}).items()})
            file.units = (raster.units,)
        # GDAL writes on closing, and does not report a failure
        with rasterio.open(part) as file:
            if not np.array_equal(file.read(1), values):
                raise OSError("is not whole")
    return path


@contextlib.contextmanager
def _as_os_error(kind):
    try:
        yield
    except kind as error:
        raise OSError(str(error)) from error
