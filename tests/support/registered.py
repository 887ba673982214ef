"""Entries of the registries for the time of a test, also in place of those of the program."""

import contextlib

from snowmpm import registry


@contextlib.contextmanager
def registered(*entries):
    """Context: the registries with these entries, each as if `snowmpm.register` had added it."""
    changed = {one: (dict(one._loaded()), dict(one.by)) for entry in entries for one in entry.REGISTRIES}
    for entry in entries:
        for one in entry.REGISTRIES:
            one._entries[one.name_of(entry)], one.by[one.name_of(entry)] = entry, __name__
    _changed(changed)
    try:
        yield
    finally:
        for one, (known, by) in changed.items():
            one._entries, one.by = known, by
        _changed(changed)


@contextlib.contextmanager
def without(one, name):
    """Context: a registry without one of its entries."""
    known, by = one._loaded().pop(name), one.by.pop(name)
    _changed({one: None})
    try:
        yield
    finally:
        one._entries[name], one.by[name] = known, by
        _changed({one: None})


def _changed(registries):
    registry.generation += 1
    registry._rebuild(set(registries))
