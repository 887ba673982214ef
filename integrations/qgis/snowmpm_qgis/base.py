"""What the algorithms have in common: place in the toolbox, inputs, the scene they write, results in the project."""

import json
import os
import re

from qgis.core import (
    QgsProcessing,
    QgsProcessingAlgorithm,
    QgsProcessingException,
    QgsProcessingOutputFile,
    QgsProcessingParameterBoolean,
    QgsProcessingParameterDefinition,
    QgsProcessingParameterEnum,
    QgsProcessingParameterExtent,
    QgsProcessingParameterFeatureSource,
    QgsProcessingParameterField,
    QgsProcessingParameterFolderDestination,
    QgsProcessingParameterNumber,
    QgsProcessingParameterRasterLayer,
    QgsProject,
)
from qgis.PyQt.QtGui import QIcon

from . import inputs, results
from .words import tr

DOUBLE = QgsProcessingParameterNumber.Type.Double
ADVANCED = QgsProcessingParameterDefinition.Flag.FlagAdvanced
POLYGONS, LINES, ANY = (QgsProcessing.SourceType.TypeVectorPolygon, QgsProcessing.SourceType.TypeVectorLine,
                        QgsProcessing.SourceType.TypeVectorAnyGeometry)
CARDS = ("samos_at_auto", "samos_at_small", "samos_at_medium", "samos_at_large", "voellmy_avaframe",
         "voellmy_buser_frutiger", "voellmy_min_shear_avaframe")
"""Classes of ground friction, as `snowmpm list` has them."""
OWN = "voellmy"
"""Friction of one's own two numbers."""


class Algorithm(QgsProcessingAlgorithm):
    """Base of the algorithms. KEY: its name in scripts; TITLE, GROUP, ABOUT: words, in English."""

    KEY, TITLE, GROUP, ABOUT = "", "", "", ""

    def createInstance(self):
        return type(self)()

    def name(self):
        return self.KEY

    def displayName(self):
        return tr(self.TITLE)

    def group(self):
        return tr(self.GROUP)

    def groupId(self):
        return self.GROUP.lower().replace(" ", "_")

    def shortHelpString(self):
        return tr(self.ABOUT)

    def helpUrl(self):
        page = os.path.join(os.path.dirname(__file__), "help.html")
        place = re.sub("[^a-z0-9]+", "-", self.TITLE.lower())
        return f"file:///{page.replace(os.sep, '/').lstrip('/')}#{place}" if os.path.exists(page) else ""

    def icon(self):
        return QIcon(os.path.join(os.path.dirname(__file__), "icon.svg"))

    def initAlgorithm(self, configuration=None):
        """Declare parameters and outputs."""
        raise NotImplementedError

    # Parameters

    def add(self, parameter, about="", advanced=False):
        """Declare a parameter with its tooltip."""
        if about:
            parameter.setHelp(tr(about))
        if advanced:
            parameter.setFlags(parameter.flags() | ADVANCED)
        self.addParameter(parameter)

    def add_ground(self):
        """Terrain and the part of it that is computed."""
        self.add(QgsProcessingParameterRasterLayer("TERRAIN", tr("Elevation model")),
                 "Heights of the ground in metres, in any projection. One in degrees is brought to metres.")
        self.add(QgsProcessingParameterExtent("EXTENT", tr("Part of it that is computed"), optional=True),
                 "It must hold the run-out. Empty: all of it.", advanced=True)

    def add_release(self, thickness=True):
        """Release areas and the thickness of their snow."""
        self.add(QgsProcessingParameterFeatureSource("RELEASE", tr("Release areas"), [POLYGONS]),
                 "Polygons in any projection.")
        if not thickness:
            return
        self.add(QgsProcessingParameterField("THICKNESS_FIELD", tr("Attribute with the thickness of the release [m]"),
                                             None, "RELEASE", QgsProcessingParameterField.DataType.Numeric, False,
                                             True),
                 "Normal to the slope. The number below holds for areas without a value.")
        self.add(QgsProcessingParameterNumber("THICKNESS", tr("Thickness of the release [m]"), DOUBLE, 1.0, False, 0.01,
                                              50.0), "Normal to the slope.")

    def add_friction(self):
        """Friction of the ground."""
        self.add(QgsProcessingParameterEnum("FRICTION", tr("Friction of the ground"), [*CARDS, OWN], False, CARDS[0],
                                            False, True),
                 "A published class (Help lists them): samos_at_auto chooses by the volume of the release, voellmy"
                 " takes the two numbers under Advanced Parameters. Results depend on it more than on all else: run"
                 " several. In scripts, its name, not a number.")
        self.add(QgsProcessingParameterNumber("MU", tr("Voellmy: mu"), DOUBLE, 0.155, False, 0.0, 2.0), advanced=True)
        self.add(QgsProcessingParameterNumber("XI", tr("Voellmy: xi [m/s²]"), DOUBLE, 1120.0, False, 1.0, 1e6),
                 advanced=True)

    def add_cells(self):
        """Width of the cells, time and frames."""
        self.add(QgsProcessingParameterNumber("CELL", tr("Width of a cell [m] (0: that of the terrain, or about 5 m)"),
                                              DOUBLE, 0.0, False, 0.0, 1000.0), advanced=True)
        self.add(QgsProcessingParameterNumber("END_TIME", tr("Longest time of the flow [s] (0: guessed)"), DOUBLE, 0.0,
                                              False, 0.0, 1e5),
                 "A run ends when the snow rests, or then. Give more where a run is not final.", advanced=True)
        self.add(QgsProcessingParameterNumber("INTERVAL", tr("Time between two frames [s] (0: guessed)"), DOUBLE, 0.0,
                                              False, 0.0, 1e4), advanced=True)

    def add_dams(self, optional=True):
        """Dams."""
        self.add(QgsProcessingParameterFeatureSource("DAMS", tr("Dams"), [LINES], optional=optional),
                 "Lines of their crests.")
        self.add(QgsProcessingParameterField("DAM_HEIGHT_FIELD", tr("Attribute with the height of a dam [m]"), None,
                                             "DAMS", QgsProcessingParameterField.DataType.Numeric, False, True),
                 "Above the ground.")
        self.add(QgsProcessingParameterNumber("DAM_HEIGHT", tr("Height of dams without one [m]"), DOUBLE, 8.0, False,
                                              0.1, 100.0), advanced=optional)

    def add_output(self, files=()):
        """The folder of the results, whether they are added to the project, and files of them for models."""
        self.add(QgsProcessingParameterBoolean("LOAD", tr("Add the results to the project"), True))
        self.add(QgsProcessingParameterFolderDestination("OUTPUT", tr("Folder of the results")))
        for name, words in files:
            self.addOutput(QgsProcessingOutputFile(name, tr(words)))

    # What they do with them

    def folder(self, parameters, context):
        """The folder of the results, made where it is missing. Raises QgsProcessingException for one with other files
        than those of an earlier run."""
        folder = os.path.abspath(self.parameterAsString(parameters, "OUTPUT", context))
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise QgsProcessingException(f"{folder}: {error.strerror}") from error
        strange = [name for name in os.listdir(folder) if not name.startswith(".")]
        if strange and not os.path.exists(os.path.join(folder, MARK)):
            raise QgsProcessingException(tr("{} holds files of others, such as {}: choose an empty folder").format(
                folder, strange[0]))
        with open(os.path.join(folder, MARK), "w", encoding="utf-8") as mark:
            mark.write(f"snowmpm:{self.KEY}\n")
        return folder

    def write_ground(self, parameters, context, feedback, folder):
        """Write the terrain; -> its path and its system."""
        layer = self.parameterAsRasterLayer(parameters, "TERRAIN", context)
        if layer is None or not layer.isValid():
            raise QgsProcessingException(tr("Elevation model: no raster that can be read"))
        crs = inputs.metric_system(layer)
        extent = self.parameterAsExtent(parameters, "EXTENT", context, crs)
        path = os.path.join(folder, "terrain.tif")
        inputs.write_raster(layer, path, crs, feedback, None if extent.isNull() else extent)
        return path, crs

    def write_release(self, parameters, context, feedback, folder, crs, name="release", keep=None, thickness=None):
        """Write the release areas with their thickness, or with that of all; -> path."""
        source = self.parameterAsSource(parameters, "RELEASE", context)
        if source is None:
            raise QgsProcessingException(self.invalidSourceError(parameters, "RELEASE"))
        if thickness is None:
            thickness = (self.parameterAsString(parameters, "THICKNESS_FIELD", context),
                         self.parameterAsDouble(parameters, "THICKNESS", context))
        path = os.path.join(folder, f"{name}.gpkg")
        if not inputs.write_features(source, path, context, feedback, crs, numbers={"thickness": thickness}, keep=keep):
            raise QgsProcessingException(tr("Release areas: no polygon"))
        return path

    def write_dams(self, parameters, context, feedback, folder, crs, name="dams", keep=None):
        """Write dams, a file for each height; -> entries of `terrain.dams`, [] without dams."""
        source = self.parameterAsSource(parameters, "DAMS", context)
        if source is None:
            return []
        field = self.parameterAsString(parameters, "DAM_HEIGHT_FIELD", context)
        usual = self.parameterAsDouble(parameters, "DAM_HEIGHT", context)
        inputs.require_field(source, field)
        heights = {}
        for feature in source.getFeatures():
            if feature.hasGeometry() and (keep is None or keep(feature)):
                own = inputs.value_of(feature, field, float) if field else None
                heights.setdefault(usual if own is None else own, set()).add(feature.id())
        found = []
        for k, (height, ids) in enumerate(sorted(heights.items())):
            path = os.path.join(folder, f"{name}_{k}.gpkg")
            inputs.write_features(source, path, context, feedback, crs,
                                  keep=lambda feature, ids=ids: feature.id() in ids)
            found.append({"name": f"{name} {height:g} m", "file": os.path.basename(path), "height": height})
        return found

    def friction(self, parameters, context):
        """The value of `terrain.friction`."""
        chosen = self.parameterAsString(parameters, "FRICTION", context)
        if chosen != OWN:
            return {"card": chosen}
        return {"law": "voellmy", "mu": self.parameterAsDouble(parameters, "MU", context),
                "xi": self.parameterAsDouble(parameters, "XI", context)}

    def settings(self, parameters, context, **more):
        """{key: value} of the scene, as of `--set`."""
        found = {"terrain.friction": self.friction(parameters, context)}
        for name, key in (("CELL", "solver.dx"), ("END_TIME", "end_time"), ("INTERVAL", "output.interval")):
            value = self.parameterAsDouble(parameters, name, context)
            found.update({key: value} if value > 0.0 else {})
        return {**found, **more}

    def title(self, parameters, context):
        """Name of the group of results."""
        return self.parameterAsString(parameters, "NAME", context).strip() or self.displayName()

    def postProcessAlgorithm(self, context, feedback):
        """Add the results to the project; QGIS calls this in the thread of its window."""
        if getattr(self, "_load", False):
            project = context.project() or QgsProject.instance()
            layers = self.add_to(project, feedback)
            project.layerTreeRoot().children()[0].setExpanded(True)
            if not project.crs().isValid() and layers:
                project.setCrs(layers[0].crs())
            results.show([layer for layer in layers if layer is not None])
        return {}

    def add_to(self, project, feedback):
        """Add the results to a project; -> the layers that the map is moved to."""
        return []


MARK = "made_in_qgis.txt"
"""File that tells a folder of an earlier run of an algorithm."""


def file_name(text):
    """A text as a name of files, folders and scenes."""
    return re.sub(r"[^A-Za-z0-9_\-]+", "_", text).strip("_-")[:60] or "avalanche"


def words_of_settings(settings):
    """--set KEY=VALUE for each of {key: value}."""
    return [word for key, value in settings.items() for word in ("--set", f"{key}={toml(value)}")]


def toml(value):
    """A value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # what it escapes, TOML does as well
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(value)
