"""A run beside the outline of an avalanche that was seen."""

import csv
import os

from qgis.core import QgsProcessingOutputNumber, QgsProcessingParameterFeatureSource

from . import program, results
from .base import POLYGONS, Algorithm
from .maps import add_run, run_of, write_places
from .words import tr

SCORES = {"CRITICAL_SUCCESS_INDEX": ("critical_success_index", "Critical success index"),
          "HIT_RATE": ("hit_rate", "Hit rate"), "AREA_RATIO": ("area_ratio", "Computed over observed area"),
          "RUNOUT_DIFFERENCE": ("runout_difference", "Computed less observed run-out [m]")}


class CompareWithObserved(Algorithm):
    """snowmpm maps --observed."""

    KEY, TITLE, GROUP = "compare_with_observed", "Compare with an observed outline", "Results"
    ABOUT = (
        "<p>Scores the affected area of a run, and that above each limit of pressure, against the outline of an"
        " avalanche that was seen:"
        " critical success index, hit rate, ratio of the areas, difference of the run-outs.</p>"
        "<p>The outline is drawn beside the computed one. All scores are in avalanche.csv of the folder.</p>")

    def initAlgorithm(self, configuration=None):
        add_run(self)
        self.add(QgsProcessingParameterFeatureSource("OBSERVED", tr("Observed outline"), [POLYGONS]))
        self.add_output()
        for key, (_, words) in SCORES.items():
            self.addOutput(QgsProcessingOutputNumber(key, tr(words)))

    def processAlgorithm(self, parameters, context, feedback):
        run, folder = run_of(self, parameters, context), self.folder(parameters, context)
        source = self.parameterAsSource(parameters, "OBSERVED", context)
        path = write_places(source, os.path.join(folder, "observed.gpkg"), context, feedback)
        program.run(["maps", run, "-o", folder, "--files", "gis", "--observed", path], feedback,
                    program.Steps(feedback, (1,)).next(), folder)
        self._load, self._folder = self.parameterAsBoolean(parameters, "LOAD", context), folder
        self._name = tr("{} and observed").format(os.path.basename(os.path.abspath(run)))
        return {"OUTPUT": folder, **_scores(os.path.join(folder, "avalanche.csv"))}

    def add_to(self, project, feedback):
        return results.add_run(self._folder, self._name, project, ("affected area", "observed"))


def _scores(path):
    with open(path, encoding="utf-8", newline="") as file:
        found = {row["name"]: row["value"] for row in csv.DictReader(file)}
    values = {key: found.get(f"observed.affected_area.{name}") for key, (name, _) in SCORES.items()}
    return {key: float(value) for key, value in values.items() if value}
