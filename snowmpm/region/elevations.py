"""Windows of an elevation raster of any size: only what is asked for is read."""

import contextlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.io.geotiff import NO_DATA, require_rasterio
from snowmpm.terrain import geotiff
from snowmpm.terrain.raster import read_raster

CACHE = 64 << 20
"""Bytes of blocks that GDAL keeps."""
LOWEST, HIGHEST = -500.0, 9000.0
"""Elevations [m] beyond which a number stands for none."""
BLOCK = 512


@dataclass(frozen=True)
class Grid:
    """Cells of a raster, rows from the north: west, north [m] of its corner; cell [m]; system: `ReferenceSystem` or
    None."""

    west: float
    north: float
    cell: float
    rows: int
    columns: int
    system: Any = None

    @property
    def bounds(self):
        """west, south, east, north [m]."""
        return (self.west, self.north - self.rows * self.cell, self.west + self.columns * self.cell, self.north)

    def rows_of(self, south, north):
        """First and last + 1 row that hold y from south to north [m]."""
        return (int(np.floor((self.north - north) / self.cell + 1e-9)),
                int(np.ceil((self.north - south) / self.cell - 1e-9)))

    def columns_of(self, west, east):
        """First and last + 1 column that hold x from west to east [m]."""
        return (int(np.floor((west - self.west) / self.cell + 1e-9)),
                int(np.ceil((east - self.west) / self.cell - 1e-9)))

    def transform(self, row=0, column=0):
        """Affine transform of rasterio of a window that begins at a cell."""
        from rasterio.transform import from_origin

        return from_origin(self.west + column * self.cell, self.north - row * self.cell, self.cell, self.cell)


def lattice(grid, cell):
    """`Grid` of cells of a side [m], on the lines that the maps of all runs have, which covers a raster."""
    west, south, east, north = grid.bounds
    lines = [grid.cell * (round(side / grid.cell, 6) % 1.0) for side in (west, south)]
    first = [line + cell * math.floor((side - line) / cell + 1e-6)
             for line, side in zip(lines, (west, south), strict=True)]
    columns, rows = (math.ceil((end - start) / cell - 1e-6) for start, end in zip(first, (east, north), strict=True))
    return Grid(first[0], first[1] + rows * cell, cell, rows, columns, grid.system)


class Elevations:
    """An open elevation raster. grid: `Grid`; path."""

    def __init__(self, path, source, grid):
        self.path, self._source, self.grid = Path(path), source, grid

    def read(self, rows, columns):
        """Heights [m] (rows, columns) of cells first to last + 1, also beyond the raster; NaN where there are none."""
        from rasterio.windows import Window

        found = np.full((rows[1] - rows[0], columns[1] - columns[0]), np.nan)
        first = max(rows[0], 0), max(columns[0], 0)
        last = min(rows[1], self.grid.rows), min(columns[1], self.grid.columns)
        if first[0] >= last[0] or first[1] >= last[1]:
            return found
        window = Window.from_slices((first[0], last[0]), (first[1], last[1]))
        try:
            z = self._source.read(1, window=window, masked=True).astype(float).filled(np.nan)
        except Exception as error:  # of rasterio, which has several families of them
            raise InputError(f"{self.path}: rows {first[0]} to {last[0]} cannot be read: the file is damaged"
                             ) from error
        for none in geotiff.ends(self._source) if self._source.nodata is None else ():
            z[z == none] = np.nan
        z = z * self._source.scales[0] + self._source.offsets[0]
        z[~(z > LOWEST) | ~(z < HIGHEST)] = np.nan
        found[first[0] - rows[0] : last[0] - rows[0], first[1] - columns[0] : last[1] - columns[0]] = z
        return found


@contextlib.contextmanager
def open_elevations(path, key="terrain"):
    """Context: `Elevations` of a GeoTIFF. Raises InputError for what is no elevation raster in metres, north up, with
    square cells."""
    rasterio = require_rasterio()
    path = Path(path)
    with rasterio.Env(GDAL_CACHEMAX=CACHE), geotiff.opened(path, key) as source:
        yield Elevations(path, source, grid_of(source, path, key))


def grid_of(source, path, key):
    """`Grid` of an open raster; InputError."""
    t = source.transform
    if t.is_identity or not np.isfinite(t[:6]).all() or t.b or t.d or t.a <= 0.0 or t.e >= 0.0:
        raise InputError.at(key, str(path), "must be north up and have a place on the map: gdalwarp makes it so")
    if abs(t.a + t.e) > 1e-6 * t.a:
        raise InputError.at(key, str(path), f"has cells of {t.a:g} by {-t.e:g} m: must be square")
    if np.dtype(source.dtypes[0]).kind not in "iuf":
        raise InputError.at(key, str(path), f"holds {source.dtypes[0]} values: must be real numbers")
    system = geotiff.system_of(source, f"{key} = {str(path)!r}")
    if system is not None and (system.is_geographic or system.metre != 1.0):
        raise InputError.at(key, str(path), f"is in {system.unit} ({system.name}): must be in metres: gdalwarp -t_srs")
    if system is None and abs(t.c) <= 360.0 and abs(t.f) <= 90.0 and t.a < 0.1:
        raise InputError.at(key, str(path), "names no coordinate system and looks like degrees: must be in metres")
    return Grid(float(t.c), float(t.f), float(t.a), source.height, source.width, system)


def as_geotiff(path, scratch, key="terrain"):
    """Path of a GeoTIFF with the same elevations: the file itself, or one in the folder `scratch` made of an .asc."""
    path = Path(path)
    if not path.is_file():
        raise InputError.at(key, str(path), "no such file")
    if path.suffix.lower() != ".asc":
        return path
    raster = read_raster(path, key=key)
    lattice = raster.lattice()
    if lattice is None:
        raise InputError.at(key, str(path), "must have square cells")
    (west, south), cell = lattice
    made = Path(scratch) / f"{path.stem}.tif"
    write_blocks(made, Grid(west, south + len(raster.y) * cell, cell, *raster.z.shape, raster.system),
                 [((0, len(raster.y)), (0, len(raster.x)), raster.z[::-1])])
    return made


def write_blocks(path, grid, blocks, description="", unit="", overviews=False):
    """Write a tiled GeoTIFF from parts: blocks yields (rows, columns, values), NaN for none; rows and columns are first
    and last + 1. Cells of no part hold no data. overviews: whether it gets coarser levels, for programs that draw it.
    """
    rasterio = require_rasterio()
    from rasterio.windows import Window

    with draft(path) as part:
        with (rasterio.Env(GDAL_CACHEMAX=CACHE),
              rasterio.open(part, "w", **profile_of(grid)) as file):
            for rows, columns, values in blocks:
                filled = np.where(np.isfinite(values), values, NO_DATA).astype(np.float32)
                file.write(filled, 1, window=Window.from_slices(rows, columns))
            file.set_band_description(1, description)
            file.units = (unit,)
        if overviews:
            _add_overviews(part)
        with rasterio.open(part) as file:
            file.read(1, window=Window(0, 0, 1, 1))  # GDAL writes on closing, and does not report a failure
    return Path(path)


def _add_overviews(path):
    """Add coarser levels to a GeoTIFF."""
    import rasterio
    from rasterio.enums import Resampling

    with rasterio.Env(GDAL_CACHEMAX=CACHE, COMPRESS_OVERVIEW="DEFLATE"), rasterio.open(path, "r+") as file:
        levels = [2**k for k in range(1, 12) if max(file.shape) >= 256 * 2**k]
        if levels:
            file.build_overviews(levels, Resampling.average)


def profile_of(grid, dtype="float32"):
    """Profile of rasterio of a tiled GeoTIFF."""
    found = {"driver": "GTiff", "width": grid.columns, "height": grid.rows, "count": 1, "dtype": dtype,
             "nodata": NO_DATA if dtype == "float32" else 0, "transform": grid.transform(), "compress": "deflate",
             "tiled": True, "blockxsize": BLOCK, "blockysize": BLOCK, "sparse_ok": True, "BIGTIFF": "IF_SAFER"}
    if grid.system is not None:
        found["crs"] = grid.system.wkt
    return found
