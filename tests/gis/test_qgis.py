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


def test_names_are_no_expressions_of_qgis(straight, tmp_path, monkeypatch):
    """Runs come from anybody: QGIS would compute what stands between [% and %] of a label, such as a variable of the
    system."""
    monkeypatch.setitem(straight.provenance, "scene_name", "[% env('HOME') %]")
    path = write_project(tmp_path / "avalanche.qgs", straight, layers_of(straight), "avalanche.gpkg")
    root = xml.parse(path).getroot()
    texts = [item.get("labelText") for item in root.iter("LayoutItem") if item.get("labelText")]
    assert len(texts) == 2 and "env('HOME')" in texts[0] and not any("[%" in text for text in texts)


def test_a_raster_without_classes_is_drawn_in_greys(straight, tmp_path):
    raster = straight.maps["peak_depth"]
    root = xml.parse(write_style(tmp_path / "x.qml", "unheard_of", raster)).getroot()
    assert len(root.findall("pipe/rasterrenderer/rastershader/colorrampshader/item")) == 6


def test_the_sheet_has_a_round_scale_that_holds_the_flow(project, straight):
    """480 m over 209 mm need 1:2412 at least, with its margin: 1:2500; the bar is 150 m, 0.15 of the map."""
    extent = project[1].find(".//LayoutItem[@id='map']/Extent")
    west, south, east, north = (float(extent.get(side)) for side in ("xmin", "ymin", "xmax", "ymax"))
    assert (east - west) / 0.209 == pytest.approx(2500.0) and (north - south) / 0.160 == pytest.approx(2500.0)
    x0 = straight.origin[0]
    assert west < x0 + 20.0 and east > x0 + 500.0
    bar = project[1].find(".//LayoutItem[@style='Single Box']")
    assert bar.get("numUnitsPerSegment") == "50"


def test_what_was_named_is_named_on_the_map(straight, tmp_path):
    """Gauges, dams and obstacles, in the project and in the styles of the GeoPackage; nothing else."""
    import shapely

    from snowmpm.gis import vector_style
    from snowmpm.gis.layers import Layer

    road = Layer("gauge_lines", "LineString", [(shapely.LineString([(0, 0), (1, 1)]), {"name": "road"})])
    path = write_project(tmp_path / "avalanche.qgs", straight, [*layers_of(straight), road], "avalanche.gpkg")
    found = {layer.findtext("id"): layer for layer in xml.parse(path).getroot().iter("maplayer")
             if layer.get("labelsEnabled") == "1"}
    assert list(found) == ["gauge_lines_vector"]
    assert found["gauge_lines_vector"].find("labeling/settings/text-style").get("fieldName") == "name"
    assert 'labelsEnabled="1"' in vector_style(road) and 'labelsEnabled="0"' in vector_style(layers_of(straight)[0])


def test_styles_put_values_into_the_classes_of_the_table(straight, tmp_path):
    for name, raster in straight.maps.items():
        root = xml.parse(write_style(tmp_path / f"{name}.qml", name, raster)).getroot()
        items = root.findall("pipe/rasterrenderer/rastershader/colorrampshader/item")
        ends = np.array([float(item.get("value")) for item in items])
        classes = classes_of(name, float(np.nanmax(raster.values)))
        for value in (*classes.limits, 0.5 * classes.limits[0], 1.5 * classes.limits[-1]):
            drawn = items[int((value <= ends).argmax())]  # the first whose value is not below
            assert drawn.get("label") == classes.label(int(np.searchsorted(classes.limits, value, side="right")))
