"""A QGIS project of the maps of a region: maps/region.qgs, with the overviews of its rasters."""

from pathlib import Path

import shapely

from snowmpm.draft import write_text
from snowmpm.gis import qgis_project
from snowmpm.gis.layers import Layer
from snowmpm.gis.qgis_style import DOCTYPE, document, outlined, pipe_of_classes, shaded
from snowmpm.quantities.classes import GREYS, OF_MAP, PRESSURE
from snowmpm.region import maps, page, plan
from snowmpm.region.elevations import open_elevations
from snowmpm.region.outlines import class_names
from snowmpm.region.release_areas import LAYER
from snowmpm.region.zones import ZONES

FILE = "region.qgs"

def write(setting, folder):
    """Write the project; -> its path."""
    wkt = setting.wkt or qgis_project.LOCAL
    root, tree, layers = qgis_project.begin(setting.file.name.replace("_", " "), wkt)
    by_period = sorted(setting.file.scenarios, key=lambda name: -setting.file.scenarios[name].period)
    for name in by_period:
        vector = Layer(LAYER, "MultiPolygon", [(shapely.MultiPolygon(), {})])
        qgis_project.add_layer(tree, layers, f"areas_{name}", f"release areas, {name}",
                               f"../{plan.areas_file('', name).name}|layername={LAYER}", wkt,
                               [outlined(vector, page.AREAS)], vector, False)
    for one in sorted(maps.rasters(setting), key=lambda one: -_period(setting, one)):
        shown = one.name == f"intensity_{by_period[0]}"
        title = f"{one.name.replace('_', ' ')} [{one.unit}]"
        qgis_project.add_layer(tree, layers, one.name, title, f"./{one.name}.tif", wkt, [_drawn(setting, one)], None,
                               shown)
    qgis_project.add_layer(tree, layers, "terrain", "terrain", f"../{plan.TERRAIN}", wkt, [shaded()], None, True, False)
    with open_elevations(setting.terrain) as elevations:
        qgis_project.end(root, wkt, elevations.grid.bounds)
    return write_text(Path(folder) / FILE, document(root, DOCTYPE))


def _period(setting, one):
    return setting.file.scenarios[one.scenario].period if one.scenario else 0.0


def _drawn(setting, one):
    """The element that draws a map."""
    if one.name == maps.ZONE:
        zoning = ZONES[setting.file.zones]
        return pipe_of_classes([k + 1.5 for k in range(len(zoning.names))][:-1], zoning.names, zoning.colours)
    if one.kind == "uint8":
        names = class_names(setting.file.pressures)
        colours = PRESSURE.colours[: len(names)]
        return pipe_of_classes([k + 0.5 for k in names][:-1], [words for words, *_ in names.values()], colours)
    kind = one.name.removesuffix(f"_{one.scenario}") if one.scenario else one.name
    if kind in OF_MAP:
        classes = OF_MAP[kind]
        return pipe_of_classes(classes.limits, [classes.label(k) for k in range(len(classes.colours))], classes.colours)
    if one.unit == "1/year":
        words = ["< 1/300", "1/300 or more", "1/100 or more", "1/30 or more", "1/10 or more"]
        return pipe_of_classes(page.FREQUENT, words, page.FREQUENT_COLOURS)
    limits = (0.2, 0.4, 0.6, 0.8, 0.95) if one.unit == "share" else (1.5, 2.5, 4.5, 8.5, 16.5)
    words = [f"up to {limit:g}" for limit in limits] + ["more"]
    return pipe_of_classes(limits, words, GREYS)
