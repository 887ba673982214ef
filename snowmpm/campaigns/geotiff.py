"""Maps of a campaign as GeoTIFF: one file a layer."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io import Map
from snowmpm.io.geotiff import require_rasterio, write_geotiff
from snowmpm.stages import counted


def layers(maps):
    """(file name, words, unit, values (rows, columns)) of each layer of `Campaign.maps`."""
    for name, data in maps.data_vars.items():
        unit, inner = data.attrs.get("units", "1"), [dim for dim in data.dims if dim not in ("y", "x")]
        if not inner:
            yield name, name, unit, data.values
            continue
        for k, at in enumerate(maps[inner[0]].values):
            of = maps[inner[0]].attrs.get("units", "")
            words = f"{name.replace('_', ' ')} {at:g} {of}".strip()
            yield f"{name}_{at:g}", words, unit, data.values[k]


def write_geotiffs(campaign, folder):
    """Write all layers of a `Campaign`; yields their paths. Raises InputError without maps or without rasterio."""
    require_rasterio()
    maps = campaign.maps
    if maps is None:
        raise InputError(f"{campaign.folder}: no maps: they are made of runs in three dimensions, when they are done")
    crs = campaign.example.provenance.get("crs") if campaign.example else None
    tags = {name: maps.attrs[name] for name in ("campaign", "scene", "design", "runs", "meaning", "confidence")}
    x, y, cell = float(maps.x[0]), float(maps.y[0]), float(maps.attrs["cell"])
    for name, words, unit, values in counted(list(layers(maps)), "writing GeoTIFFs", "layers"):
        raster = Map(np.asarray(values, np.float32), x, y, cell, unit)
        yield write_geotiff(folder / f"{name}.tif", raster, (0.0, 0.0, 0.0), crs, words, tags)
