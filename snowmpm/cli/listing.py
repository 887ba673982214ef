"""`snowmpm list`: what comes with the program."""

import shutil
import sys
import textwrap

from snowmpm.cli.options import Json
from snowmpm.cli.table import LONGEST, print_json
from snowmpm.errors import InputError


def list_library(as_json: Json = False):
    """List library scenes, campaigns and observed avalanches, cards and kinds of material, cards and laws of friction,
    element tests."""
    from snowmpm import ground
    from snowmpm.campaigns.library import campaigns
    from snowmpm.events import store
    from snowmpm.materials import EXPERIMENTS, LAWS
    from snowmpm.scenes import friction_cards, library, material_cards

    tables = {
        "scenes": library(),
        "campaigns": campaigns(),
        "events": {name: _title(name) for name in store.events()},
        "cards": {name: card.description for name, card in material_cards().items()},
        "kinds": {kind: _first_sentence(law) for kind, law in sorted(LAWS.items())},
        "friction_cards": {name: card.description for name, card in friction_cards().items()},
        "friction_laws": {name: _first_sentence(law) for name, law in ground.LAWS.items()},
        "tests": {name: experiment.summary for name, experiment in EXPERIMENTS.items()},
    }
    if as_json:
        print_json(tables)
        return
    _print_table("Scenes (snowmpm run NAME)", tables["scenes"])
    print()
    _print_table("Campaigns (snowmpm campaign run NAME)", tables["campaigns"])
    print()
    _print_table("Observed avalanches (snowmpm run event:NAME, snowmpm events)", tables["events"])
    print()
    _print_table("Material cards (material = NAME in a scene)", tables["cards"])
    print()
    _print_table("Materials (kind = NAME in a scene)", tables["kinds"])
    print()
    _print_table("Classes of ground friction (card = NAME in [terrain.friction])", tables["friction_cards"])
    print()
    _print_table("Laws of ground friction (law = NAME in [terrain.friction])", tables["friction_laws"])
    print()
    _print_table("Tests of a material at one point (snowmpm element NAME)", tables["tests"])


def _title(name):
    """Of an observed avalanche, or why it cannot be read."""
    from snowmpm.events import store

    try:
        return store.event(name).title
    except InputError as error:
        return f"cannot be read: {error}"


def _first_sentence(law):
    return (law.__doc__ or "").strip().split("\n")[0]


def _print_table(title, entries):
    names = max((len(name) for name in entries), default=0)
    room = max(min(shutil.get_terminal_size((160, 24)).columns, LONGEST + 20) - names - 4, 30)
    bold, plain = ("\033[1m", "\033[0m") if sys.stdout.isatty() else ("", "")
    print(f"{bold}{title}{plain}")
    for name, text in entries.items():
        # In a pipe a line an entry, which grep finds
        rows = textwrap.wrap(text, room) if sys.stdout.isatty() else [text]
        print(f"  {name:<{names}}  {rows[0] if rows else ''}".rstrip())
        for row in rows[1:]:
            print(f"  {'':<{names}}  {row}")
