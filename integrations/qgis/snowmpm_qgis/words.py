"""Texts in the user's language."""

from qgis.PyQt.QtCore import QCoreApplication


def tr(text):
    """The text, translated where `i18n` has it."""
    return QCoreApplication.translate("snowmpm", text)
