"""QGIS styles and project: well-formed, of the right classes, naming files that are there."""

from xml.etree import ElementTree as xml

import numpy as np
import pytest

from snowmpm.gis import layers_of, write_geopackage, write_project, write_style
from snowmpm.io.geotiff import write_geotiff
from snowmpm.quantities.classes import PRESSURE, classes_of
from tests.support.straight_avalanche import LAMBERT


@pytest.fixture(scope="module")
def project(straight, tmp_path_factory):
    """Folder with a project and all that it names; its root element."""
    folder, crs = tmp_path_factory.mktemp("project"), straight.provenance["crs"]
    layers = layers_of(straight)
    for name, raster in straight.maps.items():
        write_geotiff(folder / f"{name}.tif", raster, straight.origin, crs)
    write_geopackage(folder / "avalanche.gpkg", layers, crs)
    path = write_project(folder / "avalanche.qgs", straight, layers, folder / "avalanche.gpkg")
    return folder, xml.parse(path).getroot()


def test_every_layer_of_the_project_is_there_under_a_relative_path(project, straight):
    import pyogrio
    import rasterio

    folder, root = project
    layers = root.findall("projectlayers/maplayer")
    assert len(layers) == len(straight.maps) + 7
    for layer in layers:
        source, kind = layer.findtext("datasource"), layer.findtext("provider")
        assert source.startswith("./")
        file, _, inner = source.removeprefix("./").partition("|layername=")
        if kind == "gdal":
            with rasterio.open(folder / file) as raster:
                assert raster.crs.to_epsg() == LAMBERT
            assert layer.find("pipe/rasterrenderer") is not None
        else:
            assert kind == "ogr" and inner in {name for name, _ in pyogrio.list_layers(folder / file)}
            assert layer.find("renderer-v2/symbols/symbol") is not None
        assert layer.findtext("srs/spatialrefsys/authid") == f"EPSG:{LAMBERT}"
    identities = [layer.findtext("id") for layer in layers]
    leaves = root.find("layer-tree-group").iter("layer-tree-layer")
    assert [leaf.get("id") for leaf in leaves] == identities == list(dict.fromkeys(identities))
    assert root.findtext("properties/Paths/Absolute") == "false"
    assert root.findtext("projectCrs/spatialrefsys/srid") == str(LAMBERT)
    west, south, east, north = (float(root.findtext(f"mapcanvas/extent/{side}")) for side in
                                ("xmin", "ymin", "xmax", "ymax"))
    assert (east - west, north - south) == (800.0, 200.0)


def test_pressure_classes_have_the_colours_of_the_picture(project):
    root = project[1]
    layer = next(one for one in root.iter("maplayer") if one.findtext("id") == "pressure_classes_vector")
    labels = {one.get("value"): one.get("symbol") for one in layer.iter("category")}
    assert set(labels) == {"3 to 10 kPa", "30 to 100 kPa"}
    symbol = next(one for one in layer.iter("symbol") if one.get("name") == labels["3 to 10 kPa"])
    fill = next(one.get("value") for one in symbol.iter("Option") if one.get("name") == "color")
    assert fill.split(",")[:3] == [str(int(PRESSURE.colours[2][i : i + 2], 16)) for i in (1, 3, 5)]


def test_styles_put_values_into_the_classes_of_the_table(straight, tmp_path):
    for name, raster in straight.maps.items():
        root = xml.parse(write_style(tmp_path / f"{name}.qml", name, raster)).getroot()
        items = root.findall("pipe/rasterrenderer/rastershader/colorrampshader/item")
        ends = np.array([float(item.get("value")) for item in items])
        classes = classes_of(name, float(np.nanmax(raster.values)))
        for value in (*classes.limits, 0.5 * classes.limits[0], 1.5 * classes.limits[-1]):
            drawn = items[int((value <= ends).argmax())]  # the first whose value is not below
            assert drawn.get("label") == classes.label(int(np.searchsorted(classes.limits, value, side="right")))
