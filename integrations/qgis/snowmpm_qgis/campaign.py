"""Many runs with friction and release that are not known exactly, and the probability of each place to be reached."""

import os

from qgis.core import QgsProcessingException, QgsProcessingParameterNumber, QgsProcessingParameterString

from . import program, results
from .base import DOUBLE
from .many import Many, rows
from .words import tr

RANGES = (("MU", "mu", "terrain.friction.mu", 0.1, 0.3), ("XI", "xi [m/s²]", "terrain.friction.xi", 1000.0, 3000.0),
          ("THICKNESS", "thickness of the release [m]", "bodies.0.shape.top", 0.8, 1.4))
"""(name, words, key of the scene, usual lowest and highest value) of what is not known."""
SHOWN = ("pressure_probability_1000", "depth_probability_0.5")
INTEGER = QgsProcessingParameterNumber.Type.Integer


def _place(name):
    """Where a layer stands: what is shown first, then shares by limit, quantiles, agreement."""
    kind, _, number = name.rpartition("_")
    return (SHOWN.index(name) if name in SHOWN else len(SHOWN), name == "agreement", "quantile" in kind, kind,
            float(number) if number.replace(".", "").isdigit() else 0.0)


class Campaign(Many):
    """A campaign of a Latin hypercube."""

    KEY, TITLE, GROUP = "campaign", "Campaign", "Avalanches"
    ABOUT = (
        "<p>Runs an avalanche many times, with Voellmy friction and thickness of the release drawn evenly between"
        " bounds, and maps the share of runs that reach each place with a depth, a speed, a pressure. Also quantiles of"
        " the peaks, what the numbers depend on, and whether there were enough runs (report.html).</p>"
        "<p>Such a probability holds what the bounds hold: neither the error of the model nor the frequency of"
        " releases.</p><p>With equal bounds, a value is the same in all runs.</p>")

    def initAlgorithm(self, configuration=None):
        self.add_ground()
        self.add_release(thickness=False)
        for key, words, _, low, high in RANGES:
            self.add(QgsProcessingParameterNumber(f"{key}_LOW", tr("Lowest {}").format(words), DOUBLE, low))
            self.add(QgsProcessingParameterNumber(f"{key}_HIGH", tr("Highest {}").format(words), DOUBLE, high))
        self.add(QgsProcessingParameterNumber("RUNS", tr("Number of runs"), INTEGER, 50, False, 2, 100000))
        self.add_dams()
        self.add(QgsProcessingParameterString("NAME", tr("Name"), "campaign"), "Of the group of layers.")
        self.add_cells()
        self.add_output((("TABLE", "Numbers of all runs"), ("REPORT", "Report")))

    def friction(self, parameters, context):
        return {"law": "voellmy", "mu": self.parameterAsDouble(parameters, "MU_LOW", context),
                "xi": self.parameterAsDouble(parameters, "XI_LOW", context)}

    def processAlgorithm(self, parameters, context, feedback):
        folder, steps = self.folder(parameters, context), program.Steps(feedback, (1, 2, 40, 3))
        ranges = self._ranges(parameters, context)
        steps.next()
        terrain, crs = self.write_ground(parameters, context, feedback, folder)
        dams = self.write_dams(parameters, context, feedback, folder, crs)
        release = self.write_release(parameters, context, feedback, folder, crs,
                                     thickness=ranges["thickness"][1])
        self.write_scene(parameters, context, feedback, folder, steps.next(), release, terrain,
                         **({"terrain.dams": dams} if dams else {}))
        tables = [(f"parameters.{name}", {"key": place, "distribution": "uniform", "low": low, "high": high})
                  for name, (place, low, high) in ranges.items() if low < high]
        if not tables:
            raise QgsProcessingException(tr("All bounds are equal: one run answers it"))
        name = self.title(parameters, context)
        out = self.run_campaign(feedback, folder, steps.next(), name, {
            "design": "latin_hypercube", "runs": self.parameterAsInt(parameters, "RUNS", context), "seed": 1}, tables)
        self._maps = os.path.join(folder, "maps")
        program.run(["campaign", "maps", out, "-o", self._maps, "-q"], feedback, steps.next(), folder)
        self._one = os.path.join(folder, "maps_of_one")
        one = rows(os.path.join(out, "table.csv"))[:1]
        if one:  # for the ground and the release
            program.run(["maps", os.path.join(out, "runs", one[0]["hash"]), "-o", self._one, "--files", "gis", "-q"],
                        feedback, None, folder)
        self._load, self._name = self.parameterAsBoolean(parameters, "LOAD", context), name
        return {"OUTPUT": folder, "TABLE": os.path.join(out, "table.csv"), "REPORT": os.path.join(out, "report.html")}

    def _ranges(self, parameters, context):
        """{name: (key of the scene, lowest, highest)}."""
        found = {}
        for key, words, place, _, _ in RANGES:
            low, high = (self.parameterAsDouble(parameters, f"{key}_{end}", context) for end in ("LOW", "HIGH"))
            if low > high:
                raise QgsProcessingException(tr("{}: the lowest value, {:g}, lies above the highest, {:g}").format(
                    words, low, high))
            found[key.lower()] = (place, low, high)
        return found

    def add_to(self, project, feedback):
        group, found = results.new_group(project, self._name), []
        names = sorted(name[:-4] for name in os.listdir(self._maps) if name.endswith(".tif"))
        names = [name for name in names if "_low_" not in name and "_high_" not in name]
        for name in sorted(names, key=_place):
            layer = results.add_raster(os.path.join(self._maps, f"{name}.tif"), project, group, name == SHOWN[0])
            found += [layer] if name == SHOWN[0] and layer is not None else []
        results.add_project(os.path.join(self._one, "avalanche.qgs"), project, group,
                            lambda name: name in ("release", "terrain"))
        return found
