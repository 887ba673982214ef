"""Material cards: published parameter sets, usable by name in a scene and in Python.

    [[bodies]]                     [materials.slab]
    material = "li_cold_dense"     card = "li_cold_dense"     # numbers given here override the card's
                                   p0 = 5.0e3

One file a card under library/materials, named after it. The law made from a card keeps the card's name as `card`, so a
resolved scene holds every number and its origin.
"""

import functools
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from snowmpm.errors import InputError, nearest
from snowmpm.materials import Material
from snowmpm.scenes.friction_cards import with_friction_card
from snowmpm.scenes.messages import describe, shown
from snowmpm.scenes.spec import Spec, refuse
from snowmpm.scenes.toml import parse

FOLDER = Path(__file__).parent / "library" / "materials"


class MaterialCard(Spec):
    """A set of numbers for one law, with its source."""

    description: str
    """one line"""
    source: str
    """where every number is from, with the DOI"""
    validity: str
    """range of validity and limits"""
    material: Material
    """the law"""


@functools.cache
def material_cards() -> dict[str, MaterialCard]:
    """Name -> card, in alphabetical order."""
    cards = {}
    for path in sorted(FOLDER.glob("*.toml")):
        data = parse(path)
        if isinstance(data.get("material"), dict):
            data["material"]["card"] = path.stem
        try:
            cards[path.stem] = MaterialCard.model_validate(data)
        except ValidationError as error:
            raise InputError(describe(error, data, MaterialCard, path)) from None
    return cards


def material_card(name: str) -> Material:
    """The law of a card. Raises InputError for an unknown name."""
    cards = material_cards()
    if name not in cards:
        raise InputError(f"no material card {shown(name)}: {_hint(name)}")
    return cards[name].material


def cards_near(name: str) -> str | None:
    """The card with the most similar name, or None."""
    return nearest(name, material_cards())


def with_cards(data: Any) -> Any:
    """Tables of a scene with the numbers of the cards it names written out; the data given stays as it is.

    Numbers given beside `card` override the card's. A body's material that the scene does not define is a card by that
    name. The terrain's friction may name a friction card. Raises PydanticCustomError for a card that does not exist.
    """
    if not isinstance(data, dict):
        return data
    data = with_friction_card(data)
    bodies, materials = data.get("bodies"), data.get("materials", {})
    bodies = bodies if isinstance(bodies, list | tuple) else ()
    wanted = [body.get("material") for body in bodies if isinstance(body, dict)]
    if not isinstance(materials, dict):
        return data
    cards = material_cards()
    named: dict[str, Any] = {name: {} for name in wanted if isinstance(name, str) and name in cards}
    expanded = {name: expanded_material(name, table) for name, table in {**named, **materials}.items()}
    return {**data, "materials": expanded} if expanded or "materials" in data else data


def expanded_material(name: str, table: Any) -> Any:
    """The table of one material with its card written out, as `with_cards` does."""
    cards = material_cards()
    if not isinstance(table, dict):
        return table
    card = table.get("card", name if name in cards and "kind" not in table else None)
    if not isinstance(card, str):
        return table
    if card not in cards:
        raise refuse(f"no such material card: {_hint(card)}", f"materials.{name}.card", card)
    return {**cards[card].material.model_dump(exclude_none=True), **table}


def _hint(name: str) -> str:
    near = cards_near(name)
    return f"did you mean {near}?" if near else "`snowmpm list` names them"
