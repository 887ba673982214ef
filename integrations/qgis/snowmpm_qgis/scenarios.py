"""Scenarios of one path side by side, such as return periods."""

import os

from qgis.core import (
    QgsProcessingException,
    QgsProcessingParameterField,
    QgsProcessingParameterMatrix,
    QgsProcessingParameterString,
)

from . import inputs, program
from .base import CARDS
from .many import Many
from .words import tr

USUAL = ["10 years", 0.7, "", "30 years", 1.0, "", "100 years", 1.3, "", "300 years", 1.6, ""]


class ScenarioSet(Many):
    """A campaign of scenarios."""

    KEY, TITLE, GROUP = "scenarios", "Scenario set", "Avalanches"
    ABOUT = (
        "<p>Runs several scenarios of one path, such as return periods, and puts them side by side: one table, the"
        " outlines of all in one layer for each limit of pressure, and the maps of each.</p>"
        "<p>Either each scenario has its own release areas: choose the attribute of the release layer that names the"
        " scenario. Or all have the same areas, and the table gives name, thickness [m] and, if it is another, the"
        " class of friction.</p>"
        "<p>A return period is that of the release: it comes from your own statistics of snow. The program does not"
        " know it.</p>")

    def initAlgorithm(self, configuration=None):
        self.add_ground()
        self.add_release()
        self.add(QgsProcessingParameterField("SCENARIO_FIELD", tr("Attribute that names the scenario"), None, "RELEASE",
                                             optional=True), "The areas of one name are released together.")
        self.add(QgsProcessingParameterMatrix("SCENARIOS", tr("Scenarios of the same areas"), 4, False, [
            tr("Name"), tr("Thickness [m]"), tr("Friction")], USUAL, True),
            "Without an attribute that names them. An empty friction is the one below.")
        self.add_friction()
        self.add_dams()
        self.add(QgsProcessingParameterString("NAME", tr("Name"), "scenarios"), "Of the group of layers.")
        self.add_cells()
        self.add_output((("TABLE", "Numbers of all scenarios"), ("OUTLINES", "Outlines of all scenarios"),
                         ("REPORT", "Report")))

    def processAlgorithm(self, parameters, context, feedback):
        folder, steps = self.folder(parameters, context), program.Steps(feedback, (1, 2, 20, 6))
        steps.next()
        terrain, crs = self.write_ground(parameters, context, feedback, folder)
        dams = self.write_dams(parameters, context, feedback, folder, crs)
        field = self.parameterAsString(parameters, "SCENARIO_FIELD", context)
        if field:
            sets = self._by_field(parameters, context, feedback, folder, crs, field)
            release = os.path.join(folder, next(iter(sets.values()))["bodies.0.shape.region.file"])
        else:
            sets = self._by_table(parameters, context)
            release = self.write_release(parameters, context, feedback, folder, crs)
        self.write_scene(parameters, context, feedback, folder, steps.next(), release, terrain,
                         **({"terrain.dams": dams} if dams else {}))
        return self.run_scenarios(parameters, context, feedback, folder, steps, sets)

    def _by_field(self, parameters, context, feedback, folder, crs, field):
        """{scenario: changes} with a release file of its own for each name."""
        source, found = self.parameterAsSource(parameters, "RELEASE", context), {}
        for k, name in enumerate(inputs.values_of(source, field)):
            file = f"release_{k:02d}"
            self.write_release(parameters, context, feedback, folder, crs, file,
                               lambda feature, name=name: inputs.value_of(feature, field, str) == name)
            found[name] = {"bodies.0.shape.region.file": f"{file}.gpkg"}
        if not found:
            raise QgsProcessingException(tr("No release area has a value of {}").format(field))
        return found

    def _by_table(self, parameters, context):
        """{scenario: changes} from the table."""
        cells = self.parameterAsMatrix(parameters, "SCENARIOS", context)
        found = {}
        if len(cells) % 3:
            raise QgsProcessingException(tr("The table of scenarios has {} cells: three for each scenario").format(
                len(cells)))
        for k in range(0, len(cells), 3):
            name, thickness, card = (str(cell).strip() for cell in cells[k : k + 3])
            if not name:
                continue
            if name in found:
                raise QgsProcessingException(tr("Scenario {} is there twice").format(name))
            try:
                found[name] = {"bodies.0.shape.top": float(thickness.replace(",", "."))}
            except ValueError:
                raise QgsProcessingException(tr("Scenario {}: the thickness {} is no number").format(
                    name, thickness)) from None
            if card and card not in CARDS:
                raise QgsProcessingException(tr("Scenario {}: the friction {} is none of {}").format(
                    name, card, ", ".join(CARDS)))
            if card:
                found[name]["terrain.friction"] = {"card": card}
        if not found:
            raise QgsProcessingException(tr("No scenario: fill in the table, or choose an attribute that names them"))
        return found

    def add_to(self, project, feedback):
        return self.add_scenarios(project)
