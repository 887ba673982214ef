"""A QGIS project that opens the rasters and vectors of a run with styles; it refers to files beside it."""

from pathlib import Path
from xml.etree import ElementTree as xml

import numpy as np

from snowmpm.draft import write_text
from snowmpm.gis.qgis_layout import add_layout
from snowmpm.gis.qgis_style import DOCTYPE, NAMED, VERSION, aliases, document, grey, labels, pipe, renderer
from snowmpm.gis.temporal import add_moments
from snowmpm.io.parameters import parameters
from snowmpm.io.projection import epsg_of, projection_name
from snowmpm.io.published import statement
from snowmpm.io.status import status_of
from snowmpm.quantities.table import quantity

SHOWN = ("gauge_points", "gauge_lines", "runout_point", "runout_line", "obstacles", "dams", "thalweg", "observed",
         "release", "affected_area", "peak_pressure", "hillshade")
"""Layers visible when the project opens."""

ORDER = ("gauge_points", "gauge_lines", "runout_point", "runout_line", "obstacles", "dams", "thalweg", "observed",
         "release", "affected_area", "deposit", "pressure_classes")

SHADE = "hillshade"
"""Raster of the shaded ground, below all others."""

LOCAL = ('ENGCRS["coordinates of the scene",EDATUM["coordinates of the scene"],CS[Cartesian,2],AXIS["x",east,ORDER[1]],'
         'AXIS["y",north,ORDER[2]],LENGTHUNIT["metre",1]]')
"""System of a run without a projection: metres, without a place on Earth. Without one QGIS measures in degrees."""


def write_project(path, run, layers, geopackage, moments=(), shaded=False):
    """Write a .qgs project for the GeoTIFFs beside it, named after the maps of a `Run`, and the `layers` in the file
    `geopackage` beside it; -> its path.

    moments: `temporal.Moment`s, layers of a group that the time slider shows; shaded: whether the shaded ground lies
    beside it as hillshade.tif.
    """
    path, wkt = Path(path), run.provenance.get("crs") or LOCAL
    root, tree, found = begin(run.name.replace("_", " "), wkt)
    vectors = {layer.name: layer for layer in layers}
    shown = []
    for name in (*(name for name in ORDER if name in vectors), *run.maps, *([SHADE] if shaded else ())):
        vector = vectors.get(name)
        source = f"./{Path(geopackage).name}|layername={name}" if vector else f"./{name}.tif"
        drawn = [renderer(vector), *labels(vector), aliases(vector)] if vector else [
            grey() if name == SHADE else pipe(name, run.maps[name])]
        leaf = add_layer(tree, found, name, _title(name, vector, run), source, wkt, drawn, vector, name in SHOWN,
                         name != SHADE)
        if name in SHOWN and name != SHADE:
            shown.append(leaf)
    add_moments(root, tree, found, moments, lambda: _system(wkt))
    end(root, wkt, _extent(run))
    add_layout(root, run.name.replace("_", " "), _extent(run, filled=True), shown, _margin(run))
    return write_text(path, document(root, DOCTYPE))


def begin(title, wkt):
    """(root, layer tree, layers) of a new project."""
    root = xml.Element("qgis", version=VERSION, projectname=title)
    xml.SubElement(root, "homePath", path="")
    xml.SubElement(root, "title").text = title
    xml.SubElement(root, "projectCrs").append(_system(wkt))
    return root, xml.SubElement(root, "layer-tree-group"), xml.SubElement(root, "projectlayers")


def add_layer(tree, layers, name, title, source, wkt, drawn, vector=None, shown=True, legend=True):
    """Add a layer to a project; -> its element in the tree.

    source: file relative to the project; drawn: elements of its style; vector: its `Layer`, None of a raster; shown:
    whether it is visible when the project opens; legend: whether the classes of a raster are listed.
    """
    provider, identity = ("ogr" if vector else "gdal"), f"{name}_{'vector' if vector else 'raster'}"
    leaf = xml.SubElement(tree, "layer-tree-layer", id=identity, name=title, source=source, providerKey=provider,
                          checked="Qt::Checked" if shown else "Qt::Unchecked",
                          expanded="1" if shown and not vector and legend else "0")
    layer = xml.SubElement(layers, "maplayer", type="vector" if vector else "raster",
                           **({"geometry": _geometry(vector), "wkbType": vector.geometry_type,
                               "labelsEnabled": "1" if name in NAMED else "0"} if vector else {}))
    for tag, text in (("id", identity), ("datasource", source), ("layername", title)):
        xml.SubElement(layer, tag).text = text
    xml.SubElement(layer, "provider", encoding="UTF-8" if vector else "").text = provider
    xml.SubElement(layer, "srs").append(_system(wkt))
    layer.extend(drawn)
    if not vector:
        _hide_band(leaf, layer)
    return leaf


def end(root, wkt, extent):
    """Complete a project. extent: west, south, east, north [m] that it opens with."""
    canvas = xml.SubElement(root, "mapcanvas", name="theMapCanvas", annotationsVisible="1")
    xml.SubElement(canvas, "units").text = "meters"
    box = xml.SubElement(canvas, "extent")
    for tag, value in zip(("xmin", "ymin", "xmax", "ymax"), extent, strict=True):
        xml.SubElement(box, tag).text = f"{value:.3f}"
    xml.SubElement(canvas, "destinationsrs").append(_system(wkt))
    properties = xml.SubElement(root, "properties")
    paths = xml.SubElement(properties, "Paths")
    xml.SubElement(paths, "Absolute", type="bool").text = "false"
    # Without this, QGIS takes the project for one without a projection, whatever its projectCrs says
    reference = xml.SubElement(properties, "SpatialRefSys")
    xml.SubElement(reference, "ProjectionsEnabled", type="int").text = "1"


def _hide_band(leaf, layer):
    """Leave the line "Band 1: ... (Gray)" out of a raster's legend: only its classes are shown."""
    classes = len(layer.findall("pipe/rasterrenderer/rastershader/colorrampshader/item"))
    options = xml.SubElement(xml.SubElement(leaf, "customproperties"), "Option", type="Map")
    xml.SubElement(options, "Option", name="legend/node-order", type="QString",
                   value=",".join(map(str, range(1, classes + 1))))


def _title(name, vector, run):
    """Name of a layer: in words, of a raster with the unit of its values."""
    if name == SHADE:
        return "terrain"
    if vector:
        return name.replace("_", " ").replace("runout", "run-out")
    return quantity(name, run.maps[name].units).heading


def _margin(run):
    """Text below the map on the sheet."""
    facts = ", ".join(f"{name}: {text}" for name, text in parameters(run).items() if name != "scene")
    projection = projection_name(run.provenance.get("crs")) or "no projection known: coordinates of the scene"
    status = status_of(run).text.rstrip(".")
    return "\n".join([f"{statement(run)} Run: {status}.", f"{facts}.", f"Projection: {projection}."])


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


def _extent(run, filled=False):
    """Extent (west, south, east, north) [m] of the run's maps; filled: of where snow ever was."""
    raster = run.maps.get("peak_depth") or next(iter(run.maps.values()))
    rows, columns = raster.values.shape
    first, last = (0, 0), (rows - 1, columns - 1)
    if filled and (there := np.argwhere(np.nan_to_num(raster.values) > 0.0)).size:
        first, last = there.min(axis=0), there.max(axis=0)
    west, south = run.origin[0] + raster.x0 - 0.5 * raster.cell, run.origin[1] + raster.y0 - 0.5 * raster.cell
    return (west + first[1] * raster.cell, south + first[0] * raster.cell, west + (last[1] + 1) * raster.cell,
            south + (last[0] + 1) * raster.cell)
