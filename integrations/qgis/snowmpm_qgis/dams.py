"""Variants of dams, side by side with the slope as it is."""

import os

from qgis.core import (
    QgsLineSymbol,
    QgsProcessingException,
    QgsProcessingParameterField,
    QgsProcessingParameterString,
    QgsSingleSymbolRenderer,
)

from . import inputs, program, results
from .many import Many
from .words import tr


class DamVariants(Many):
    """A campaign of scenarios that differ in their dams."""

    KEY, TITLE, GROUP = "dam_variants", "Dam variants", "Avalanches"
    ABOUT = (
        "<p>Runs one avalanche without dams, and once for each variant of dams: lines of one value of the attribute"
        " that names the variant are built together; without it, each line is a variant.</p>"
        "<p>A dam is ground: a ridge with sides of 45 degrees along its line. Its foot must be at least two cells of"
        " the elevation model wide. No pressure on it is computed.</p>"
        "<p>The results are those of a scenario set: one table, outlines of all variants, the maps of each.</p>")

    def initAlgorithm(self, configuration=None):
        self.add_ground()
        self.add_release()
        self.add_friction()
        self.add_dams(optional=False)
        self.add(QgsProcessingParameterField("VARIANT_FIELD", tr("Attribute that names the variant"), None, "DAMS",
                                             optional=True), "Lines of one name are built together.")
        self.add(QgsProcessingParameterString("NAME", tr("Name"), "dam variants"), "Of the group of layers.")
        self.add_cells()
        self.add_output((("TABLE", "Numbers of all variants"), ("OUTLINES", "Outlines of all variants"),
                         ("REPORT", "Report")))

    def processAlgorithm(self, parameters, context, feedback):
        folder, steps = self.folder(parameters, context), program.Steps(feedback, (1, 2, 20, 6))
        steps.next()
        terrain, crs = self.write_ground(parameters, context, feedback, folder)
        release = self.write_release(parameters, context, feedback, folder, crs)
        field = self.parameterAsString(parameters, "VARIANT_FIELD", context)
        self._dams = os.path.join(folder, "dams.gpkg")
        inputs.write_features(self.parameterAsSource(parameters, "DAMS", context), self._dams, context, feedback, crs,
                              texts={"variant": field} if field else None)
        sets = {tr("without dams"): {"terrain.dams": []}}
        for k, (variant, keep) in enumerate(self._variants(parameters, context)):
            if variant in sets:
                raise QgsProcessingException(tr("{} is the name of the slope as it is: take another").format(variant))
            dams = self.write_dams(parameters, context, feedback, folder, crs, f"dams_{k:02d}", keep)
            sets[variant] = {"terrain.dams": dams}
        self.write_scene(parameters, context, feedback, folder, steps.next(), release, terrain)
        return self.run_scenarios(parameters, context, feedback, folder, steps, sets)

    def _variants(self, parameters, context):
        """(name, function that says whether a feature belongs to it) of each variant."""
        source = self.parameterAsSource(parameters, "DAMS", context)
        field = self.parameterAsString(parameters, "VARIANT_FIELD", context)
        if field:
            found = [(name, lambda feature, name=name: inputs.value_of(feature, field, str) == name)
                     for name in inputs.values_of(source, field)]
        else:
            ids = [feature.id() for feature in source.getFeatures() if feature.hasGeometry()]
            found = [(tr("dam {}").format(own), lambda feature, own=own: feature.id() == own) for own in ids]
        if not found:
            raise QgsProcessingException(tr("Dams: no line, or none with a value of {}").format(field) if field else
                                         tr("Dams: no line"))
        return found

    def add_to(self, project, feedback):
        found = self.add_scenarios(project)
        group = project.layerTreeRoot().children()[0]
        dams = results.add_vector(self._dams, "features", tr("dams"), project, group, True, at_top=True)
        dams.setRenderer(QgsSingleSymbolRenderer(QgsLineSymbol.createSimple({"color": "#101418", "width": "0.9"})))
        return found
