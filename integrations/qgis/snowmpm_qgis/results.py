"""Results in the project: layers with the styles of snowmpm, in a group."""

import os

from osgeo import gdal
from qgis.core import (
    QgsCoordinateTransform,
    QgsLayerTreeGroup,
    QgsLayerTreeLayer,
    QgsProject,
    QgsRasterLayer,
    QgsVectorLayer,
)


def add_project(path, project, parent, keep=None):
    """Add the layers of a project that snowmpm wrote to another project, under a node of its tree, in order, with
    styles, visibility and legends; -> them. keep: takes the name of a layer."""
    read, added = QgsProject(), []
    if not read.read(path):
        return added
    _copy(read.layerTreeRoot(), parent, project, added, keep)
    return added


def add_run(maps, name, project, looked_at=("affected area",)):
    """Add the maps of a run in a group of its name; -> the layers to look at."""
    group = new_group(project, name)
    added = add_project(os.path.join(maps, "avalanche.qgs"), project, group)
    return [layer for layer in added if layer.name() in looked_at]


def _copy(node, parent, project, added, keep):
    for child in node.children():
        if isinstance(child, QgsLayerTreeGroup):
            group = parent.addGroup(child.name())
            group.setItemVisibilityChecked(child.itemVisibilityChecked())
            group.setExpanded(False)
            _copy(child, group, project, added, keep)
        elif child.layer() is not None and (keep is None or keep(child.name())):
            layer = child.layer().clone()
            project.addMapLayer(layer, False)
            leaf = QgsLayerTreeLayer(layer)
            leaf.setItemVisibilityChecked(child.itemVisibilityChecked())
            leaf.setExpanded(child.isExpanded())
            for name in child.customProperties():  # before it is in the tree, whose legend takes them then
                leaf.setCustomProperty(name, child.customProperty(name))
            parent.addChildNode(leaf)
            added.append(layer)


def add_raster(path, project, parent, shown):
    """Add a GeoTIFF with the style beside it, under the name that its band has; -> the layer."""
    opened = gdal.Open(path)  # a band without its dataset ends QGIS
    name = opened.GetRasterBand(1).GetDescription()
    return _add(QgsRasterLayer(path, name or os.path.basename(path)), project, parent, shown)


def add_vector(path, inner, name, project, parent, shown, at_top=False):
    """Add a layer of a GeoPackage with the style that it brings; -> the layer."""
    return _add(QgsVectorLayer(f"{path}|layername={inner}", name, "ogr"), project, parent, shown, at_top)


def _add(layer, project, parent, shown, at_top=False):
    if not layer.isValid():
        return None
    project.addMapLayer(layer, False)
    leaf = parent.insertLayer(0, layer) if at_top else parent.addLayer(layer)
    leaf.setItemVisibilityChecked(shown)
    leaf.setExpanded(shown)
    return layer


def new_group(project, name):
    """A group at the top of the layers of a project."""
    root = project.layerTreeRoot()
    return root.insertGroup(0, name)


def show(layers):
    """Move the map to layers, where QGIS has a window."""
    try:
        from qgis.utils import iface
    except ImportError:
        return
    if iface is None or not layers:
        return
    canvas, extent = iface.mapCanvas(), None
    for layer in layers:
        change = QgsCoordinateTransform(layer.crs(), canvas.mapSettings().destinationCrs(), QgsProject.instance())
        box = change.transformBoundingBox(layer.extent())
        extent = box if extent is None else extent
        extent.combineExtentWith(box)
    extent.scale(1.2)
    canvas.setExtent(extent)
    canvas.refresh()
