"""Areas of several runs in one file."""

import math

import numpy as np

from snowmpm.gis.layers import Layer
from snowmpm.gis.outlines import affected, outline
from snowmpm.gis.vectors import write_geopackage
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import PRESSURES


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
    return write_geopackage(path, [Layer(name, "MultiPolygon", own) for name, own in layers.items()],
                            found[0][1].provenance.get("crs"))
