"""Friction cards: published classes of ground friction, usable by name in `[terrain.friction]`.

One file a card under library/friction, named after it. The law made from a card keeps the card's name as `card`, so a
resolved scene holds every number and its origin. A card with `classes` names other cards, of which the volume of the
release chooses one.
"""

import functools
from pathlib import Path
from typing import Any

from pydantic import ValidationError, model_validator

from snowmpm.errors import InputError, nearest
from snowmpm.ground import FrictionLaw, GroundLaw
from snowmpm.quantities.quantity import written
from snowmpm.quantities.resolution import rounded
from snowmpm.scenes.friction import BY_VOLUME, ByVolume
from snowmpm.scenes.messages import describe, shown
from snowmpm.scenes.spec import Number, Spec, refuse
from snowmpm.scenes.toml import parse

FOLDER = Path(__file__).parent / "library" / "friction"
RETIRED = frozenset(f"ramms_s300_{ground}_{side}_1000" for ground in ("channelled", "flat", "gully", "open")
                    for side in ("above", "below"))
"""Cards of 0.1.0: runs that began with them hold their numbers."""


class Band(Spec):
    """Part of an axis: least <= value < below; open where an end is missing."""

    least: Number | None = None
    below: Number | None = None

    def __contains__(self, value: float) -> bool:
        return (self.least is None or value >= self.least) and (self.below is None or value < self.below)

    def said(self, unit: str) -> str:
        """The band in words."""
        parts = [f"from {written(self.least, unit)}"] if self.least is not None else []
        return " ".join([*parts, *([f"below {written(self.below, unit)}"] if self.below is not None else [])])


class FrictionCard(Spec):
    """A class of ground friction: a law with its numbers, or a list of classes; source and range of validity."""

    description: str
    """one line"""
    source: str
    """where every number is from, with the DOI or the document"""
    validity: str
    """range of validity and limits"""
    volume: Band = Band()
    """of the release [m3]"""
    runout_altitude: Band = Band()
    """where the flow comes to rest [m above sea level]"""
    any_volume_above: Number | None = None
    """run-out altitude from which the volume does not matter [m above sea level]"""
    friction: GroundLaw | None = None
    """the law"""
    classes: tuple[str, ...] = ()
    """cards of which the volume of the release chooses one"""

    @model_validator(mode="after")
    def _is_one(self):
        if (self.friction is None) != bool(self.classes):
            raise refuse("needs one of friction and classes")
        return self

    def doubts(self, volume: float | None = None, runout_altitude: float | None = None,
               ground: tuple[float, float] | None = None) -> list[str]:
        """Why the class does not hold, one text a reason; none where it may.

        volume: of the release [m3]; runout_altitude: where the flow rests [m above sea level]; ground: lowest and
        highest altitude of the terrain. What is not known is not judged; before a run, a flow rests nowhere below the
        lowest ground.
        """
        found = []
        lowest = runout_altitude if ground is None or runout_altitude is not None else ground[0]
        high = lowest is not None and self.any_volume_above is not None and lowest >= self.any_volume_above
        if volume is not None and volume not in self.volume and not high:
            found.append(f"the release has {written(rounded(volume), 'm3')}, and the class is for a volume"
                         f" {self.volume.said('m3')}")
        if lowest is not None and lowest not in self.runout_altitude:
            rests = "the flow rests at" if runout_altitude is not None else "no ground lies below"
            found.append(f"{rests} {lowest:.0f} m, and the class is for a run-out {self.runout_altitude.said('m')}")
        return found


@functools.cache
def friction_cards() -> dict[str, FrictionCard]:
    """Name -> card, in alphabetical order."""
    cards = {}
    for path in sorted(FOLDER.glob("*.toml")):
        data = parse(path)
        if isinstance(data.get("friction"), dict):
            data["friction"]["card"] = path.stem
        try:
            cards[path.stem] = FrictionCard.model_validate(data)
        except ValidationError as error:
            raise InputError(describe(error, data, FrictionCard, path)) from None
    return cards


def friction_card(name: str) -> FrictionCard:
    """A card by its name. Raises InputError for an unknown one."""
    cards = friction_cards()
    if name not in cards:
        raise InputError(f"no friction card {shown(name)}: {_hint(name)}")
    return cards[name]


def law_for_volume(card: FrictionCard, volume: float) -> FrictionLaw:
    """The law of a card, of the class for a release of this volume [m3] if it lists classes."""
    if card.friction is not None:
        return card.friction
    for name in card.classes:
        found = friction_card(name)
        if found.friction is not None and volume in found.volume:
            return found.friction
    raise InputError(f"no class of {', '.join(card.classes)} is for a release of {volume:.4g} m3")


def possible_laws(friction: FrictionLaw | ByVolume) -> list[FrictionLaw]:
    """Laws that the friction of a scene may turn out to be: itself, or those of its classes."""
    if isinstance(friction, FrictionLaw):
        return [friction]
    classes = [friction_card(name).friction for name in friction_card(friction.card).classes]
    return [law for law in classes if law is not None]


def with_friction_card(data: Any) -> Any:
    """Tables of a scene with the numbers of the friction card that its terrain names written out; the data given stays
    as it is. Numbers given beside `card` override the card's. Raises PydanticCustomError for an unknown card."""
    terrain = data.get("terrain") if isinstance(data, dict) else None
    if not isinstance(terrain, dict) or not isinstance(table := terrain.get("friction"), dict):
        return data
    name = table.get("card")
    if not isinstance(name, str):
        return data
    cards = friction_cards()
    if name in RETIRED:
        if "law" not in table:
            raise refuse("was removed, since its numbers were not published: give law, mu and xi in its place",
                         "terrain.friction.card", name)
        return data  # the resolved scene of an earlier run, with all its numbers
    if name not in cards:
        raise refuse(f"no such friction card: {_hint(name)}", "terrain.friction.card", name)
    law = cards[name].friction
    numbers = {"law": BY_VOLUME} if law is None else law.model_dump(exclude_none=True)
    if "k" in table:  # the drag in another form
        numbers.pop("xi", None)
    found = {**numbers, **table} if law is None else named_as_changed(numbers, table, name)
    return {**data, "terrain": {**terrain, "friction": found}}


def named_as_changed(numbers: dict[str, Any], table: dict[str, Any], card: str) -> dict[str, Any]:
    """The numbers of a card with those of a table in their place. Where some differ they are no longer the card's,
    which is then `began_with`."""
    merged = {**numbers, **table}
    if any(key not in numbers or numbers[key] != value for key, value in table.items() if key != "card"):
        merged = {**{key: value for key, value in merged.items() if key != "card"}, "began_with": card}
    return merged


def _hint(name: str) -> str:
    near = nearest(name, friction_cards())
    return f"did you mean {near}?" if near else "`snowmpm list` names them"
