"""Outlines of the classes of intensity of each scenario, as polygons: intensity.gpkg."""

import warnings
from pathlib import Path

import numpy as np
import shapely

from snowmpm.gis.layers import Layer
from snowmpm.gis.vectors import write_geopackage
from snowmpm.region.elevations import CACHE
from snowmpm.stages import counted

FILE = "intensity.gpkg"


def write(setting, folder):
    """Write the outlines; -> the path, None where nothing is reached."""
    layers = [Layer(f"intensity_{name}", "MultiPolygon", features)
              for name in counted(list(setting.file.scenarios), "outlining classes", "scenarios")
              if (features := list(_features(setting, name, Path(folder) / f"intensity_{name}.tif")))]
    return write_geopackage(Path(folder) / FILE, layers, setting.wkt) if layers else None


def class_names(pressures):
    """{class: (words, from, to) [kPa]} of classes of intensity, 1 for what is reached below the first pressure."""
    bounds = [0.0, *(p / 1e3 for p in pressures)]
    found = {}
    for k, low in enumerate(bounds):
        high = bounds[k + 1] if k + 1 < len(bounds) else None
        to = "and above" if high is None else f"to {high:g} kPa"
        words = f"{low:g} kPa {to}" if high is None else f"{low:g} {to}"
        found[k + 1] = words if low else f"below {high:g} kPa", low, high
    return found


def _features(setting, name, path):
    """(multipolygon, fields) of each class: GDAL goes through the raster line by line."""
    import rasterio
    from rasterio import features

    names, parts = class_names(setting.file.pressures), {}
    with warnings.catch_warnings(), rasterio.Env(GDAL_CACHEMAX=CACHE), rasterio.open(path) as file:
        warnings.simplefilter("ignore", DeprecationWarning)
        for shape, value in features.shapes(rasterio.band(file, 1), connectivity=4, transform=file.transform):
            if value:
                parts.setdefault(int(value), []).append(shapely.transform(
                    shapely.geometry.shape(shape), lambda at: np.round(at, 3)))
    for value, polygons in sorted(parts.items()):
        words, low, high = names[value]
        whole = shapely.MultiPolygon(polygons)
        yield whole, {"scenario": name, "period": setting.file.scenarios[name].period, "class": value,
                      "pressure": words, "from_kpa": low, "to_kpa": high, "area_m2": round(whole.area, 1)}
