"""The print layout of a QGIS project: a sheet A4 with the map, its legend, scale, north and what the run was."""

import math
from xml.etree import ElementTree as xml

PAGE, MAP, LEGEND, SCALE, NUMBER, NORTH, TITLE, TEXT = (
    (297.0, 210.0), (8.0, 18.0, 209.0, 160.0), (219.0, 18.0, 70.0, 160.0), (12.0, 162.0, 60.0, 13.0),
    (219.0, 170.0, 40.0, 7.0), (202.0, 20.0, 13.0, 17.0), (8.0, 6.0, 281.0, 10.0), (8.0, 181.0, 281.0, 25.0))
"""Width and height of the page; left, top, width and height of its items [mm]."""
MAP_ID = "{5a0f0001-0000-4000-8000-736e6f776d70}"
"""By which legend, scale and north find their map."""
KINDS = {"page": 65638, "map": 65639, "picture": 65640, "label": 65641, "legend": 65642, "scale bar": 65646}
"""Types of layout items in QGIS 3."""
ARROW = ":/images/north_arrows/layout_default_north_arrow.svg"
"""It ships inside QGIS."""


def add_layout(root, name, extent, shown, text):
    """Add a layout to the root of a project. extent: (west, south, east, north) [m] that the map holds; shown: elements
    of the layers of the legend, as of the project's tree, from the top; text: below the map."""
    layout = xml.SubElement(xml.SubElement(root, "Layouts"), "Layout", name=f"{name}, A4", units="mm",
                            printResolution="300")
    pages = xml.SubElement(layout, "PageCollection")
    pages.append(_fill())
    _item(pages, "page", (0.0, 0.0, *PAGE)).append(_fill())
    place = _item(layout, "map", MAP, uuid=MAP_ID, templateUuid=MAP_ID, frame="true", background="true",
                  keepLayerSet="false", followPreset="false", mapRotation="0")
    west, _, east, _ = shown_extent = _widened(extent)
    xml.SubElement(place, "Extent", **{side: f"{value:.3f}" for side, value in zip(
        ("xmin", "ymin", "xmax", "ymax"), shown_extent, strict=True)})
    _legend(layout, shown)
    scale = _item(layout, "scale bar", SCALE, mapUuid=MAP_ID, style="Single Box", unitType="meters", unitLabel="m",
          numUnitsPerSegment=f"{_round(0.15 * (east - west)):g}", numMapUnitsPerScaleBarUnit="1",
          numSegments="2", numSegmentsLeft="0", segmentSizeMode="0", height="3")
    number = _item(layout, "scale bar", NUMBER, mapUuid=MAP_ID, style="Numeric", unitType="meters")
    for item in (scale, number):
        xml.SubElement(item, "text-style", fontFamily="Sans Serif", fontSize="9", fontSizeUnit="Point",
                       textColor="0,0,0,255")
        whole = xml.SubElement(xml.SubElement(item, "numericFormat", id="basic"), "Option", type="Map")
        xml.SubElement(whole, "Option", name="decimals", type="int", value="0")
        xml.SubElement(whole, "Option", name="show_thousand_separator", type="bool", value="false")
    _item(layout, "picture", NORTH, mapUuid=MAP_ID, file=ARROW, mode="0", northMode="0", resizeMode="0")
    _label(layout, TITLE, name, 16)
    _label(layout, TEXT, text, 8)


def _item(parent, kind, box, **more):
    left, top, width, height = box
    place = f"{left:g},{top:g},mm"
    return xml.SubElement(parent, "LayoutItem", type=str(KINDS[kind]), id=kind, position=place, positionOnPage=place,
                          size=f"{width:g},{height:g},mm", opacity="1", visibility="1",
                          **{"background": "false", "frame": "false", **more})


def _fill():
    """The symbol of a white page."""
    symbol = xml.Element("symbol", type="fill", name="", alpha="1", clip_to_extent="1", force_rhr="0")
    layer = xml.SubElement(symbol, "layer", **{"class": "SimpleFill", "enabled": "1", "locked": "0", "pass": "0"})
    options = xml.SubElement(layer, "Option", type="Map")
    for key, value in (("color", "255,255,255,255"), ("style", "solid"), ("outline_style", "no")):
        xml.SubElement(options, "Option", name=key, type="QString", value=value)
    return symbol


def _legend(layout, shown):
    legend = _item(layout, "legend", LEGEND, map_uuid=MAP_ID, background="true", resizeToContents="1", columnCount="1",
                   legendFilterByAtlas="0", symbolWidth="6", symbolHeight="3.5", boxSpace="1", title="")
    styles = xml.SubElement(legend, "styles")
    for style, size, above in (("title", 12, 0.0), ("group", 10, 2.0), ("subgroup", 9, 2.5), ("symbol", 8, 1.0),
                               ("symbolLabel", 8, 1.0)):
        own = xml.SubElement(styles, "style", name=style, alignment="1", indent="0", marginTop=f"{above:g}",
                             marginLeft="2" if style == "symbolLabel" else "0")
        _font(own, "styleFont", size)
    tree = xml.SubElement(legend, "layer-tree-group")
    tree.extend(shown)


def _label(layout, box, text, size):
    text = text.replace("[%", "[ %")  # what QGIS would compute: names come from anybody
    item = _item(layout, "label", box, labelText=text, halign="1", valign="32", htmlState="0", marginX="0",
                 marginY="0")
    _font(item, "LabelFont", size)


def _font(parent, tag, size):
    """A font of the reader's machine [points]."""
    xml.SubElement(parent, tag, description=f"Sans Serif,{size},-1,5,50,0,0,0,0,0", style="")


def _widened(extent):
    """The extent with a margin, in the shape of the map on the sheet and at a round scale."""
    west, south, east, north = extent
    least = 1.05e3 * max((east - west) / MAP[2], (north - south) / MAP[3])
    power = 10.0 ** math.floor(math.log10(least))
    scale = next(round(factor * power) for factor in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
                 if factor * power >= least)
    width, height = 1e-3 * scale * MAP[2], 1e-3 * scale * MAP[3]
    x, y = 0.5 * (west + east), 0.5 * (south + north)
    return x - 0.5 * width, y - 0.5 * height, x + 0.5 * width, y + 0.5 * height


def _round(length):
    """The largest of 1, 2, 5, 10, 20 ... that is not above a length."""
    power = 1e-3
    while 10.0 * power <= length:
        power *= 10.0
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= length)
