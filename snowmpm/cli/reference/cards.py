"""Material cards and classes of ground friction: what each is for, its numbers and their sources."""

from snowmpm.cli.reference.markdown import code, plain, table
from snowmpm.keys import docstrings
from snowmpm.scenes.toml import value_text

INTRODUCTION = """# Cards

A card is a set of numbers with its source, usable by name: `material = "li_warm_shear"` for a body,
`card = "samos_at_auto"` in `[terrain.friction]`. Numbers given beside a card replace its own. Cite the source of a card
that you use.
"""


def page():
    """All cards as Markdown."""
    from snowmpm.scenes import friction_cards, material_cards

    lines = [INTRODUCTION]
    lines += table(("friction of the ground", "for releases of", "what it is"),
                   [(code(name), card.volume.said("m3") or "any volume", plain(card.description))
                    for name, card in friction_cards().items()])
    lines += table(("material", "law", "what it is"),
                   [(code(name), code(card.material["kind"]), plain(card.description))
                    for name, card in material_cards().items()])
    lines += ["## Materials", ""]
    for name, card in material_cards().items():
        lines += _card(name, card, card.material, "kind")
    lines += ["## Classes of ground friction", ""]
    for name, card in friction_cards().items():
        lines += _card(name, card, card.friction, "law")
    return "\n".join(lines)


def _card(name, card, law, key):
    yield from (f"### `{name}`", "", plain(card.description) + ".", "", f"Valid for: {plain(card.validity)}", "",
                f"Source: {plain(card.source)}.".replace("..", "."), "")
    if law is None:
        yield from (f"By the volume of the release: {', '.join(code(one) for one in card.classes)}.", "")
        return
    given = {one: value for one, value in law.model_dump(exclude_none=True, exclude_unset=True).items()
             if one not in ("card", key)}
    yield from (f"`{key} = \"{law[key]}\"`", "")
    words = docstrings(type(law))
    yield from table(("key", "value", "what it is"),
                     [(code(one), code(value_text(value)), plain(words.get(one, "")))
                      for one, value in given.items()])
