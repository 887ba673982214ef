"""Forest over windows of an elevation raster: polygons, or a raster of crown cover, of any coordinate system."""

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.seeding.regions import read_regions
from snowmpm.terrain import geotiff

COVER = 50.0
"""Crown cover [%] from which trees keep slabs from releasing: chosen."""
POLYGONS = (".gpkg", ".geojson", ".shp")


@dataclass(frozen=True)
class Forest:
    """raster: an open dataset on the grid of the terrain, cover [%] from which it protects; or tree: of polygons."""

    raster: Any = None
    cover: float = COVER
    tree: Any = None

    def mask(self, grid, rows, columns):
        """Whether forest protects each cell of a window (first and last + 1 row, column), which may go beyond."""
        found = np.zeros((rows[1] - rows[0], columns[1] - columns[0]), bool)
        if self.tree is not None:
            import shapely
            from rasterio.features import geometry_mask

            box = shapely.box(grid.west + columns[0] * grid.cell, grid.north - rows[1] * grid.cell,
                              grid.west + columns[1] * grid.cell, grid.north - rows[0] * grid.cell)
            near = self.tree.geometries[self.tree.query(box)]
            if len(near):
                found = geometry_mask(near, found.shape, grid.transform(rows[0], columns[0]), invert=True)
            return found
        from rasterio.windows import Window

        first = max(rows[0], 0), max(columns[0], 0)
        last = min(rows[1], grid.rows), min(columns[1], grid.columns)
        if first[0] < last[0] and first[1] < last[1]:
            window = Window.from_slices((first[0], last[0]), (first[1], last[1]))
            cover = self.raster.read(1, window=window, masked=True)
            found[first[0] - rows[0] : last[0] - rows[0],
                  first[1] - columns[0] : last[1] - columns[0]] = cover.filled(0) >= self.cover
        return found


@contextlib.contextmanager
def open_forest(path, grid, cover=COVER, key="forest"):
    """Context: `Forest` of a file on the `Grid` of the terrain; None of none. Raises InputError for a file that cannot
    be used, or lies beside the terrain."""
    if path is None:
        yield None
        return
    path = Path(path)
    if path.suffix.lower() in POLYGONS:
        import shapely

        areas = np.array([one.polygons.geometry for one in read_regions(path, key, grid.system)], object)
        tree = shapely.STRtree(areas)
        if not len(tree.query(shapely.box(*grid.bounds))):
            raise InputError.at(key, str(path), "lies beside the terrain: is its coordinate system right?")
        yield Forest(tree=tree)
        return
    if path.suffix.lower() not in (".tif", ".tiff"):
        raise InputError.at(key, str(path), "must be polygons (.gpkg, .geojson, .shp), or a raster of crown cover"
                                            " (.tif)")
    import rasterio.warp
    from rasterio.vrt import WarpedVRT

    with geotiff.opened(path, key) as source:
        own = geotiff.system_of(source, f"{key} = {str(path)!r}")
        if (own is None) != (grid.system is None):
            raise InputError.at(key, str(path), "names no coordinate system, and the terrain does" if own is None else
                                f"is in {own.name}, and the terrain names no coordinate system")
        crs = source.crs if own is None else grid.system.wkt
        bounds = source.bounds if own is None else rasterio.warp.transform_bounds(source.crs, crs, *source.bounds)
        west, south, east, north = grid.bounds
        if bounds[0] >= east or bounds[2] <= west or bounds[1] >= north or bounds[3] <= south:
            raise InputError.at(key, str(path), "lies beside the terrain: is its coordinate system right?")
        named = {"src_crs": "EPSG:3857", "crs": "EPSG:3857"} if own is None else {"crs": crs}
        with WarpedVRT(source, transform=grid.transform(), width=grid.columns, height=grid.rows,
                       resampling=rasterio.warp.Resampling.nearest, **named) as raster:
            yield Forest(raster, cover)
