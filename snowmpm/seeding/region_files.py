"""Polygons with their thickness, lines, and points, from shapefiles, GeoJSON and GeoPackages, in the terrain's
coordinates."""

import json
import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from snowmpm.errors import InputError, shown_line
from snowmpm.reading import budget as read_budget
from snowmpm.seeding import attributes
from snowmpm.seeding.shapefiles import read_shapefile
from snowmpm.terrain.raster import system_of as raster_system
from snowmpm.terrain.reference_system import WORLD, ReferenceSystem, system_beside

LONGEST_NAME = 60
"""Characters of the name of a line or a point."""
GIS = "needs the gis extra: pip install 'snowmpm[gis]'"
FILE_BYTES = 40.0
"""Memory per byte of a file while it is read."""
SQLITE = b"SQLite format 3\0"
UNDEFINED = re.compile("undefined", re.IGNORECASE)
"""Part of the name of the system in a GeoPackage without a known system."""


@dataclass(frozen=True)
class Feature:
    """parts: polygons, each a list of rings (n, 2), its outline and the holes in it; thickness [m], or None; flaw: why
    there is none. Of lines and points the parts are lines (n, 2), a point one of a single place; name: of the
    feature, "" without one."""

    parts: list
    thickness: float | None
    flaw: str
    name: str = ""


class Kind(NamedTuple):
    """Geometries that are read: how messages call one and several, their types in shapefiles, and one and many in
    GeoJSON."""

    single: str
    plural: str
    shapes: tuple
    one: tuple
    many: tuple


POLYGON = Kind("polygon", "polygons", ("POLYGON",), ("Polygon",), ("MultiPolygon",))
ANY = ("Unknown", "Geometry")
"""How the type of a layer of a GeoPackage begins that may hold any geometry."""

LINE = Kind("line", "lines", ("POLYLINE",), ("LineString",), ("MultiLineString",))
PLACE = Kind("line or point", "lines or points", ("POLYLINE", "POINT"), ("LineString", "Point"),
             ("MultiLineString", "MultiPoint"))


def read_lines(path, key, terrain=None):
    """Lines (n, 2) [m] in a .shp, .geojson or .gpkg file, in the system of the terrain, as `read_features` has it."""
    return [line for feature in read_features(path, key, terrain, kind=LINE) for line in feature.parts]


def count_of_areas(path, key):
    """How many areas a .shp, .geojson or .gpkg file holds."""
    return len(_read(path, key)[0])


def lines_on_raster(path, key, raster=None):
    """`read_lines` in the system of an elevation raster, a file."""
    return read_lines(path, key, raster and raster_system(raster))


def read_features(path, key, terrain=None, attribute=None, kind=POLYGON, named=False):
    """Features of the polygons in a .shp, .geojson or .gpkg file, in the system of the terrain.

    attribute: the one that holds the thickness; `attributes.USUAL` when missing. kind: LINE or PLACE for lines, or
    lines and points, whose names are in the attribute `name`; named: polygons with these, in place of a thickness.

    terrain: its `ReferenceSystem`, None where it names none. A shapefile is in the system of the .prj beside it,
    GeoJSON in that of its member `crs`, else in longitude and latitude if it can be, as RFC 7946 has it; a GeoPackage,
    whose only layer of polygons is read, says its own. A file that
    names none is taken in the terrain's coordinates, and so is a file in lengths if the terrain names none. A warning
    says when the system differs from what the file says.
    InputError: unreadable, no polygon, degrees or feet beside a terrain that names no system, a place that the
    terrain's system does not reach, a system that the coordinates contradict.
    """
    named = named or kind is not POLYGON
    attribute = "name" if named else attribute
    found, names, system, told = _read(path, key, lambda names: attributes.chosen(names, attribute), kind)
    where = f"{key} = {str(path)!r}"
    features = _with_thickness(found, names, attribute) if not named else [
        Feature(parts, None, "", shown_line("" if name is None else name, LONGEST_NAME)) for parts, name in found]
    if not features:
        raise InputError.at(key, str(path), f"holds no {kind.single}")
    corners = np.concatenate([np.empty((0, 2)), *(ring for f in features for ring in _rings(f.parts, kind))])
    if system is None and Path(path).suffix.lower() not in (".shp", ".gpkg"):
        system, said = _of_plain_geojson(corners, terrain)
        told += [said] if said else []
    if system is not None and (wrong := system.contradiction(*corners.T)):
        raise InputError(f"{where}: is tagged {system.name}, but {wrong}: the tag is wrong; name the right system with"
                         " a GIS")
    if system is not None and terrain is None:
        if system.is_geographic or system.metre != 1.0:
            raise InputError(f"{where}: is in {system.unit} ({system.name}), and the terrain names no coordinate"
                             " system to carry it into: save it in the terrain's own, in metres")
        told.append(f"is in {system.name}, and the terrain names no coordinate system: taken as the same")
    elif system is not None:
        _refuse_latitude_first(corners, system, terrain, where)
        features = [replace(feature, parts=[
            [_carried(ring, system, terrain, where) for ring in part] if kind is POLYGON else
            _carried(part, system, terrain, where)
            for part in feature.parts]) for feature in features]
    if told:
        warnings.warn(f"{where}: {'; '.join(told)}", stacklevel=2)
    return features


def _rings(parts, kind):
    """Lines, or rings of polygons."""
    return [ring for rings in parts for ring in rings] if kind is POLYGON else parts


def system_of(path, key):
    """`ReferenceSystem` that a .shp, .geojson or .gpkg file names, None where it names none. InputError."""
    return system_beside(path) if Path(path).suffix.lower() == ".shp" else _read(path, key)[2]


def _with_thickness(polygons, names, attribute):
    """Features of polygons with a value each."""
    name = attributes.chosen(names, attribute)
    if name is None:
        has = f"its attributes are {', '.join(names[:8])}{' ...' if len(names) > 8 else ''}" if names else "it has none"
        flaw = f"{attributes.ABSENT} {attribute or attributes.USUAL[0]!r} ({has})"
        return [Feature(parts, None, flaw) for parts, _ in polygons]
    found = []
    for number, (parts, value) in enumerate(polygons, 1):
        thickness, flaw = attributes.thickness_of(value)
        found.append(Feature(parts, thickness, flaw and f"polygon {number}: {name} {flaw}"))
    return found


def _read(path, key, choose=lambda names: None, kind=POLYGON):
    """[(parts, value of an attribute)] as stored in the file, names of the attributes, its system or None, and warnings
    for the user."""
    suffix = Path(path).suffix.lower()
    if suffix not in READERS:
        raise InputError.at(key, str(path), "must be a .shp, .geojson or .gpkg file")
    where = f"{key} = {str(path)!r}"
    try:
        read_budget.allow(where, FILE_BYTES * Path(path).stat().st_size, f"its {kind.plural}")
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    return READERS[suffix](path, key, choose, kind)


def _of_plain_geojson(corners, terrain):
    """System of GeoJSON that names none, and the warning: degrees by definition, if the numbers allow it and the
    terrain is georeferenced; else the terrain's system."""
    degrees = (np.abs(corners) <= [180.0, 90.0]).all()
    if terrain is None:
        return None, "names no coordinate system, and the terrain neither: taken as the same" if degrees else None
    if degrees:
        return WORLD(), None
    return None, f"GeoJSON without `crs` should be in degrees and is not: taken as {terrain.name}, as the terrain"


def _refuse_latitude_first(corners, system, terrain, where):
    """Raises InputError for degrees that lie where the terrain's system is made for once they are exchanged, and only
    then."""
    if not system.is_geographic or not len(corners) or np.abs(corners).max() > 90.0:
        return
    off, exchanged = (terrain.far_off(*system.carried(place, terrain)[0]) for place in (corners[:1], corners[:1, ::-1]))
    if off > 1.0 and exchanged == 0.0:
        raise InputError(f"{where}: its coordinates, such as {corners[0, 0]:.6g}, {corners[0, 1]:.6g}, are latitude and"
                         f" longitude: the file must have longitude first ({terrain.name} is made for places where"
                         " they are exchanged)")


def _carried(ring, system, terrain, where):
    moved = system.carried(ring, terrain)
    if not np.isfinite(moved).all() and np.isfinite(ring).all():
        raise InputError(f"{where}: is in {system.name}, from where no way leads to {terrain.name}, the terrain's")
    return moved


def _shapefile(path, key, choose, kind):
    shapes, names, told = read_shapefile(path, key, choose, kind.shapes, kind.plural)
    found = [(_nested(lines) if kind is POLYGON else [line for line in lines if len(line)], value)
             for lines, value in shapes]
    return found, names, system_beside(path), told


def _nested(rings):
    """Rings of one shape as polygons: a ring inside an odd number of others is a hole, whatever its orientation; a
    shapefile does not say which rings belong together."""
    import shapely

    rings = [ring if len(ring) and (ring[0] == ring[-1]).all() else np.concatenate([ring, ring[:1]]) for ring in rings]
    rings = [ring for ring in rings if len(ring) > 3 and np.isfinite(ring).all()] or rings
    if len(rings) == 1:
        return [rings]
    areas = [shapely.make_valid(shapely.Polygon(ring)) for ring in rings]
    inside = [[j for j, other in enumerate(areas) if j != i and other.area > area.area and other.covers(area)]
              for i, area in enumerate(areas)]
    polygons = {i: [ring] for i, ring in enumerate(rings) if len(inside[i]) % 2 == 0}
    for i, ring in enumerate(rings):
        if i not in polygons:
            polygons[min(inside[i], key=lambda j: areas[j].area)].append(ring)
    return list(polygons.values())


def _geojson(path, key, choose, kind):
    try:
        # Text is in UTF-8 by definition; what is not concerns no number
        data = json.loads(Path(path).read_bytes().decode("utf-8-sig", "replace"))
        features = data["features"] if data["type"] == "FeatureCollection" else [data]
        found, others, names = [], 0, {}
        for feature in features:
            is_feature = feature["type"] == "Feature"
            geometry = feature["geometry"] if is_feature else feature
            properties = (feature.get("properties") if is_feature else None) or {}
            parts, left = _parts(geometry, kind)
            others += left
            if parts:
                names |= dict.fromkeys(properties)
                found.append(([[_corners(ring) for ring in part] if kind is POLYGON else _corners(part)
                               for part in parts], properties))
        named = data.get("crs")
        system = None if named is None else ReferenceSystem.named(_name_of(named["properties"]), f"{path}: crs")
        name = choose(names)
        # In the case that each feature has
        same = sorted((one for one in names if name is not None and one.lower() == name.lower()),
                      key=lambda one: one != name)
        found = [(parts, next((own[one] for one in same if one in own), None)) for parts, own in found]
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError, OverflowError) as error:
        raise InputError.at(key, str(path), "is not a readable GeoJSON file") from error
    return found, tuple(names), system, _left_out(others, kind)


def _name_of(properties):
    """Name of a system in GeoJSON: as a name, or as older programs write it, as a number of the EPSG."""
    return properties["name"] if "name" in properties else f"EPSG:{int(properties['code'])}"


def _geopackage(path, key, choose, kind):
    try:
        import pyogrio
        import pyogrio.raw
        import shapely
    except ImportError:
        raise InputError.at(key, str(path), f"a GeoPackage {GIS}") from None
    try:
        with open(path, "rb") as file:
            if file.read(len(SQLITE)) != SQLITE:  # GDAL must not open the file as any other format
                raise InputError.at(key, str(path), "is not a readable GeoPackage")
        known = [(name, geometry) for name, geometry in pyogrio.list_layers(path) if geometry]
        layers = [name for name, geometry in known if any(one in geometry for one in kind.one)] or [
            name for name, geometry in known if geometry.startswith(ANY)]
        if len(layers) != 1:
            listed = f"{len(layers)} layers of {kind.plural}, {', '.join(map(str, layers))}"
            named = listed if layers else f"no {kind.single}"
            raise InputError.at(key, str(path), f"holds {named}: save the one that is meant in a file of its own")
        names = tuple(pyogrio.read_info(path, layer=layers[0])["fields"])
        name = choose(names)
        meta, _, geometries, columns = pyogrio.raw.read(path, layer=layers[0], columns=[name] if name else [])
        # Truth is told from numbers by the type of the column alone
        truths = name is not None and meta["dtypes"][0] == "bool"
        found, others = [], 0
        for row, geometry in enumerate(shapely.from_wkb(geometries)):
            pieces = shapely.get_parts(shapely.get_parts(geometry))  # a collection may hold several of several parts
            own = [part for part in pieces if part.geom_type in kind.one and not part.is_empty]
            others += sum(part.geom_type not in kind.one for part in pieces)
            parts = [[np.asarray(ring.coords)[:, :2] for ring in (part.exterior, *part.interiors)]
                     if kind is POLYGON else np.asarray(part.coords)[:, :2] for part in own]
            if parts:
                value = columns[0][row] if name else None
                found.append((parts, bool(value) if truths else value))
    except (pyogrio.errors.DataSourceError, pyogrio.errors.DataLayerError, shapely.errors.GEOSException,
            ValueError) as error:
        raise InputError.at(key, str(path), "is not a readable GeoPackage") from error
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    return found, names, _system(meta["crs"], f"{path}: its layer {layers[0]}"), _left_out(others, kind)


def _system(text, where):
    """System of a name such as EPSG:31287 or of well-known text, None of neither."""
    if not text or UNDEFINED.search(text):
        return None
    return (ReferenceSystem.of_text if "[" in text else ReferenceSystem.named)(text, where)


def _parts(geometry, kind):
    """Coordinates of the polygons, lines or points of a geometry, and how many geometries are none."""
    if not geometry:
        return [], 0
    own = geometry["type"]
    if own == "GeometryCollection":
        parts = [_parts(part, kind) for part in geometry["geometries"]]
        return [one for found, _ in parts for one in found], sum(left for _, left in parts)
    if own not in (*kind.one, *kind.many):
        return [], 1
    found = [geometry["coordinates"]] if own in kind.one else geometry["coordinates"]
    return ([[place] for place in found] if own.endswith("Point") else found), 0


def _corners(ring):
    """Corners (n, 2) of a ring. ValueError: it is no list of places."""
    corners = np.asarray(ring, float)
    if corners.ndim != 2 or corners.shape[1] < 2:
        raise ValueError("a ring is a list of places")
    return corners[:, :2]


def _left_out(others, kind):
    return [f"{others} of its geometries are no {kind.plural} and are left out"] if others else []


READERS = {".shp": _shapefile, ".geojson": _geojson, ".json": _geojson, ".gpkg": _geopackage}
