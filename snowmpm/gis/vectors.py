"""Vector layers as GeoJSON and GeoPackage."""

import contextlib
import json
import sqlite3
import warnings

import numpy as np
import shapely

from snowmpm.draft import draft, write_text
from snowmpm.errors import InputError
from snowmpm.io.projection import epsg_of

VERSION = "1.3"
"""Of GeoPackage: QGIS up to 3.26 warns of later ones."""
WORLD = "urn:ogc:def:crs:OGC:1.3:CRS84"
"""Longitude and latitude, the default system of GeoJSON."""


def write_geojson(path, layers, wkt):
    """Write layers (`snowmpm.gis.layers`) as one FeatureCollection; -> its path.

    wkt: projection of the coordinates. With an EPSG code they stay as they are, and the member `crs` names it; without
    one they become longitude and latitude. Each feature names its layer. Raises InputError without a projection, since
    readers take coordinates without a system for longitude and latitude.
    """
    if not wkt:
        raise InputError(f"{path}: GeoJSON needs a coordinate system, and the terrain names none")
    crs, place = _named_system(wkt)
    features = [{"type": "Feature", "geometry": shapely.geometry.mapping(place(geometry)),
                 "properties": {"layer": layer.name, **_plain(fields)}}
                for layer in layers for geometry, fields in layer.features]
    record = {"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}}, "features": features}
    return write_text(path, json.dumps(record, indent=1, allow_nan=False) + "\n")


def write_geopackage(path, layers, wkt=None, styles=None):
    """Write layers as tables of one GeoPackage; -> its path. wkt: projection of the coordinates, or None; styles: the
    style of a `Layer` for QGIS (`snowmpm.gis.qgis_style.vector_style`), kept in the file as its default.

    Raises InputError without pyogrio, OSError when the file cannot be written.
    """
    pyogrio, options = require_pyogrio(), {"dataset_options": {"VERSION": VERSION}}
    with draft(path) as part, _as_os_error(pyogrio.errors.DataSourceError, pyogrio.errors.FeatureError):
        part.unlink(missing_ok=True)
        for layer in layers:
            names = list(layer.features[0][1])
            columns = [_column([fields[name] for _, fields in layer.features]) for name in names]
            geometry = shapely.to_wkb([geometry for geometry, _ in layer.features])
            solid = " Z" if layer.features[0][0].has_z else ""
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "'crs' was not provided")  # the scene has no coordinate system
                pyogrio.raw.write(str(part), np.array(geometry, object), [values for values, _ in columns], names,
                                  field_mask=[mask for _, mask in columns], layer=layer.name, driver="GPKG",
                                  geometry_type=layer.geometry_type + solid, crs=wkt or None, promote_to_multi=False,
                                  **options)
                options = {}
        if styles:
            _add_styles(part, layers, styles)
    return path


def _add_styles(path, layers, styles):
    """Add the table `layer_styles`, in which QGIS finds the style of each layer."""
    with contextlib.closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE layer_styles (id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,"
                     " f_table_catalog TEXT(256), f_table_schema TEXT(256), f_table_name TEXT(256),"
                     " f_geometry_column TEXT(256), styleName TEXT(30), styleQML TEXT, styleSLD TEXT,"
                     " useAsDefault BOOLEAN, description TEXT, owner TEXT(30), ui TEXT(30),"
                     " update_time DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')))")
        file.execute("INSERT INTO gpkg_contents (table_name, data_type, identifier, description)"
                     " VALUES ('layer_styles', 'attributes', 'layer_styles', 'Styles of QGIS')")
        columns = dict(file.execute("SELECT table_name, column_name FROM gpkg_geometry_columns"))
        file.executemany("INSERT INTO layer_styles (f_table_catalog, f_table_schema, f_table_name, f_geometry_column,"
                         " styleName, styleQML, styleSLD, useAsDefault, description, owner)"
                         " VALUES ('', '', ?, ?, ?, ?, '', 1, 'snowmpm', '')",
                         [(layer.name, columns[layer.name], layer.name, styles(layer)) for layer in layers])


def require_pyogrio():
    """The package that writes GeoPackages. Raises InputError, with the command to install it."""
    try:
        import pyogrio
        import pyogrio.raw
    except ImportError:
        raise InputError("GeoPackage needs the gis extra: pip install 'snowmpm[gis]'; --files pictures"
                         " goes without") from None
    return pyogrio


def _named_system(wkt):
    """Name for the member `crs` of GeoJSON, and a function that transforms a geometry to that system."""
    code = epsg_of(wkt)
    if code:
        return f"urn:ogc:def:crs:EPSG::{code}", _to_centimetres
    import pyproj

    change = pyproj.Transformer.from_crs(pyproj.CRS.from_wkt(wkt), pyproj.CRS.from_authority("OGC", "CRS84"),
                                         always_xy=True)

    def to_world(geometry):
        return shapely.transform(geometry, lambda rows: np.round(np.column_stack(change.transform(*rows.T)), 8),
                                 include_z=geometry.has_z)

    return WORLD, to_world


def _to_centimetres(geometry):
    return shapely.transform(geometry, lambda rows: np.round(rows, 2), include_z=geometry.has_z)


def _plain(fields):
    return {name: value.item() if isinstance(value, np.generic) else value for name, value in fields.items()}


def _column(values):
    """Values (n,) of one field and which of them are missing, or None."""
    missing = np.array([value is None for value in values])
    kind = next((value for value in values if value is not None), 0.0)
    if isinstance(kind, str):
        return np.array([value or "" for value in values], object), missing
    filled = [0 if value is None else value for value in values]
    return np.array(filled, bool if isinstance(kind, bool) else float), missing


@contextlib.contextmanager
def _as_os_error(*kinds):
    try:
        yield
    except kinds as error:
        raise OSError(str(error)) from error
