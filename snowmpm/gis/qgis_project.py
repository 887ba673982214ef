"""A QGIS project that opens the rasters and vectors of a run with styles; it refers to files beside it."""

from pathlib import Path
from xml.etree import ElementTree as xml

from snowmpm.draft import write_text
from snowmpm.gis.qgis_style import VERSION, document, pipe, renderer
from snowmpm.gis.temporal import add_moments
from snowmpm.io.projection import epsg_of
from snowmpm.quantities.table import quantity

SHOWN = ("gauge_points", "gauge_lines", "runout_point", "runout_line", "obstacles", "dams", "thalweg", "observed",
         "release", "affected_area", "peak_pressure")
"""Layers visible when the project opens."""

ORDER = ("gauge_points", "gauge_lines", "runout_point", "runout_line", "obstacles", "dams", "thalweg", "observed",
         "release", "affected_area", "deposit", "pressure_classes")


def write_project(path, run, layers, geopackage, moments=()):
    """Write a .qgs project for the GeoTIFFs beside it, named after the maps of a `Run`, and the `layers` in the file
    `geopackage` beside it; moments: `temporal.Moment`s, layers of a group that the time slider shows. -> its path."""
    path, wkt = Path(path), run.provenance.get("crs")
    root = xml.Element("qgis", version=VERSION, projectname=run.name)
    xml.SubElement(root, "homePath", path="")
    xml.SubElement(root, "title").text = run.name
    if wkt:
        xml.SubElement(root, "projectCrs").append(_system(wkt))
    tree, found = xml.SubElement(root, "layer-tree-group"), xml.SubElement(root, "projectlayers")
    vectors = {layer.name: layer for layer in layers}
    for name in (*(name for name in ORDER if name in vectors), *run.maps):
        vector = vectors.get(name)
        source = f"./{Path(geopackage).name}|layername={name}" if vector else f"./{name}.tif"
        provider, title = ("ogr" if vector else "gdal"), name.replace("_", " ") if vector else quantity(name).label
        identity = f"{name}_{'vector' if vector else 'raster'}"
        xml.SubElement(tree, "layer-tree-layer", id=identity, name=title, source=source, providerKey=provider,
                       checked="Qt::Checked" if name in SHOWN else "Qt::Unchecked", expanded="0")
        layer = xml.SubElement(found, "maplayer", type="vector" if vector else "raster",
                               **({"geometry": _geometry(vector), "wkbType": vector.geometry_type} if vector else {}))
        for tag, text in (("id", identity), ("datasource", source), ("layername", title)):
            xml.SubElement(layer, tag).text = text
        xml.SubElement(layer, "provider", encoding="UTF-8" if vector else "").text = provider
        if wkt:
            xml.SubElement(layer, "srs").append(_system(wkt))
        layer.append(renderer(vector) if vector else pipe(name, run.maps[name]))
    add_moments(root, tree, found, moments, wkt and (lambda: _system(wkt)))
    canvas = xml.SubElement(root, "mapcanvas", name="theMapCanvas", annotationsVisible="1")
    xml.SubElement(canvas, "units").text = "meters"
    extent = xml.SubElement(canvas, "extent")
    for tag, value in zip(("xmin", "ymin", "xmax", "ymax"), _extent(run), strict=True):
        xml.SubElement(extent, tag).text = f"{value:.3f}"
    if wkt:
        xml.SubElement(canvas, "destinationsrs").append(_system(wkt))
    properties = xml.SubElement(root, "properties")
    paths = xml.SubElement(properties, "Paths")
    xml.SubElement(paths, "Absolute", type="bool").text = "false"
    return write_text(path, document(root, "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"))


def _system(wkt):
    """The element of a projection: its well-known text, and its EPSG code where it has one."""
    root, code = xml.Element("spatialrefsys", nativeFormat="Wkt"), epsg_of(wkt)
    xml.SubElement(root, "wkt").text = wkt
    if code:
        xml.SubElement(root, "srid").text = str(code)
        xml.SubElement(root, "authid").text = f"EPSG:{code}"
    return root


def _geometry(layer):
    return "Polygon" if "Polygon" in layer.geometry_type else "Line" if "Line" in layer.geometry_type else "Point"


def _extent(run):
    """Extent (west, south, east, north) [m] of the run's maps."""
    raster = next(iter(run.maps.values()))
    rows, columns = raster.values.shape
    west, south = run.origin[0] + raster.x0 - 0.5 * raster.cell, run.origin[1] + raster.y0 - 0.5 * raster.cell
    return west, south, west + columns * raster.cell, south + rows * raster.cell
