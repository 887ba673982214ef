"""Areas of several runs in one file."""

import math

import numpy as np

from snowmpm.gis.layers import Layer
from snowmpm.gis.outlines import affected, outline
from snowmpm.gis.qgis_style import categorised, vector_style
from snowmpm.gis.vectors import write_geopackage
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import PRESSURES

RAMP = ("#2a0593", "#5601a4", "#7e03a8", "#a21d9a", "#bf3984", "#d6556d", "#e97257", "#f79342", "#fdb52e", "#f8df25")
"""Colours of outlines, from the first scenario to the last."""


def write_outlines(found, path):
    """Write the affected area of each of (name, `Run`), and where the peak pressure reached each of PRESSURES, as a
    GeoPackage: a layer each, with a feature a run; -> the path."""
    layers = {}
    for name, run in found:
        flows, pressure, status = affected(run), np.nan_to_num(run.maps["peak_pressure"].values), status_of(run)
        for layer, limit in (("affected_area", -math.inf), *((f"above_{p / 1e3:g}_kPa", p) for p in PRESSURES)):
            mask = flows & (pressure >= limit)
            if mask.any():
                shape = outline(mask, run.maps["peak_depth"], run.origin)
                layers.setdefault(layer, []).append((shape, {
                    "scenario": name, "area_m2": round(shape.area, 2), "final": status.final, "status": status.text}))
    colours = {name: RAMP[(len(RAMP) - 1) * k // max(1, len(found) - 1)] for k, (name, _) in enumerate(found)}
    return write_geopackage(path, [Layer(name, "MultiPolygon", own) for name, own in layers.items()],
                            found[0][1].provenance.get("crs"),
                            lambda layer: vector_style(layer, categorised(layer, "scenario", lines=colours)))
