"""Layers of a QGIS project for the time slider: a raster for each moment of a run.

The clock of QGIS has a date: a run begins at `BEGIN`, and its seconds count from there.
"""

import datetime
from dataclasses import dataclass
from xml.etree import ElementTree as xml

from snowmpm.gis.qgis_style import pipe
from snowmpm.io.ground_maps import Map

BEGIN = datetime.datetime(2000, 1, 1, tzinfo=datetime.timezone.utc)
FIXED = "0"
"""Mode of temporal properties: a layer is shown within one range of time."""


@dataclass(frozen=True)
class Moment:
    """A raster at a time of a run: name of its classes, title of its group, file beside the project, begin and end [s]
    of what it stands for."""

    name: str
    title: str
    file: str
    raster: Map
    begin: float
    end: float


def clock(seconds):
    """A time of a run [s] on the clock of QGIS, to the second."""
    return (BEGIN + datetime.timedelta(seconds=round(seconds))).strftime("%Y-%m-%dT%H:%M:%SZ")


def add_moments(root, tree, found, moments, system):
    """Add `Moment`s to a project: to its tree in a group a title, to its layers, and their span to its time settings;
    system(): the element of their projection, or None."""
    if not moments:
        return
    groups = {}
    for moment in moments:
        if moment.title not in groups:
            # Without the time slider, QGIS draws all of them over the rest
            groups[moment.title] = xml.SubElement(tree, "layer-tree-group", name=moment.title, expanded="0",
                                                  checked="Qt::Unchecked")
        identity = moment.file.removesuffix(".tif").replace("/", "_")
        source, title = f"./{moment.file}", f"{moment.title}, t = {moment.begin:g} s"
        xml.SubElement(groups[moment.title], "layer-tree-layer", id=identity, name=title, source=source,
                       providerKey="gdal", checked="Qt::Checked", expanded="0")
        layer = xml.SubElement(found, "maplayer", type="raster")
        for tag, text in (("id", identity), ("datasource", source), ("layername", title)):
            xml.SubElement(layer, tag).text = text
        xml.SubElement(layer, "provider", encoding="").text = "gdal"
        if system:
            xml.SubElement(layer, "srs").append(system())
        temporal = xml.SubElement(layer, "temporal", enabled="1", mode=FIXED, fetchMode="0")
        _range(xml.SubElement(temporal, "fixedRange"), moment.begin, moment.end)
        layer.append(pipe(moment.name, moment.raster))
    begin, end = min(one.begin for one in moments), max(one.end for one in moments)
    step = min(one.end - one.begin for one in moments)
    settings = xml.SubElement(root, "ProjectTimeSettings", timeStep=str(max(1, round(step))), timeStepUnit="s",
                              frameRate="4", cumulativeTemporalRange="0")
    _range(xml.SubElement(settings, "TemporalRange"), begin, end)


def _range(element, begin, end):
    """Both ends belong to a range of QGIS: it ends a second before the next one begins."""
    xml.SubElement(element, "start").text = clock(begin)
    xml.SubElement(element, "end").text = clock(max(round(end) - 1, round(begin)))
