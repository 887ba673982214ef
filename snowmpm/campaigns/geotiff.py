"""Maps of a campaign as GeoTIFF: one file a layer."""

import numpy as np

from snowmpm.campaigns.probability import QUANTITIES, short
from snowmpm.errors import InputError
from snowmpm.gis import write_style, write_style_of_shares
from snowmpm.io import Map
from snowmpm.io.geotiff import require_rasterio, write_geotiff
from snowmpm.quantities.table import quantity
from snowmpm.render.probability_map import AGREEING, AGREEMENT, COLOURS, SHARES
from snowmpm.stages import counted

AGREED = "share of the runs that agree whether the flow gets there"


def layers(maps):
    """(file name, words, unit, values (rows, columns)) of each layer of `Campaign.maps`."""
    for name, data in maps.data_vars.items():
        unit, inner = data.attrs.get("units", "1"), [dim for dim in data.dims if dim not in ("y", "x")]
        if not inner:
            yield name, AGREED if name == "agreement" else name, unit, data.values
            continue
        for k, at in enumerate(maps[inner[0]].values):
            yield f"{name}_{at:g}", _words(name, at), unit, data.values[k]


def _words(name, at):
    """What a layer is: name as in `maps`, at: limit or quantile."""
    of, _, kind = name.partition("_")
    one = quantity(QUANTITIES[of][0])
    if kind == "quantile":
        return f"{at:g} quantile of the {one.heading}"
    end = {"probability_low": ", lower end of 95 %", "probability_high": ", upper end of 95 %"}.get(kind, "")
    return f"share of runs with a {one.label} of at least {short(at, one.unit)}{end}"


def write_geotiffs(campaign, folder):
    """Write all layers of a `Campaign`, with a QGIS style beside each; yields their paths. Raises InputError without
    maps or without rasterio."""
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
        yield _style(folder / f"{name}.qml", name, raster)


def _style(path, name, raster):
    """Write the style of a layer for QGIS; -> its path."""
    if name == "agreement":
        return write_style_of_shares(path, AGREEING, AGREEMENT, clear=1.0)
    if "_probability" in name:
        return write_style_of_shares(path, SHARES, (None, *COLOURS[1:]), clear=0.0)
    return write_style(path, QUANTITIES[name.partition("_")[0]][0], raster)
