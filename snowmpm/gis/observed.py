"""Observed against computed outline, with scores.

    hit A = computed and observed, miss B = observed only, false alarm C = computed only  (plan areas)
    critical success index (Jaccard)  A / (A + B + C)
    hit rate                          A / (A + B)
    false-alarm ratio                 C / (A + C)
    area ratio (bias)                 (A + C) / (A + B)
    run-out difference                reach along the computed thalweg, or a line that is given, computed less observed

as in the verification of forecasts (Wilks, Statistical Methods in the Atmospheric Sciences, chapter on 2 x 2 tables).
Both reaches are those of outlines, to the furthest point of the polygon. They differ from the run-out, the point that
99 % of the snow lies before, which an outline does not contain. The computed reaches are reach_of_flow, reach_of_1_kPa
and so on.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.gis.outlines import affected, outline
from snowmpm.io.ground_maps import Map
from snowmpm.quantities.classes import PRESSURES
from snowmpm.quantities.thalweg import ahead_of
from snowmpm.seeding.regions import read_regions
from snowmpm.terrain.raster import read_raster
from snowmpm.terrain.reference_system import ReferenceSystem

MOST_EDGES = 100_000
"""Edges between marked and other cells of a raster."""
MOST_POINTS = 100_000
"""Points along an outline for its reach, about."""
RASTERS = (".asc", ".tif", ".tiff")

STEP = 5.0
"""Spacing [m] of points along an outline for its reach along the thalweg."""


@dataclass(frozen=True)
class Observed:
    """name: of the file; geometry: shapely polygons in the run's map coordinates [m]."""

    name: str
    geometry: Any

    @property
    def rings(self):
        """Outlines and holes, (n, 2) each [m]."""
        parts = shapely.get_parts(self.geometry)
        return [np.array(ring.coords)[:-1, :2] for part in parts for ring in (part.exterior, *part.interiors)]


def read_observed(path, run, key="--observed"):
    """The outline in a .shp, .geojson or .gpkg file, or around the cells above 0 of an .asc or .tif raster, transformed
    to the projection of a `Run`.

    InputError as for a release, and for an outline that lies beside the maps. key: names the file in messages.
    """
    geometry = area_of(path, system_of(run), key)
    away = shapely.distance(geometry, _extent(run))
    if away > 0.0:
        raise InputError.at(key, str(path), f"lies {away / 1e3:.3g} km beside the maps of {run.path}: is its"
                                            " coordinate system right?")
    return Observed(Path(path).name, geometry)


def area_of(path, system, key="--observed"):
    """Polygons of an observed area, see `read_observed`, in the `ReferenceSystem` `system`, None where that is not
    known. InputError."""
    if Path(path).suffix.lower() in RASTERS:
        return _of_raster(path, system, key)
    return shapely.union_all([region.polygons.geometry for region in read_regions(path, key, system)])


def _of_raster(path, system, key):
    raster = read_raster(path, key=key, quantity="marks of an observed area")
    seen, lattice = np.nan_to_num(raster.z) > 0.0, raster.lattice()
    if not seen.any():
        raise InputError.at(key, str(path), "no cell is above 0: nothing was observed")
    if lattice is None:
        raise InputError.at(key, str(path), "must have square cells")
    edges = int((seen[1:] != seen[:-1]).sum() + (seen[:, 1:] != seen[:, :-1]).sum())
    if edges > MOST_EDGES:
        raise InputError.at(key, str(path), f"its marks are scattered: they have {edges} edges, at most {MOST_EDGES}")
    found = outline(seen, Map(raster.z, raster.x[0], raster.y[0], lattice[1], ""), (0.0, 0.0))
    if raster.system is None or system is None:
        return found
    return shapely.transform(found, lambda corners: raster.system.carried(corners, system))


def system_of(run):
    """`ReferenceSystem` of the map coordinates of a `Run`, None where none is known."""
    wkt = run.provenance.get("crs")
    return ReferenceSystem.of_text(wkt, f"{run.path}: its projection") if wkt else None


def _extent(run):
    """Box around the maps of a run, in map coordinates."""
    raster = run.maps["peak_depth"]
    rows, columns = raster.values.shape
    x, y = run.origin[0] + raster.x0, run.origin[1] + raster.y0
    return shapely.box(x, y, x + columns * raster.cell, y + rows * raster.cell)


def score(run, observed, line=None):
    """[{quantity: value}] of the affected area of a `Run`, and of its part above each pressure, against `Observed`.

    line (n, 2) [m]: along which reaches are measured; the thalweg of the run by default. outline: words; hit_area,
    missed_area, false_area [m2]; critical_success_index, hit_rate, false_alarm_ratio, area_ratio; observed_reach,
    runout_difference [m] where there is a line.
    """
    raster = run.maps["peak_depth"]
    masks, numbers = {"affected area": affected(run)}, run.hazard["numbers"]
    reaches = {"affected area": numbers.get("reach_of_flow")}
    reaches |= {f"above {limit / 1e3:g} kPa": numbers.get(f"reach_of_{limit / 1e3:g}_kPa") for limit in PRESSURES}
    pressure = run.maps.get("peak_pressure")
    if pressure is not None:
        masks |= {f"above {limit / 1e3:g} kPa": affected(run) & (np.nan_to_num(pressure.values) >= limit)
                  for limit in PRESSURES}
    profile = run.hazard.get("profile")
    if line is not None:
        profile, reaches = dict(zip("xy", np.asarray(line).T, strict=True)), dict.fromkeys(reaches)
    return [{"outline": name, **compare(outline(mask, raster, run.origin), observed.geometry, profile, reaches[name])}
            for name, mask in masks.items() if mask.any()]


def compare(computed, observed, profile=None, reach=None):
    """Scores of one polygon against another; profile: x, y of the thalweg, for the run-out, or None; reach [m]: of the
    computed polygon along it, where it is known."""
    hit, missed, false = (float(shapely.area(part)) for part in (
        computed.intersection(observed), observed.difference(computed), computed.difference(observed)))
    found = {"hit_area": hit, "missed_area": missed, "false_area": false,
             "critical_success_index": hit / (hit + missed + false), "hit_rate": hit / (hit + missed),
             "false_alarm_ratio": false / (hit + false), "area_ratio": (hit + false) / (hit + missed)}
    if profile:
        way = _extended(np.column_stack([profile["x"], profile["y"]]), computed, observed)
        seen = reach_along(way, observed)
        own = reach_along(way, computed) if reach is None else reach
        found |= {"observed_reach": seen, "runout_difference": own - seen}
    return found


def _extended(line, *areas):
    """The thalweg (n, 2), extended straight beyond its end at the run-out, as far as the areas may reach."""
    low, high = np.reshape(shapely.total_bounds([*areas, shapely.LineString(line)]), (2, 2))
    return shapely.LineString([*line, line[-1] + np.linalg.norm(high - low) * ahead_of(line)])


def reach_along(way, area):
    """Length [m] along a line to the furthest point of an area, by its nearest place on the line."""
    return float(shapely.line_locate_point(way, shapely.points(_points(area))).max())


def _points(area):
    """Points (n, 2) along the outline of an area."""
    return shapely.get_coordinates(shapely.segmentize(area, max(STEP, shapely.length(area) / MOST_POINTS)))
