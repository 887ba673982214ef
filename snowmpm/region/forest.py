"""Forest over windows of an elevation raster: polygons, or a raster of crown cover, of any coordinate system."""

import contextlib
import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.region.polygons import polygons_of
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
            cover = self.raster.read(1, window=window, masked=True).astype(float).filled(0.0)
            cover = cover * self.raster.scales[0] + self.raster.offsets[0]
            found[first[0] - rows[0] : last[0] - rows[0],
                  first[1] - columns[0] : last[1] - columns[0]] = cover >= self.cover
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
        areas = np.array([one.geometry for one in polygons_of(path, key, grid.system)], object)
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
        fine = (bounds[2] - bounds[0]) / source.width < 0.7 * grid.cell
        how = rasterio.warp.Resampling.average if fine else rasterio.warp.Resampling.nearest
        named = {"src_crs": "EPSG:3857", "crs": "EPSG:3857"} if own is None else {"crs": crs}
        coarse = source.read(1, out_shape=tuple(min(n, 512) for n in source.shape), masked=True)
        largest = float(coarse.max()) * source.scales[0] + source.offsets[0] if coarse.count() else 0.0
        if cover > 1.0 and 0.0 < largest <= 1.0:
            raise InputError.at(key, str(path), f"has values up to {largest:g}, and trees protect from a"
                                                f" cover of {cover:g} on: is it in per cent? cover = 0.5 takes it as it"
                                                " is")
        with WarpedVRT(source, transform=grid.transform(), width=grid.columns, height=grid.rows,
                       resampling=how, **named) as raster:
            yield Forest(raster, cover)


@functools.lru_cache(maxsize=2)
def _tree_of(path, stamp, system):
    """The polygons of a file, kept for the next run of a worker. stamp: time of its last change."""
    return shapely.STRtree(np.array([one.geometry for one in polygons_of(Path(path), "forest", system)], object))


@contextlib.contextmanager
def open_forest_once(path, grid, cover):
    """As `open_forest`; polygons are read once in a process."""
    if Path(path).suffix.lower() in POLYGONS:
        yield Forest(tree=_tree_of(str(path), Path(path).stat().st_mtime_ns, grid.system))
        return
    with open_forest(path, grid, cover) as found:
        yield found
