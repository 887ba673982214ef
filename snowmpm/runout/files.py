"""What `snowmpm runout` writes: tables, rasters, and the path with where each model stops."""

import numpy as np

from snowmpm.draft import write_table
from snowmpm.io.ground_maps import Map
from snowmpm.runout.block import GRAVITY

RASTERS = {
    "energy_height": ("largest energy height", "m"),
    "speed": ("largest speed of a block", "m/s"),
    "travel_length": ("longest way", "m"),
    "travel_angle": ("travel angle", "degrees"),
    "flux": ("sum of flux", "1"),
    "release_cells": ("release cells that reach it", "1"),
}
"""Name: words and unit."""
TABLES = ("runout.csv", "profile.csv", "runout.png", "runout.gpkg")


def write_reaches(path, found):
    """Write where each model stops as CSV; -> the path."""
    rows = [[one.model, *map(_number, (one.s, one.angle, *(one.place if one.place is not None else (None, None)),
                                       one.height, one.speed)), one.note] for one in found.reaches]
    return write_table(path, ["model", "length_m", "angle_deg", "x_m", "y_m", "z_m", "largest_speed_m_s", "note"], rows)


def write_profile(path, found):
    """Write the path, its ground and the speeds along it as CSV; -> the path."""
    names, profile = list(found.speeds), found.profile
    heads = ["s_m", "x_m", "y_m", "z_m", "slope_deg", *(f"speed_m_s: {name}" for name in names)]
    return write_table(path, heads, [
        [f"{profile.s[i]:.2f}", f"{profile.plan[i, 0]:.2f}", f"{profile.plan[i, 1]:.2f}", f"{profile.z[i]:.2f}",
         f"{profile.angles[i]:.2f}", *(f"{found.speeds[name][i]:.2f}" for name in names)]
        for i in range(len(profile.s))])


def rasters(found, ground):
    """{name: `snowmpm.io.Map`} of the routing, in map coordinates."""
    routed = found.routed
    values = {"energy_height": routed.energy, "speed": np.sqrt(2.0 * GRAVITY * routed.energy),
              "travel_length": routed.length, "travel_angle": routed.angle, "flux": routed.flux,
              "release_cells": routed.cells}
    x, y = ground.lower + 0.5 * ground.cell
    return {name: Map(values[name].T, x, y, ground.cell, RASTERS[name][1]) for name in RASTERS}


def layers(found):
    """`snowmpm.gis.layers.Layer`s of the path, and of where each model stops on it."""
    import shapely

    from snowmpm.gis.layers import Layer

    profile = found.profile
    line = shapely.LineString(np.column_stack([profile.plan, profile.z]))
    points = [(shapely.Point(*one.place, one.height), {
        "model": one.model, "length_m": round(one.s, 1),
        "angle_deg": None if one.angle is None else round(float(one.angle), 2)})
        for one in found.reaches if one.place is not None]
    return [Layer("path", "LineString", [(line, {"length_m": round(float(profile.s[-1]), 1)})]),
            Layer("runout", "Point", points)]


def _number(value):
    return "" if value is None else f"{value:.6g}" if abs(value) < 1e4 else f"{value:.2f}"
