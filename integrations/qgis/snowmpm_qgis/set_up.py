"""Installs snowmpm in an environment of its own, beside the user's profile of QGIS."""

import os
import shutil
import sys

from processing.core.ProcessingConfig import ProcessingConfig
from qgis.core import (
    QgsProcessingException,
    QgsProcessingOutputString,
    QgsProcessingParameterFile,
    QgsProcessingParameterString,
)

from . import program
from .base import Algorithm
from .words import tr

EXTRAS = "gis,cluster"
PYTHONS = ("python3.12", "python3.11", "python3.13", "python3.10", "python3", "python")


class SetUp(Algorithm):
    """python -m venv, pip install."""

    KEY, TITLE, GROUP = "set_up", "Set up snowmpm", "Installation"
    ABOUT = (
        "<p>Installs snowmpm, or a newer version of it, into an environment of its own in your profile of QGIS (2 GB)."
        " QGIS's own Python stays as it is.</p>"
        "<p>It needs a Python 3.10 to 3.13 with venv, and what pip needs to reach packages. The source is a folder with"
        " the program, a wheel, or a name that pip knows.</p>"
        "<p>If snowmpm is installed already, this is not needed: name its command in Settings > Options > Processing >"
        " Providers > snowmpm.</p>")

    def initAlgorithm(self, configuration=None):
        self.add(QgsProcessingParameterString("SOURCE", tr("Source"), "snowmpm"),
                 "A folder, a wheel, or a name that pip knows.")
        python = QgsProcessingParameterFile("PYTHON", tr("Python (empty: it is searched)"), optional=True)
        self.add(python, advanced=True)
        self.addOutput(QgsProcessingOutputString("COMMAND", tr("Command of snowmpm")))

    def processAlgorithm(self, parameters, context, feedback):
        python = self.parameterAsString(parameters, "PYTHON", context) or self._python()
        source = self.parameterAsString(parameters, "SOURCE", context).strip()
        source = f"{source}[{EXTRAS}]" if "[" not in source else source
        folder = program.own_folder()
        steps = program.Steps(feedback, (1, 20, 1))
        program.run([folder], feedback, steps.next(), command=[python, "-m", "venv"])
        own = os.path.join(program.scripts(folder), "python.exe" if program.WINDOWS else "python")
        steps.next()
        program.run([source], feedback, command=[own, "-m", "pip", "install", "--upgrade", "--no-input"])
        steps.next()
        command = os.path.join(program.scripts(folder), program.NAME)
        said = program.run([], feedback, command=[command, "--version"])
        ProcessingConfig.setSettingValue(program.COMMAND, command)
        feedback.pushInfo(tr("{} is ready.").format(said[-1] if said else "snowmpm"))
        return {"COMMAND": command}

    def _python(self):
        """A Python that can make the environment: on Windows QGIS's own, elsewhere one of the system."""
        own = os.path.join(sys.exec_prefix, "python.exe")
        if program.WINDOWS and os.path.isfile(own):
            return own
        for name in PYTHONS:
            if found := shutil.which(name):
                return found
        raise QgsProcessingException(tr("No Python was found: name one"))
