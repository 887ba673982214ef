"""Where a layer lies, in plan: an interval, a rectangle, a polygon, or polygons from a file."""

import json
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.seeding.polygons import Rings
from snowmpm.terrain.load import existing

GIS = "needs the gis extra: pip install 'snowmpm[gis]'"


@dataclass(frozen=True, eq=False)
class Region:
    """Part of the plan.

    lower, upper (dim - 1,) [m]: bounds; rings: the polygon, None for the whole box; thickness [m]: of the snow there,
    as given by the file, or None; label: how a message names it; to_border: as far as the terrain goes within the
    bounds (an axis was left free), instead of refusing what lies off the terrain.
    """

    lower: np.ndarray
    upper: np.ndarray
    rings: Rings | None = None
    thickness: float | None = None
    label: str = "region"
    to_border: bool = False

    def area(self):
        """Plan area [m2], length [m] in 2-D."""
        return float(np.prod(self.upper - self.lower)) if self.rings is None else self.rings.area()


def regions_of(spec, surface, base_dir, key):
    """Regions of a scene's region table; without one, the whole terrain.

    spec: None or an object with one of x = [x0, x1] (and y = [y0, y1] in 3-D, default all of the terrain), polygon =
    [[x, y], ...], file = .shp or .geojson (polygons; attribute `thickness` [m] where there is one).
    InputError: no area, unreadable file, a polygon in 2-D.
    """
    d = surface.dim - 1
    lower, upper = surface.lower[:d].copy(), surface.upper[:d].copy()
    if spec is None:
        return [Region(lower, upper, label="terrain", to_border=True)]
    given = {name: getattr(spec, name, None) for name in ("x", "y", "polygon", "file")}
    given = {name: value for name, value in given.items() if value is not None}
    if d == 1 and set(given) - {"x"}:
        raise InputError(f"{key}: in 2-D only x = [from, to] can be given, not {', '.join(sorted(set(given) - {'x'}))}")
    if "polygon" in given or "file" in given:
        if len(given) > 1:
            raise InputError(f"{key}: give one of x and y, polygon, or file, not {' and '.join(given)}")
        if "file" in given:
            return read_regions(existing(given["file"], base_dir, f"{key}.file"), f"{key}.file")
        return [_polygon_region([given["polygon"]], None, f"{key}.polygon")]
    for axis, name in enumerate(("x", "y")[:d]):
        if name in given:
            first, last = (float(v) for v in given[name])
            if not last > first:
                raise InputError.at(f"{key}.{name}", [first, last], "must go from small to large")
            lower[axis], upper[axis] = first, last
    return [Region(lower, upper, label=key, to_border=len(given) < d)]


def _polygon_region(rings, thickness, label):
    try:
        area = Rings(rings)
    except (ValueError, IndexError, TypeError):
        raise InputError(f"{label}: a polygon is a list of points [x, y]") from None
    if not area.rings or not area.area() > 0:
        raise InputError(f"{label}: the polygon has no area")
    return Region(*area.bounds(), area, thickness, label)


def read_regions(path, key):
    """Regions of the polygons in a .shp or .geojson file, without overlap: the first polygon keeps what two share."""
    suffix = Path(path).suffix.lower()
    if suffix == ".shp":
        features = _shapefile_polygons(path, key)
    elif suffix in (".geojson", ".json"):
        features = _geojson_polygons(path, key)
    else:
        raise InputError.at(key, str(path), "must be a .shp or .geojson file")
    if not features:
        raise InputError.at(key, str(path), "holds no polygon")
    regions = [_polygon_region(rings, thickness, f"{key} = {Path(path).name!r}") for rings, thickness in features]
    return _disjoint(regions, key, path)


def _disjoint(regions, key, path):
    """Regions whose bounds touch are cut against those before them."""
    touching = any(
        (a.lower <= b.upper).all() and (b.lower <= a.upper).all() for i, a in enumerate(regions) for b in regions[:i]
    )
    if not touching:
        return regions
    try:
        import shapely
    except ImportError:
        raise InputError.at(key, str(path), f"polygons that may overlap: {GIS}") from None
    taken, result = shapely.Polygon(), []
    for region in regions:
        own = shapely.Polygon()
        for ring in region.rings.rings:  # odd-even, as everywhere here
            own = own.symmetric_difference(shapely.make_valid(shapely.Polygon(ring)))
        own, taken = own.difference(taken), taken.union(own)
        parts = [p for p in shapely.get_parts(own) if p.geom_type == "Polygon" and p.area > 0]
        rings = [np.array(r.coords) for p in parts for r in (p.exterior, *p.interiors)]
        if rings:
            result.append(_polygon_region(rings, region.thickness, region.label))
    return result


def _shapefile_polygons(path, key):
    try:
        import shapefile
    except ImportError:
        raise InputError.at(key, str(path), f"a shapefile {GIS}") from None
    try:
        with shapefile.Reader(str(path)) as reader:
            features = []
            for shape, record in zip(reader.shapes(), _records(reader), strict=True):
                if "POLYGON" not in shape.shapeTypeName:
                    continue
                points, parts = np.asarray(shape.points, float), [*shape.parts, len(shape.points)]
                rings = [points[a:b] for a, b in pairwise(parts)]
                features.append((rings, _thickness(record)))
    except Exception as error:  # pyshp lets struct, OS and its own errors through on damaged files
        raise InputError.at(key, str(path), "is not a readable shapefile") from error
    return features


def _records(reader):
    """Attributes of each shape; empty ones where the .dbf file is missing."""
    return [r.as_dict() for r in reader.records()] if reader.dbf else [{}] * len(reader)


def _geojson_polygons(path, key):
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
        features = data["features"] if data["type"] == "FeatureCollection" else [data]
        found = []
        for feature in features:
            is_feature = feature["type"] == "Feature"
            geometry = feature["geometry"] if is_feature else feature
            properties = (feature.get("properties") if is_feature else None) or {}
            if not geometry or geometry["type"] not in ("Polygon", "MultiPolygon"):
                continue
            polygons = [geometry["coordinates"]] if geometry["type"] == "Polygon" else geometry["coordinates"]
            rings = [np.asarray(ring, float)[:, :2] for polygon in polygons for ring in polygon]
            found.append((rings, _thickness(properties)))
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise InputError.at(key, str(path), "is not a readable GeoJSON file") from error
    return found


def _thickness(attributes):
    """The attribute `thickness` [m], whatever its case; None where it is missing, empty or not positive."""
    for name, value in attributes.items():
        if name.lower() == "thickness":
            try:
                return float(value) if float(value) > 0 else None
            except (TypeError, ValueError):
                return None
    return None
