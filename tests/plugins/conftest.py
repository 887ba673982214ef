"""The registries and plugins are put back after each test, since those of a process are for all of them."""

import sys

import pytest

from snowmpm import components, plugins, registry

REGISTRIES = [one for one in vars(registry).values() if isinstance(one, registry.Registry)]


@pytest.fixture(autouse=True)
def restored():
    kept = [(one, dict(one._loaded()), dict(one.by)) for one in REGISTRIES]
    loaded, modules = dict(plugins._loaded), set(sys.modules)
    fields = {table: dict(table.model_fields) for tables in components._tables.values() for table in tables}
    yield
    for one, known, by in kept:
        one._entries, one.by = known, by
    plugins._loaded.clear()
    plugins._loaded.update(loaded)
    for name in set(sys.modules) - modules:
        if name.startswith(("snowmpm_plugin_", "snow_extras")):
            del sys.modules[name]
    registry.generation += 1
    changed = {table for table, known in fields.items() if table.model_fields.keys() != known.keys()}
    for table in changed:  # keys of a component that is gone
        for key in table.model_fields.keys() - fields[table].keys():
            del table.model_fields[key]
        table.model_rebuild(force=True)
    registry._rebuild(set(REGISTRIES), changed)
