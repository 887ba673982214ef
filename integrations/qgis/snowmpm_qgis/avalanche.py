"""One avalanche, from terrain and release to maps."""

import json
import os

from qgis.core import (
    QgsProcessingOutputFile,
    QgsProcessingOutputFolder,
    QgsProcessingOutputNumber,
    QgsProcessingOutputString,
    QgsProcessingParameterEnum,
    QgsProcessingParameterString,
)

from . import program, results
from .base import Algorithm, file_name, words_of_settings
from .words import tr

METHODS = ("depth", "mpm")


class Avalanche(Algorithm):
    """snowmpm new, run and maps."""

    KEY, TITLE, GROUP = "avalanche", "Avalanche from terrain and release", "Avalanches"
    ABOUT = (
        "<p>Computes one avalanche: where it flows, how deep, how fast, with which pressure, and where it stops.</p>"
        "<p>By default the flow is depth-averaged: run-out and maps of kilometres in seconds to minutes. The method mpm"
        " resolves the depth of the flow in 3-D, at some hundred times the cost.</p>"
        "<p>The results are added in a group: outlines, thalweg and run-out, maps of the largest depth, speed and"
        " pressure, and the shaded terrain. The same folder holds the scene (avalanche.toml), which can be edited and"
        " run again by <i>snowmpm run</i>.</p>"
        "<p>The result of a model, no hazard assessment. Friction decides: run several classes and compare.</p>")

    def initAlgorithm(self, configuration=None):
        self.add_ground()
        self.add_release()
        self.add_friction()
        self.add_dams()
        self.add(QgsProcessingParameterString("NAME", tr("Name"), "avalanche"), "Of the group of layers.")
        self.add_cells()
        self.add(QgsProcessingParameterEnum("METHOD", tr("Method"), list(METHODS), False, METHODS[0], False, True),
                 advanced=True)
        self.add_output()
        self.addOutput(QgsProcessingOutputFolder("RUN", tr("Folder of the run")))
        add_numbers(self)

    def processAlgorithm(self, parameters, context, feedback):
        folder, name = self.folder(parameters, context), self.title(parameters, context)
        steps, scene = program.Steps(feedback, (1, 2, 20, 4)), file_name(name)
        steps.next()
        terrain, crs = self.write_ground(parameters, context, feedback, folder)
        release = self.write_release(parameters, context, feedback, folder, crs)
        dams = self.write_dams(parameters, context, feedback, folder, crs)
        settings = self.settings(parameters, context, **({"terrain.dams": dams} if dams else {}))
        method = self.parameterAsString(parameters, "METHOD", context)
        program.run(["new", scene, "--terrain", terrain, "--release", release, "--method", method, "-o", folder,
                     "--overwrite", *words_of_settings(settings)], feedback, steps.next(), folder)
        run = os.path.join(folder, "run")
        program.run(["run", os.path.join(folder, f"{scene}.toml"), "-o", run, "--overwrite"], feedback, steps.next(),
                    folder)
        program.run(["maps", run, "--files", "gis", "-q"], feedback, steps.next(), folder)
        self._load, self._name = self.parameterAsBoolean(parameters, "LOAD", context), name
        self._maps = os.path.join(run, "maps")
        found = numbers(self._maps)
        for key, (_, words) in NUMBERS.items():
            if key in found:
                feedback.pushInfo(f"{tr(words)}: {found[key]:g}")
        feedback.pushInfo(found["STATUS"])
        return {"OUTPUT": folder, "RUN": run, **found}

    def add_to(self, project, feedback):
        return results.add_run(self._maps, self._name, project)


NUMBERS = {"RUNOUT": ("runout", "Run-out [m]"), "TRAVEL_ANGLE": ("travel_angle", "Travel angle [degrees]"),
           "AFFECTED_AREA": ("affected_area", "Affected area [m²]"),
           "LARGEST_SPEED": ("largest_flow_speed", "Largest flow speed [m/s]"),
           "LARGEST_PRESSURE": ("largest_flow_pressure", "Largest pressure [Pa]")}
"""Outputs that models can go on with."""
MAPS = {"PEAK_DEPTH": ("peak_depth.tif", "Peak flow depth"), "PEAK_SPEED": ("peak_speed.tif", "Peak flow speed"),
        "PEAK_PRESSURE": ("peak_pressure.tif", "Peak pressure"), "OUTLINES": ("avalanche.gpkg", "Outlines")}


def add_numbers(algorithm):
    """Declare the numbers and files of an avalanche as outputs."""
    for key, (_, words) in NUMBERS.items():
        algorithm.addOutput(QgsProcessingOutputNumber(key, tr(words)))
    algorithm.addOutput(QgsProcessingOutputString("STATUS", tr("Whether the run is final")))
    for key, (_, words) in MAPS.items():
        algorithm.addOutput(QgsProcessingOutputFile(key, tr(words)))


def numbers(maps):
    """Their values, from the folder of the maps of a run."""
    with open(os.path.join(maps, "avalanche.json"), encoding="utf-8") as file:
        record = json.load(file)
    found = record.get("numbers", {})
    return {"STATUS": record.get("status", ""),
            **{key: found[name]["value"] for key, (name, _) in NUMBERS.items()
               if found.get(name, {}).get("value") is not None},
            **{key: os.path.join(maps, name) for key, (name, _) in MAPS.items()
               if os.path.exists(os.path.join(maps, name))}}
