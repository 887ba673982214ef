"""Polygons of a file one by one, as they are drawn: also where they overlap."""

from typing import NamedTuple

import shapely

from snowmpm.seeding.polygons import Polygons
from snowmpm.seeding.region_files import read_features


class Area(NamedTuple):
    """geometry: MultiPolygon [m]; thickness [m], or None and why (`flaw`)."""

    geometry: shapely.MultiPolygon
    thickness: float | None
    flaw: str


def polygons_of(path, key, system):
    """List of `Area`s in a .shp, .geojson or .gpkg file, in a `ReferenceSystem`. InputError."""
    return [Area(Polygons.of(one.parts, f"{key} = {path.name!r}").geometry, one.thickness, one.flaw)
            for one in read_features(path, key, system)]
