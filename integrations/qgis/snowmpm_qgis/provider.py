"""The provider: a group of algorithms in the toolbox of Processing, and the setting of the command."""

import os

from processing.core.ProcessingConfig import ProcessingConfig, Setting
from qgis.core import QgsProcessingProvider
from qgis.PyQt.QtGui import QIcon

from .avalanche import Avalanche
from .campaign import Campaign
from .dams import DamVariants
from .maps import MapsOfRun
from .observed import CompareWithObserved
from .program import COMMAND
from .release_areas import ReleaseAreas
from .scenarios import ScenarioSet
from .set_up import SetUp
from .words import tr

ALGORITHMS = (Avalanche, ReleaseAreas, ScenarioSet, DamVariants, Campaign, MapsOfRun, CompareWithObserved, SetUp)


class Provider(QgsProcessingProvider):
    """snowmpm in Processing."""

    def id(self):
        return "snowmpm"

    def name(self):
        return "snowmpm"

    def longName(self):
        return tr("snowmpm: snow and avalanches")

    def icon(self):
        return QIcon(os.path.join(os.path.dirname(__file__), "icon.svg"))

    def load(self):
        ProcessingConfig.settingIcons[self.name()] = self.icon()
        ProcessingConfig.addSetting(Setting(self.name(), COMMAND, tr("Command of snowmpm (empty: it is searched)"), "",
                                            valuetype=Setting.FILE))
        ProcessingConfig.readSettings()
        self.refreshAlgorithms()
        return True

    def unload(self):
        ProcessingConfig.removeSetting(COMMAND)

    def loadAlgorithms(self):
        for algorithm in ALGORITHMS:
            self.addAlgorithm(algorithm())
