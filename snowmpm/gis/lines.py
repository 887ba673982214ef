"""Lines and points that a user asks about: read from vector files; what flowed past gauges as tables and layers."""

import itertools
import math

import numpy as np
import shapely

from snowmpm.draft import write_table
from snowmpm.errors import InputError
from snowmpm.gis.layers import Layer
from snowmpm.gis.observed import system_of
from snowmpm.io.gauges import PROFILE, SERIES, Place
from snowmpm.io.status import status_of
from snowmpm.quantities.table import quantity
from snowmpm.seeding.region_files import LINE, PLACE, read_features

MOST = 100
"""Gauges of a file."""


def read_places(path, run):
    """[`Place`] of the lines and points in a .shp, .geojson or .gpkg file, in the map coordinates of a `Run`. Those
    without a name (attribute `name`) are numbered: `line 1`. InputError as of `read_features`, for too many, and for
    a line without length."""
    found = []
    for feature in read_features(path, "--gauges", system_of(run), kind=PLACE):
        for part in feature.parts:
            corners, word = np.asarray(part, float), "line" if len(part) > 1 else "point"
            number = 1 + sum(one.is_line == (word == "line") for one in found)
            if not np.isfinite(corners).all() or (word == "line" and np.ptp(corners, axis=0).max() == 0.0):
                raise InputError.at("--gauges", str(path), f"{word} {number} has no length, or corners that are no"
                                                           " numbers")
            found.append(Place(feature.name or f"{word} {number}", corners))
    if len(found) > MOST:
        raise InputError.at("--gauges", str(path), f"holds {len(found)} lines and points: at most {MOST}")
    return _told_apart(found)


def read_path(path, run):
    """The one line (n, 2) in a vector file, in the map coordinates of a `Run`. InputError as of `read_features`, and
    for several, or one without length."""
    return the_line(path, system_of(run))


def the_line(path, system):
    """The one line (n, 2) in a vector file, in a `ReferenceSystem`, None where it is not known; as `read_path`."""
    lines = [part for feature in read_features(path, "--path", system, kind=LINE) for part in feature.parts]
    if len(lines) != 1:
        raise InputError.at("--path", str(path), f"holds {len(lines)} lines: must be one")
    if not np.isfinite(lines[0]).all() or np.ptp(lines[0], axis=0).max() == 0.0:
        raise InputError.at("--path", str(path), "has no length, or corners that are no numbers")
    return np.asarray(lines[0], float)


def _told_apart(places):
    """Places whose names differ: those of one name are numbered."""
    names, taken, found = [one.name for one in places], set(), []
    for one in places:
        numbered = (f"{one.name} {k}" for k in itertools.count(1))
        free = one.name if names.count(one.name) == 1 else next(
            name for name in numbered if name not in taken and name not in names)
        taken.add(free)
        found.append(Place(free, one.corners))
    return found


def write_series(path, found):
    """Write what flowed past each `Gauge` over time as CSV, a row a gauge and frame; -> its path."""
    rows = [[one.place.name, f"{time:.6g}", *(f"{one.series[name][i]:.5g}" if name in one.series else ""
                                              for name in SERIES)]
            for one in found for i, time in enumerate(one.series["time"])]
    return write_table(path, ["gauge", "time_s", "depth_m", "speed_m_s", "pressure_Pa", "discharge_m3_s", "volume_m3"],
                       rows)


def write_profiles(path, found):
    """Write the largest values along each line as CSV, a row a point of a line; -> its path."""
    rows = [[one.place.name, *(f"{one.profile[name][k]:.3f}" for name in ("s", "x", "y")),
             *(_number(one.profile[name][k]) if name in one.profile else "" for name in PROFILE)]
            for one in found for k in range(len(one.profile.get("s", ())))]
    units = {name: quantity(name).unit.replace("/", "_") for name in PROFILE}
    return write_table(path, ["gauge", "s_m", "x_m", "y_m", *(f"{name}_{units[name]}" for name in PROFILE)], rows)


def _number(value):
    return f"{value:.5g}" if math.isfinite(value) else ""


def layers_of_gauges(run, found):
    """`Layer`s of the lines and the points, each with its numbers."""
    status = status_of(run)
    for name, kind, lines in (("gauge_lines", "LineString", True), ("gauge_points", "Point", False)):
        own = [one for one in found if one.place.is_line == lines]
        if own:
            shape = shapely.LineString if lines else lambda corners: shapely.Point(corners[0])
            yield Layer(name, kind, [(shape(one.place.corners), {
                "name": one.place.name, **{key: None if value is None else float(value)
                                           for key, value in one.numbers.items()},
                "run": run.name, "final": status.final, "status": status.text}) for one in own])
