"""What must hold of an event before its scene is computed: observations lie on the terrain."""

from pathlib import Path

import shapely

from snowmpm.errors import InputError
from snowmpm.events.store import PREFIX, event, scene_file
from snowmpm.gis.observed import area_of
from snowmpm.scenes.loader import load_scene
from snowmpm.terrain.raster import read_raster

ASIDE = 500.0
"""Largest distance [m] of the place where a flow stopped from the path."""


def checked_areas(name):
    """(`ReferenceSystem` of the terrain, outline, deposit) of an event; None for what there is not. Raises InputError
    for observations that cannot be read or lie beside the terrain."""
    known, path = event(name), scene_file(name)
    seen, where = known.observed, f"{PREFIX}{name}: observed"
    scene = load_scene(path)
    box = system = None
    if scene.terrain is not None and scene.terrain.kind == "dem":
        raster = read_raster(Path(scene.base_dir, scene.terrain.file))
        box, system = shapely.box(raster.x[0], raster.y[0], raster.x[-1], raster.y[-1]), raster.system
    areas = []
    for key, one in (("outline", seen.outline), ("deposit", seen.deposit)):
        if one is None:
            areas.append(None)
            continue
        area = area_of(path.parent / one.file, system, f"{where}.{key}.file")
        _require_on(box, area, f"{where}.{key}.file", one.file)
        if shapely.is_empty(shapely.buffer(area, -one.uncertainty)):
            raise InputError.at(f"{where}.{key}.uncertainty", one.uncertainty, "is wider than the area itself")
        areas.append(area)
    if seen.path:
        line = shapely.LineString(seen.path)
        _require_on(box, line, f"{where}.path", len(seen.path), whole=shapely.Point(seen.path[0]))
        if seen.stopped and (away := shapely.distance(line, shapely.Point(seen.stopped.x, seen.stopped.y))) > ASIDE:
            raise InputError.at(f"{where}.stopped", [seen.stopped.x, seen.stopped.y],
                                f"lies {away:.0f} m beside the path: at most {ASIDE:g} m")
    for k, one in enumerate(seen.values):
        if one.x is not None:
            _require_on(box, shapely.Point(one.x, one.y), f"{where}.values.{k}", [one.x, one.y])
    return system, *areas


def _require_on(box, shape, key, value, whole=None):
    """Raise InputError for what lies beside the terrain, or reaches further than a terrain's width beyond it."""
    if box is None:
        return
    west, south, east, north = shapely.bounds(box)
    wide = shapely.box(2 * west - east, 2 * south - north, 2 * east - west, 2 * north - south)
    if not shapely.intersects(box, shape if whole is None else whole) or not shapely.covers(wide, shape):
        raise InputError.at(key, value, "lies beside the terrain: is its coordinate system right?")
