"""Runs in QGIS's own Python: algorithms of the plugin with layers of a project, one after the other, as JSON.

    python3 drive_qgis.py PLUGINS WORK.json

PLUGINS: folder that holds the plugin; WORK: {"command": of snowmpm, "project": its system or None, "layers": [{"name",
"uri", "provider"} or {"name", "kind", "crs", "fields", "features": [[wkt, [values]]]}], "work": [{"algorithm",
"parameters" (a layer by its name), "cancel": seconds or None}], "picture": file}. Prints outputs, error, log and the
tree of the project after each.
"""

import json
import os
import sys
import threading
import time

from qgis.core import (
    QgsApplication,
    QgsCoordinateReferenceSystem,
    QgsFeature,
    QgsGeometry,
    QgsLayerTreeGroup,
    QgsMapRendererParallelJob,
    QgsMapSettings,
    QgsProcessingContext,
    QgsProcessingException,
    QgsProcessingFeedback,
    QgsProject,
    QgsRasterLayer,
    QgsVectorLayer,
)
from qgis.PyQt.QtCore import QSize

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
sys.path[:0] = ["/usr/share/qgis/python/plugins", sys.argv[1]]


class Log(QgsProcessingFeedback):
    """Keeps what is said, and the progress."""

    def __init__(self):
        super().__init__()
        self.lines, self.shares = [], []
        self.progressChanged.connect(self.shares.append)

    def pushInfo(self, text):
        self.lines.append(text)

    def pushWarning(self, text):
        self.lines.append(text)

    def pushCommandInfo(self, text):
        self.lines.append(text)

    def reportError(self, text, fatalError=False):
        self.lines.append(text)


def made(layer):
    """A layer of the project."""
    if "uri" in layer:
        new = (QgsRasterLayer if layer["provider"] == "gdal" else QgsVectorLayer)(layer["uri"], layer["name"],
                                                                                layer["provider"])
        if layer.get("crs") is not None:
            new.setCrs(QgsCoordinateReferenceSystem(layer["crs"]))
        return new
    fields = "".join(f"&field={name}:{kind}" for name, kind in layer.get("fields", {}).items())
    new = QgsVectorLayer(f"{layer['kind']}?crs={layer['crs']}{fields}", layer["name"], "memory")
    for wkt, values in layer["features"]:
        feature = QgsFeature(new.fields())
        feature.setGeometry(QgsGeometry.fromWkt(wkt))
        feature.setAttributes(values)
        new.dataProvider().addFeature(feature)
    new.updateExtents()
    return new


def tree(node):
    """The layer tree: groups as [name, children], layers as [name, valid, shown, system]."""
    return [[child.name(), tree(child)] if isinstance(child, QgsLayerTreeGroup) else
            [child.name(), child.layer() is not None and child.layer().isValid(), child.isVisible(),
             child.layer().crs().authid()] for child in node.children()]


def main(work):
    from processing.core.Processing import Processing
    from processing.core.ProcessingConfig import ProcessingConfig
    from snowmpm_qgis.plugin import Plugin

    Processing.initialize()
    plugin = Plugin(None)
    plugin.initProcessing()
    ProcessingConfig.setSettingValue("SNOWMPM_COMMAND", work["command"])
    project, layers, found = QgsProject.instance(), {}, []
    if work.get("project"):
        project.setCrs(QgsCoordinateReferenceSystem(work["project"]))
    for layer in work["layers"]:
        new = made(layer)
        assert new.isValid(), layer
        project.addMapLayer(new)
        layers[layer["name"]] = new
    for one in work["work"]:
        log, context = Log(), QgsProcessingContext()
        context.setProject(project)
        algorithm = QgsApplication.processingRegistry().createAlgorithmById(one["algorithm"])
        parameters = {name: layers.get(value, value) if isinstance(value, str) else value
                      for name, value in one["parameters"].items()}
        if one.get("cancel") is not None:
            threading.Timer(one["cancel"], log.cancel).start()
        began, error, result, fine = time.perf_counter(), "", {}, False
        try:
            allowed, reason = algorithm.checkParameterValues(parameters, context)
            if not allowed:
                raise QgsProcessingException(reason)
            result, fine = algorithm.run(parameters, context, log)
        except QgsProcessingException as problem:
            error = str(problem)
        found.append({"fine": fine, "error": error, "log": log.lines, "result": result, "shares": log.shares,
                      "seconds": time.perf_counter() - began, "tree": tree(project.layerTreeRoot()),
                      "crs": project.crs().authid()})
    if work.get("picture"):
        settings, root = QgsMapSettings(), project.layerTreeRoot()
        settings.setLayers([node.layer() for node in root.findLayers() if node.isVisible()])
        settings.setDestinationCrs(project.crs())
        settings.setOutputSize(QSize(1000, 700))
        extent = settings.fullExtent()
        settings.setExtent(extent)
        job = QgsMapRendererParallelJob(settings)
        job.start()
        job.waitForFinished()
        job.renderedImage().save(work["picture"])
    print(json.dumps({"found": found, "algorithms": sorted(
        one.id() for one in QgsApplication.processingRegistry().providerById("snowmpm").algorithms())}, default=str))


if __name__ == "__main__":
    application = QgsApplication([], False)
    application.initQgis()
    with open(sys.argv[2], encoding="utf-8") as file:
        main(json.load(file))
    sys.stdout.flush()
    os._exit(0)  # QGIS may crash when Qt is taken down
