"""The vectors of a run by layer: affected area, its pressure classes, release, deposit, thalweg, run-out, and what was
built in its way."""

from dataclasses import dataclass

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.gis.outlines import affected, outline
from snowmpm.io.built import dam_lines, footprints
from snowmpm.io.parameters import parameters
from snowmpm.io.status import status_of
from snowmpm.quantities.classes import classes_of

PLACE = ("runout", "travel_angle", "runout_x", "runout_y", "runout_z")
"""Numbers attached to the run-out."""


@dataclass(frozen=True)
class Layer:
    """Features of one kind. geometry_type as GeoPackage has it; features: [(geometry, {field: value})], every feature
    with the same fields; geometries in map coordinates [m]."""

    name: str
    geometry_type: str
    features: list


def layers_of(run, observed=None):
    """The `Layer`s of a `Run` with maps, and one of the `Observed` outline if given.

    Each feature names its run and says whether it is final. Raises InputError for a run without these maps.
    """
    if "peak_depth" not in run.maps or "flow_depth" not in run.hazard.get("numbers", {}):
        raise InputError(f"{run.path}: no outlines: they are made of the maps of runs in three dimensions on"
                         " terrain, at their end")
    numbers, status = run.hazard["numbers"], status_of(run)
    common = {"run": run.name, "final": status.final, "status": status.text}
    found = [Layer("affected_area", "MultiPolygon", [_area(run, affected(run), "peak_depth", common)])]
    if "peak_pressure" in run.maps and (features := _classes(run, common)):
        found.append(Layer("pressure_classes", "MultiPolygon", features))
    if release := run.hazard.get("release"):
        outline_of_snow = shapely.MultiPolygon([(part[0], part[1:]) for part in release])
        about = {"area_m2": round(numbers["release_area"], 2), **common}
        found.append(Layer("release", "MultiPolygon", [(outline_of_snow, about)]))
    if "deposit_depth" in run.maps:
        mask = np.nan_to_num(run.maps["deposit_depth"].values) >= numbers["flow_depth"]
        if mask.any():
            found.append(Layer("deposit", "MultiPolygon", [_area(run, mask, "deposit_depth", common)]))
    profile, line = run.hazard.get("profile"), run.hazard.get("runout_line")
    if profile:
        way = _on_ground(profile)
        found.append(Layer("thalweg", "LineString", [(way, {"length_m": round(float(profile["s"][-1]), 2), **common})]))
    if line and all(numbers.get(name) is not None for name in PLACE):
        about = {"runout_m": round(numbers["runout"], 2), "travel_angle_deg": round(numbers["travel_angle"], 2)}
        found.append(Layer("runout_line", "LineString", [(shapely.LineString(line), {**about, **common})]))
        point = shapely.Point(numbers["runout_x"], numbers["runout_y"], numbers["runout_z"])
        about = {name: float(value) for name, value in numbers.items() if isinstance(value, int | float)}
        about |= {f"parameter_{name}".replace(" ", "_"): text for name, text in parameters(run).items()}
        found.append(Layer("runout_point", "Point", [(point, {**about, **common})]))
    if built := [(_multi(footprint), {"name": name, **common}) for name, footprint in footprints(run).items()]:
        found.append(Layer("obstacles", "MultiPolygon", built))
    if dams := [(shapely.LineString(line), {"name": name, **common}) for name, line in dam_lines(run).items()]:
        found.append(Layer("dams", "LineString", dams))
    if observed is not None:
        about = {"file": observed.name, "area_m2": round(observed.geometry.area, 2)}
        found.append(Layer("observed", "MultiPolygon", [(_multi(observed.geometry), {**about, **common})]))
    return found


def _on_ground(profile):
    """The thalweg as a 3-D line, or in plan if the terrain is unknown.

    Over holes in the terrain, its height is interpolated linearly. It ends where the terrain ends.
    """
    s, x, y, z = (np.asarray(profile[name], float) for name in ("s", "x", "y", "z"))
    known = np.flatnonzero(np.isfinite(z))
    if len(known) < 2:
        return shapely.LineString(np.column_stack([x, y]))
    own = slice(known[0], known[-1] + 1)
    return shapely.LineString(np.column_stack([x[own], y[own], np.interp(s[own], s[known], z[known])]))


def _area(run, mask, raster, common):
    geometry = outline(mask, run.maps[raster], run.origin)
    return geometry, {"area_m2": round(geometry.area, 2), **common}


def _classes(run, common):
    """One feature for each non-empty pressure class of the affected area."""
    raster = run.maps["peak_pressure"]
    values, flows = np.nan_to_num(raster.values), affected(run)
    classes = classes_of("peak_pressure", float(values.max()))
    number, features = np.digitize(values, classes.limits), []
    for k in range(len(classes.limits) + 1):
        mask = flows & (number == k)
        if mask.any():
            geometry = outline(mask, raster, run.origin)
            low, high = (0.0, *classes.limits)[k] / 1e3, (*classes.limits, np.inf)[k] / 1e3
            features.append((geometry, {"class": classes.label(k), "from_kpa": low,
                                        "to_kpa": float(high) if np.isfinite(high) else None,
                                        "area_m2": round(geometry.area, 2), **common}))
    return features


def _multi(geometry):
    return geometry if geometry.geom_type == "MultiPolygon" else shapely.MultiPolygon([geometry])
