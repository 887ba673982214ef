"""Where slabs can release on an elevation model."""

import os

from qgis.core import (
    QgsProcessingException,
    QgsProcessingOutputFile,
    QgsProcessingOutputNumber,
    QgsProcessingParameterEnum,
    QgsProcessingParameterFeatureSource,
    QgsProcessingParameterNumber,
    QgsVectorLayer,
)

from . import inputs, program, results
from .base import DOUBLE, POLYGONS, Algorithm
from .words import tr

RULES = ("frequent", "rare", "extreme")
"""Rules of release areas, as `snowmpm release-areas` has them."""
FILE, INNER = "release_areas.gpkg", "release_areas"


class ReleaseAreas(Algorithm):
    """snowmpm release-areas."""

    KEY, TITLE, GROUP = "release_areas", "Potential release areas", "Avalanches"
    ABOUT = (
        "<p>Finds where slabs can release: ground that is steep, even and not too rough, in single basins, as polygons"
        " with area, slope, aspect, altitude, thickness and volume. Forest protects.</p>"
        "<p>frequent: up to 30 years, from 30 degrees; rare: up to 100 years, from 28 degrees; extreme: larger areas."
        " The thickness follows from the increase of the snow depth within three days, by altitude and slope.</p>"
        "<p>The areas are inputs of all other algorithms here. They do not say that a slope releases.</p>")

    def initAlgorithm(self, configuration=None):
        self.add_ground()
        self.add(QgsProcessingParameterFeatureSource("FOREST", tr("Forest"), [POLYGONS], optional=True),
                 "Polygons in any projection: nothing releases in them.")
        self.add(QgsProcessingParameterEnum("SCENARIO", tr("Scenario"), [*RULES], False, "rare", False, True))
        self.add(QgsProcessingParameterNumber("SNOW", tr("Increase of the snow depth in three days, at 2000 m [m]"),
                                              DOUBLE, 1.5, False, 0.05, 20.0),
                 "Of the return period, from your own statistics of snow.")
        self.add_output()
        self.addOutput(QgsProcessingOutputFile("AREAS", tr("Release areas")))
        self.addOutput(QgsProcessingOutputNumber("COUNT", tr("Number of release areas")))

    def processAlgorithm(self, parameters, context, feedback):
        folder, steps = self.folder(parameters, context), program.Steps(feedback, (1, 5))
        steps.next()
        terrain, crs = self.write_ground(parameters, context, feedback, folder)
        forest, source = [], self.parameterAsSource(parameters, "FOREST", context)
        if source is not None:
            path = os.path.join(folder, "forest.gpkg")
            if not inputs.write_features(source, path, context, feedback, crs):
                raise QgsProcessingException(tr("Forest: no polygon"))
            forest = ["--forest", path]
        areas = os.path.join(folder, FILE)
        program.run(["release-areas", terrain, "-o", areas, *forest, "--scenario",
                     self.parameterAsString(parameters, "SCENARIO", context), "--three-day-snow",
                     f"{self.parameterAsDouble(parameters, 'SNOW', context):g}"], feedback, steps.next(), folder)
        self._areas = areas
        self._load = self.parameterAsBoolean(parameters, "LOAD", context)
        return {"OUTPUT": folder, "AREAS": areas, "COUNT": count_of(areas)}

    def add_to(self, project, feedback):
        group = results.new_group(project, tr(self.TITLE))
        layer = results.add_vector(self._areas, INNER, tr("release areas"), project, group, True)
        return [layer] if layer else []


def count_of(path):
    """Number of release areas in a file."""
    return QgsVectorLayer(f"{path}|layername={INNER}", "areas", "ogr").featureCount()
