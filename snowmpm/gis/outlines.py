"""Outlines of regions of a raster: polygons along the edges of cells, with exactly the area of the cells."""

import warnings

import numpy as np
import shapely

from snowmpm.io.geotiff import require_rasterio


def outline(mask, raster, origin):
    """MultiPolygon of the cells where `mask` (rows, columns) is true, in map coordinates [m]; holes are kept.

    raster: the `snowmpm.io.Map` that the mask belongs to; origin: of its run [m]. Cells that touch only at a corner
    are two polygons.
    """
    require_rasterio()
    from rasterio import features
    from rasterio.transform import Affine

    west, south = (origin[k] + (raster.x0, raster.y0)[k] - 0.5 * raster.cell for k in (0, 1))
    cells = np.asarray(mask, np.uint8)
    # First in integer cells, then in metres: corners of neighbours are bitwise equal
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # how rasterio itself uses its affine package
        warnings.simplefilter("ignore", DeprecationWarning)
        found = list(features.shapes(cells, cells > 0, connectivity=4, transform=Affine.identity()))
    parts = shapely.MultiPolygon([shapely.geometry.shape(geometry) for geometry, _ in found])
    places = shapely.transform(parts, lambda corners: np.round([west, south] + raster.cell * corners, 6))
    return shapely.orient_polygons(places) if hasattr(shapely, "orient_polygons") else shapely.normalize(places)


def affected(run):
    """Mask (rows, columns) of the affected area of a `Run`."""
    return np.nan_to_num(run.maps["peak_depth"].values) >= run.hazard["numbers"]["flow_depth"]
