"""Material cards: published parameter sets, usable by name in a scene and in Python.

    [[bodies]]                     [materials.slab]
    material = "li_cold_dense"     card = "li_cold_dense"     # numbers given here override the card's
                                   p0 = 5.0e3

One file a card under library/materials, named after it. The law made from a card keeps the card's name as `card`, so a
resolved scene holds every number and its origin.

A card of one's own is such a file beside the scene (by its name, or with .toml) or anywhere (by its path). A resolved
scene also keeps its `source` as `card_source`; it no longer reads the file.
"""

import contextlib
import functools
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from snowmpm.errors import InputError, nearest
from snowmpm.materials import Material
from snowmpm.scenes.friction_cards import named_as_changed, with_friction_card
from snowmpm.scenes.messages import describe, shown
from snowmpm.scenes.space import base_dir
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


class OwnCard(Spec):
    """A card beside a scene: what is said of the numbers may be missing."""

    description: str = ""
    """one line"""
    source: str = ""
    """where the numbers are from"""
    validity: str = ""
    """range of validity and limits"""
    material: Material
    """the law"""


class _Cards(Mapping[str, MaterialCard]):
    """Each is read when it is asked for."""

    def __init__(self):
        self._files = {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}
        self._cards: dict[str, MaterialCard] = {}

    def __contains__(self, name: object) -> bool:
        return name in self._files

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, name: str) -> MaterialCard:
        if name not in self._cards:
            self._cards[name] = self._read(self._files[name])
        return self._cards[name]

    def _read(self, path: Path) -> MaterialCard:
        data = parse(path)
        if isinstance(data.get("material"), dict):
            data["material"]["card"] = path.stem
        try:
            return MaterialCard.model_validate(data)
        except ValidationError as error:
            raise InputError(describe(error, data, MaterialCard, path)) from None


@functools.cache
def material_cards() -> Mapping[str, MaterialCard]:
    """Name -> card, in alphabetical order."""
    return _Cards()


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
    named: dict[str, Any] = {name: {} for name in wanted if isinstance(name, str) and (
        name in cards or (name not in materials and _own_file(name)))}
    expanded = {name: expanded_material(name, table) for name, table in {**named, **materials}.items()}
    return {**data, "materials": expanded} if expanded or "materials" in data else data


def expanded_material(name: str, table: Any) -> Any:
    """The table of one material with its card written out, as `with_cards` does."""
    cards = material_cards()
    if not isinstance(table, dict) or "card_source" in table:  # the latter is of a resolved scene
        return table
    card = table.get("card", name if "kind" not in table and (name in cards or _own_file(name)) else None)
    if not isinstance(card, str):
        return table
    if card in cards:
        return named_as_changed(cards[card].material.model_dump(exclude_none=True), table, card)
    if (path := _own_file(card)) is None:
        raise refuse(f"no such material card: {_hint(card)}{_looked_for(card)}", f"materials.{name}.card", card)
    return named_as_changed({**own_card(path), "card": card}, {**table, "card": card}, card)


def own_card(path: Path) -> dict[str, Any]:
    """Numbers of a card of one's own, with `card` and `card_source`. Raises InputError, which names its file."""
    data = parse(path)
    table = data.get("material")
    begun = table.get("card") if isinstance(table, dict) else None
    if isinstance(begun, str):  # the numbers began with a card of the library
        if begun not in material_cards():
            raise InputError(f"{path}: material.card = {shown(begun)}: no such material card: {_hint(begun)}")
        data = {**data, "material": {**material_cards()[begun].material.model_dump(exclude_none=True), **table}}
    try:
        card = OwnCard.model_validate(data)
    except ValidationError as error:
        raise InputError(describe(error, data, OwnCard, path)) from None
    source = card.source or f"file {path.name}, which names no source"
    return {**card.material.model_dump(exclude_none=True), "card": path.stem, "card_source": source}


def _own_file(card: str) -> Path | None:
    """File of a card of one's own, by its name or path from the scene's folder; None where there is none."""
    folder = base_dir()
    if folder is None or "\0" in card or not card:
        return None
    named = card if card.endswith(".toml") else f"{card}.toml"
    if named == card or Path(card).name == card:
        path = folder / Path(named).expanduser()
        with contextlib.suppress(OSError):  # a name too long
            if path.is_file() and (named == card or "material" in parse(path)):
                return path
    return None


def _looked_for(card: str) -> str:
    folder = base_dir()
    return f" (nor a file {folder / card})" if folder is not None and card.endswith(".toml") else ""


def _hint(name: str) -> str:
    near = cards_near(name)
    return f"did you mean {near}?" if near else "`snowmpm list` names them"
