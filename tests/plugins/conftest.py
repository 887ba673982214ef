"""The registries and plugins are put back after each test, since those of a process are for all of them."""

import sys

import pytest

from snowmpm import plugins, registry

REGISTRIES = [one for one in vars(registry).values() if isinstance(one, registry.Registry)]


@pytest.fixture(autouse=True)
def restored():
    kept = [(one, dict(one._loaded()), dict(one.by)) for one in REGISTRIES]
    loaded, modules = dict(plugins._loaded), set(sys.modules)
    yield
    for one, known, by in kept:
        one._entries, one.by = known, by
    plugins._loaded.clear()
    plugins._loaded.update(loaded)
    for name in set(sys.modules) - modules:
        if name.startswith(("snowmpm_plugin_", "snow_extras")):
            del sys.modules[name]
    registry.generation += 1
    registry._rebuild(set(REGISTRIES))
