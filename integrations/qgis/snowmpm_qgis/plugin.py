"""What QGIS loads and unloads."""

import os

from qgis.core import QgsApplication, QgsSettings
from qgis.PyQt.QtCore import QCoreApplication, QTranslator

from .provider import Provider


class Plugin:
    """Adds the provider to Processing, and the translation of the user's language where there is one."""

    def __init__(self, iface):
        self._provider = self._translator = None
        locale = str(QgsSettings().value("locale/userLocale", "en"))[:2]
        path = os.path.join(os.path.dirname(__file__), "i18n", f"snowmpm_{locale}.qm")
        if os.path.exists(path):
            self._translator = QTranslator()
            self._translator.load(path)
            QCoreApplication.installTranslator(self._translator)

    def initProcessing(self):
        """Called by `qgis_process`, which has no window."""
        self._provider = Provider()
        QgsApplication.processingRegistry().addProvider(self._provider)

    def initGui(self):
        """Called by QGIS."""
        self.initProcessing()

    def unload(self):
        """Called by QGIS."""
        QgsApplication.processingRegistry().removeProvider(self._provider)
        if self._translator:
            QCoreApplication.removeTranslator(self._translator)
