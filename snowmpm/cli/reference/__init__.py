"""Pages of reference, made from the program itself: `snowmpm docs NAME`, and the same on the documentation site."""

import importlib

PAGES = {
    "keys": "keys of a scene: unit, default, range, example",
    "campaign_keys": "keys of a campaign",
    "region_keys": "keys of a region",
    "cards": "material cards and classes of ground friction: numbers, sources, validity",
    "commands": "commands and their options",
    "fields": "fields of the particles, and every number with a name",
    "api": "the public Python names",
}
"""What each is about, by name; each is the module of this name, with `page()` -> Markdown."""


def page(name: str) -> str:
    """A page of PAGES as Markdown."""
    text: str = importlib.import_module(f"{__name__}.{name}").page()
    return text
