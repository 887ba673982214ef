"""Maps of a run that is there."""

import os

from qgis.core import (
    QgsProcessingException,
    QgsProcessingOutputFolder,
    QgsProcessingParameterBoolean,
    QgsProcessingParameterFeatureSource,
    QgsProcessingParameterFile,
    QgsProcessingParameterString,
)

from . import inputs, program, results
from .avalanche import add_numbers, numbers
from .base import ANY, LINES, Algorithm
from .words import tr


class MapsOfRun(Algorithm):
    """snowmpm maps."""

    KEY, TITLE, GROUP = "maps", "Maps of a run", "Results"
    ABOUT = (
        "<p>Writes the maps of a run of snowmpm and adds them to the project: of a run of this plugin, of a terminal,"
        " or of another machine.</p>"
        "<p><b>Gauges</b> are lines and points, such as roads and houses: depth, speed, pressure and discharge on them"
        " over time are in gauges.csv and in two layers. <b>Path</b> is the line along which run-out is measured, as"
        " AvaFrame's AIMEC does; the thalweg without it.</p>"
        "<p>With <i>over time</i>, the time controller of QGIS shows depth and speed: a run begins there at midnight of"
        " 1 January 2000.</p>")

    def initAlgorithm(self, configuration=None):
        add_run(self)
        self.add(QgsProcessingParameterFeatureSource("GAUGES", tr("Gauges"), [ANY], optional=True))
        self.add(QgsProcessingParameterFeatureSource("PATH", tr("Path"), [LINES], optional=True), advanced=True)
        self.add(QgsProcessingParameterBoolean("OVER_TIME", tr("Also depth and speed over time"), False))
        self.add(QgsProcessingParameterBoolean("PICTURES", tr("Also pictures (PNG)"), False), advanced=True)
        self.add(QgsProcessingParameterString("NAME", tr("Name"), "", optional=True), advanced=True)
        self.add_output()
        self.addOutput(QgsProcessingOutputFolder("RUN", tr("Folder of the run")))
        add_numbers(self)

    def processAlgorithm(self, parameters, context, feedback):
        run, folder = run_of(self, parameters, context), self.folder(parameters, context)
        words = ["maps", run, "-o", folder, "--files",
                 "all" if self.parameterAsBoolean(parameters, "PICTURES", context) else "gis"]
        if self.parameterAsBoolean(parameters, "OVER_TIME", context):
            words += ["--over-time", "gif"]
        for key, option in (("GAUGES", "--gauges"), ("PATH", "--path")):
            source = self.parameterAsSource(parameters, key, context)
            if source is not None:
                path = os.path.join(folder, f"{key.lower()}_given.gpkg")
                words += [option, write_places(source, path, context, feedback)]
        program.run(words, feedback, program.Steps(feedback, (1,)).next(), folder)
        self._load, self._folder = self.parameterAsBoolean(parameters, "LOAD", context), folder
        self._name = self.parameterAsString(parameters, "NAME", context) or os.path.basename(os.path.abspath(run))
        return {"OUTPUT": folder, "RUN": run, **numbers(folder)}

    def add_to(self, project, feedback):
        return results.add_run(self._folder, self._name, project)


def add_run(algorithm):
    """Declare the folder of a run as a parameter."""
    algorithm.add(QgsProcessingParameterFile("RUN_FOLDER", tr("Folder of a run"),
                                             QgsProcessingParameterFile.Behavior.Folder),
                  "It holds run.vtkhdf.")


def run_of(algorithm, parameters, context):
    """The folder of a run; one that holds it as run/, as those of this plugin do, is taken as well."""
    run = os.path.abspath(algorithm.parameterAsString(parameters, "RUN_FOLDER", context))
    for place in (run, os.path.join(run, "run")):
        if os.path.isfile(os.path.join(place, "run.vtkhdf")):
            return place
    raise QgsProcessingException(tr("{} holds no run of snowmpm (run.vtkhdf)").format(run))


def write_places(source, path, context, feedback):
    """Write features with their names, in their own projection; -> the path."""
    named = next((field.name() for field in source.fields() if field.name().lower() == "name"), None)
    if not inputs.write_features(source, path, context, feedback, texts={"name": named} if named else None):
        raise QgsProcessingException(tr("{}: no feature with a geometry").format(source.sourceName()))
    return path
