"""QGIS styles: rasters in the classes of tables and pictures, vectors in the colours of the maps."""

from itertools import pairwise
from xml.etree import ElementTree as xml

from snowmpm.draft import write_text
from snowmpm.quantities.classes import GREYS, Classes, classes_of
from snowmpm.quantities.table import QUANTITIES

VERSION = "3.22.0"
"""Version of QGIS that defines these elements; later versions read them."""

LINES = {"affected_area": "#1d4f91", "release": "#101418", "deposit": "#6b7d8f", "thalweg": "#101418",
         "runout_line": "#e0201b", "runout_point": "#e0201b", "observed": "#19c5ff",
         "obstacles": "#8a8a8a", "dams": "#8a8a8a", "gauge_lines": "#7d1c6d", "gauge_points": "#7d1c6d"}
"""Colours of vector layers; pressure classes have those of their raster."""

NAMED = ("gauge_points", "gauge_lines", "obstacles", "dams")
"""Layers whose features are named on the map."""

DOCTYPE = "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
ZERO_IS_A_VALUE = "arrival_time"
"""Raster whose cells of 0 are drawn; in all others, 0 is a place without snow."""


def write_style(path, name, raster):
    """Write the .qml style of a raster of a run; QGIS applies it when it lies beside the raster. -> its path."""
    return _write(path, pipe(name, raster))


def write_style_of_shares(path, bounds, colours, clear):
    """Write the .qml style of a raster of shares from 0 to 1. bounds: one more than colours, of which None is not
    drawn; clear: value that is not drawn. -> its path."""
    labels = [f"{100.0 * low:g} to {100.0 * high:g} %" for low, high in pairwise(bounds)]
    return _write(path, _pipe([*bounds[1:-1], "inf"], labels, colours, 1.0, clear))


def _write(path, drawn):
    root = xml.Element("qgis", version=VERSION, styleCategories="Symbology")
    root.append(drawn)
    return write_text(path, document(root, DOCTYPE))


def vector_style(layer, drawn=None):
    """The style of a vector `Layer` as text of a .qml file; drawn: its renderer, by default that of its name."""
    root = xml.Element("qgis", version=VERSION, styleCategories="Symbology|Labeling|Fields",
                       labelsEnabled="1" if layer.name in NAMED else "0")
    root.append(renderer(layer) if drawn is None else drawn)
    root.extend(labels(layer))
    root.append(aliases(layer))
    return document(root, DOCTYPE)


def labels(layer):
    """The elements that write the names of features beside them; none for a layer without."""
    if layer.name not in NAMED:
        return
    settings = xml.Element("settings", calloutType="simple")
    text = xml.SubElement(settings, "text-style", fieldName="name", isExpression="0", fontFamily="Sans Serif",
                          fontSize="9", fontSizeUnit="Point", textColor=_colour(LINES[layer.name]), textOpacity="1")
    xml.SubElement(text, "text-buffer", bufferDraw="1", bufferSize="0.8", bufferSizeUnits="MM",
                   bufferColor=_colour("#ffffff"), bufferOpacity="1")
    # Around points, above and along lines, within areas
    place = "4" if "Polygon" in layer.geometry_type else "2" if "Line" in layer.geometry_type else "0"
    xml.SubElement(settings, "placement", placement=place, placementFlags="10", dist="1", distUnits="MM", priority="8")
    labeling = xml.Element("labeling", type="simple")
    labeling.append(settings)
    yield labeling


def aliases(layer):
    """The element that names the fields of a vector `Layer` in words, with their units."""
    root = xml.Element("aliases")
    for index, field in enumerate(layer.features[0][1]):
        if one := QUANTITIES.get(field):
            xml.SubElement(root, "alias", field=field, index=str(index), name=one.heading)
    return root


def grey():
    """The element that draws band 1 from 0, black, to 254, white; 255 is clear."""
    root = xml.Element("pipe")
    drawn = xml.SubElement(root, "rasterrenderer", type="singlebandgray", grayBand="1", gradient="BlackToWhite",
                           opacity="1", alphaBand="-1", nodataColor="")
    clear = xml.SubElement(xml.SubElement(drawn, "rasterTransparency"), "singleValuePixelList")
    xml.SubElement(clear, "pixelListEntry", min="255", max="255", percentTransparent="100")
    stretch = xml.SubElement(drawn, "contrastEnhancement")
    for tag, text in (("minValue", "0"), ("maxValue", "255"), ("algorithm", "StretchToMinimumMaximum")):
        xml.SubElement(stretch, tag).text = text
    xml.SubElement(root, "brightnesscontrast", brightness="0", contrast="0", gamma="1")
    xml.SubElement(root, "huesaturation", saturation="0")
    xml.SubElement(root, "rasterresampler", maxOversampling="2", zoomedInResampler="bilinear")
    return root


def document(root, doctype=""):
    """An XML element as text."""
    xml.indent(root)
    return f"{doctype}{xml.tostring(root, encoding='unicode')}\n"


def pipe(name, raster):
    """The element that draws band 1 in the classes of the raster `name` (a `snowmpm.io.Map`)."""
    finite = raster.values[raster.values > 0.0]
    largest = float(finite.max()) if finite.size else 1.0
    classes = classes_of(name, largest) or Classes(tuple(largest * k / 6.0 for k in range(1, 6)), GREYS,
                                                   unit=raster.units)
    return _pipe([*classes.limits, "inf"], [classes.label(k) for k in range(len(classes.colours))], classes.colours,
                 largest, None if name == ZERO_IS_A_VALUE else 0.0)


def pipe_of_classes(limits, labels, colours):
    """The element that draws band 1 in classes that begin at limits, one fewer than labels and colours; 0 is not
    drawn."""
    return _pipe([*limits, "inf"], labels, colours, float(limits[-1]), 0.0)


def outlined(layer, colour):
    """The element that draws the features of a `Layer` as outlines of a colour."""
    root = xml.Element("renderer-v2", type="singleSymbol", symbollevels="0", enableorderby="0", forceraster="0")
    xml.SubElement(root, "symbols").append(_symbol("0", layer.geometry_type, colour, fill=None))
    return root


def shaded():
    """The element that draws band 1, heights, under a light."""
    root = xml.Element("pipe")
    xml.SubElement(root, "rasterrenderer", type="hillshade", band="1", azimuth="315", angle="45", zfactor="1",
                   multidirection="0", opacity="1", alphaBand="-1")
    xml.SubElement(root, "brightnesscontrast", brightness="0", contrast="0", gamma="1")
    xml.SubElement(root, "huesaturation", saturation="0")
    xml.SubElement(root, "rasterresampler", maxOversampling="2")
    return root


def _pipe(ends, labels, colours, largest, clear):
    """The element that draws band 1 in classes below `ends`; clear: value that is not drawn, or None."""
    root = xml.Element("pipe")
    renderer = xml.SubElement(root, "rasterrenderer", type="singlebandpseudocolor", band="1", opacity="0.8",
                              alphaBand="-1", classificationMin="0", classificationMax=f"{largest:.6g}",
                              nodataColor="")
    if clear is not None:
        entries = xml.SubElement(xml.SubElement(renderer, "rasterTransparency"), "singleValuePixelList")
        xml.SubElement(entries, "pixelListEntry", min=f"{clear:g}", max=f"{clear:g}", percentTransparent="100")
    shader = xml.SubElement(xml.SubElement(renderer, "rastershader"), "colorrampshader", clip="0",
                            colorRampType="DISCRETE", classificationMode="1", minimumValue="0",
                            maximumValue=f"{largest:.6g}", labelPrecision="1")
    for end, colour, label in zip(ends, colours, labels, strict=True):
        # A discrete shader includes `value`, but these classes begin at their limit: take a value just below
        value = end if end == "inf" else f"{end * (1.0 - 1e-7):.12g}"
        xml.SubElement(shader, "item", value=value, label=label, color=colour or "#ffffff",
                       alpha="255" if colour else "0")
    xml.SubElement(root, "brightnesscontrast", brightness="0", contrast="0", gamma="1")
    xml.SubElement(root, "huesaturation", saturation="0")
    xml.SubElement(root, "rasterresampler", maxOversampling="2")
    return root


def renderer(layer):
    """The element that draws a vector `Layer`: pressure classes filled, other areas as outlines, lines, a point."""
    if layer.name == "pressure_classes":
        classes = classes_of("peak_pressure", 1e9)
        known = {classes.label(k): colour for k, colour in enumerate(classes.colours)}
        return categorised(layer, "class", fills=known)
    root = xml.Element("renderer-v2", type="singleSymbol", symbollevels="0", enableorderby="0", forceraster="0")
    symbols = xml.SubElement(root, "symbols")
    symbols.append(_symbol("0", layer.geometry_type, LINES[layer.name], fill=None, dashed=layer.name == "thalweg"))
    return root


def categorised(layer, field, fills=None, lines=None):
    """The element that draws the features of a `Layer` by a field: {value: colour} of areas or of their outlines."""
    root = xml.Element("renderer-v2", type="categorizedSymbol", attr=field, symbollevels="0", enableorderby="0",
                       forceraster="0")
    categories, symbols = xml.SubElement(root, "categories"), xml.SubElement(root, "symbols")
    for k, value in enumerate(dict.fromkeys(fields[field] for _, fields in layer.features)):
        xml.SubElement(categories, "category", symbol=str(k), value=value, label=value, render="true")
        line, fill = ("#404040", fills.get(value, "#c0c0c0")) if lines is None else (lines[value], None)
        symbols.append(_symbol(str(k), layer.geometry_type, line, fill))
    return root


def _symbol(name, geometry_type, line, fill, dashed=False):
    kind = "fill" if "Polygon" in geometry_type else "line" if "Line" in geometry_type else "marker"
    root = xml.Element("symbol", name=name, type=kind, alpha="1", clip_to_extent="1", force_rhr="0")
    if kind == "fill":
        options = {"color": _colour(fill or line, 190 if fill else 0), "style": "solid" if fill else "no",
                   "outline_color": _colour(line), "outline_style": "solid", "outline_width": "0.2" if fill else "0.6",
                   "outline_width_unit": "MM"}
        layer = {"class": "SimpleFill"}
    elif kind == "line":
        options = {"line_color": _colour(line), "line_style": "dash" if dashed else "solid", "line_width": "0.6",
                   "line_width_unit": "MM"}
        layer = {"class": "SimpleLine"}
    else:
        options = {"color": _colour(line), "name": "circle", "outline_color": _colour("#ffffff"), "size": "3",
                   "size_unit": "MM"}
        layer = {"class": "SimpleMarker"}
    body = xml.SubElement(root, "layer", **layer, enabled="1", locked="0", **{"pass": "0"})
    option = xml.SubElement(body, "Option", type="Map")
    for key, value in options.items():
        xml.SubElement(option, "Option", name=key, type="QString", value=value)
    return root


def _colour(text, alpha=255):
    """#rrggbb as QGIS has it: r,g,b,a."""
    return ",".join([*(str(int(text[i : i + 2], 16)) for i in (1, 3, 5)), str(alpha)])
