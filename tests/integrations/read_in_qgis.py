"""Runs in QGIS's own Python: opens a project, draws it, exports its layout, and prints what QGIS makes of it as JSON.

    python3 read_in_qgis.py PROJECT FOLDER
"""

import json
import os
import sys

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from qgis.core import (
    QgsApplication,
    QgsLayoutExporter,
    QgsMapRendererCustomPainterJob,
    QgsMapSettings,
    QgsProject,
    QgsRectangle,
    QgsUnitTypes,
    QgsVectorLayer,
)
from qgis.PyQt.QtCore import QSize
from qgis.PyQt.QtGui import QColor, QImage, QPainter

SIZE = QSize(800, 600)


def drawn(layers, extent, crs, path):
    """Draw layers to a PNG; -> the settings, errors, and the share of pixels that any of them covers."""
    settings = QgsMapSettings()
    settings.setLayers(layers)
    settings.setDestinationCrs(crs)
    settings.setOutputSize(SIZE)
    settings.setExtent(extent)
    settings.setBackgroundColor(QColor(0, 0, 0, 0))
    image = QImage(SIZE, QImage.Format_ARGB32)
    image.fill(0)
    painter = QPainter(image)
    job = QgsMapRendererCustomPainterJob(settings, painter)
    job.start()
    job.waitForFinished()
    painter.end()
    image.save(path)
    covered = sum(image.pixelColor(x, y).alpha() > 0 for x in range(0, SIZE.width(), 4)
                  for y in range(0, SIZE.height(), 4))
    return settings, [error.message for error in job.errors()], covered / (SIZE.width() * SIZE.height() / 16)


def main(path, folder):
    project = QgsProject.instance()
    found = {"read": project.read(path), "crs": project.crs().authid(), "crs_valid": project.crs().isValid(),
             "metres": project.crs().mapUnits() == QgsUnitTypes.DistanceMeters, "layers": {}}
    nodes = project.layerTreeRoot().findLayers()
    area = project.mapLayersByName("affected area")[0]
    extent = QgsRectangle(area.extent())
    extent.scale(1.3)
    for node in nodes:
        layer = node.layer()
        own = found["layers"][node.name()] = {"valid": layer is not None and layer.isValid(),
                                              "shown": node.isVisible()}
        if own["valid"]:
            own |= {"crs_valid": layer.crs().isValid(), "crs": layer.crs().authid(), "covered": drawn(
                [layer], extent, project.crs(), os.path.join(folder, "layer.png"))[2]}
            if layer.type() == layer.VectorLayer:
                own["aliases"] = {field.name(): field.alias() for field in layer.fields() if field.alias()}
    shown = [node.layer() for node in nodes if node.isVisible()]
    settings, errors, covered = drawn(shown, extent, project.crs(), os.path.join(folder, "project.png"))
    found |= {"scale": settings.scale(), "errors": errors, "covered": covered, "layouts": []}
    for layout in project.layoutManager().layouts():
        picture = os.path.join(folder, "layout.png")
        options = QgsLayoutExporter.ImageExportSettings()
        options.dpi = 100
        result = QgsLayoutExporter(layout).exportToImage(picture, options)
        legend = next(item for item in layout.items() if hasattr(item, "legendSettings"))
        found["layouts"].append({"name": layout.name(), "exported": result == QgsLayoutExporter.Success,
                                 "map_scale": layout.referenceMap().scale(), "legend": [
                                     node.name() for node in legend.model().rootGroup().findLayers()]})
    # A layer of the GeoPackage by itself, as somebody adds it to a project of their own
    alone = QgsVectorLayer(f"{os.path.join(os.path.dirname(path), 'avalanche.gpkg')}|layername=thalweg", "x", "ogr")
    found["style_of_thalweg"] = alone.renderer().symbol().symbolLayer(0).penStyle() if alone.isValid() else None
    print(json.dumps(found))


if __name__ == "__main__":
    application = QgsApplication([], False)
    application.initQgis()
    main(*sys.argv[1:])
    sys.stdout.flush()
    os._exit(0)  # QGIS may crash when Qt is taken down
