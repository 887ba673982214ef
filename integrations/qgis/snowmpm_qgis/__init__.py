"""snowmpm in QGIS: its commands as algorithms of Processing. GPL-2.0-or-later (LICENSE)."""


def classFactory(iface):
    """The plugin, as QGIS asks for it."""
    from .plugin import Plugin

    return Plugin(iface)
