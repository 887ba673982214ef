"""Every key of a scene, from the schema: what it is, its unit, default, range, and an example."""

import re
from collections.abc import Iterator
from importlib import resources
from typing import Any, NamedTuple

from snowmpm.cli.reference.markdown import anchor, code, plain, table
from snowmpm.reading.toml_text import TOMLDecodeError, tables
from snowmpm.scenes import keytree
from snowmpm.scenes.toml import value_text

UNIT = re.compile(r"\[(-|(?:[A-Za-z%]+(?:\^?[\dm])?)(?:[ /][A-Za-z]+(?:\^?[\dm])?)*|1/[a-z]+)\]")
"""A unit in a description. Pairs of names, such as `[lower, upper]`, are none."""

WRITTEN = ("began_with", "card_source", "line_source", "points_source")
"""Keys that the program writes into the resolved scene of a run."""

LONGEST = 48
"""Characters of an example in a cell."""

INTRODUCTION = """# Every key of a scene

From the schema of the program: unit, default, range and an example of each key. A key without a default is needed,
unless the default is "none". {first}

`[name]` is one table, `[[name]]` one of a list of tables, `NAME` a name of your own. Numbers are in SI units.
Examples are from the library's scenes and the guides where these use the key.
"""


class Place(NamedTuple):
    """A table of the schema: where a scene has it first, as a reader writes it, and the value of `kind` or `law`."""

    node: dict[str, Any]
    path: tuple[str, ...]
    which: str
    many: bool

    def heading(self):
        """Title of its section."""
        inside = ".".join(part for part in self.path)
        written = f"[[{inside}]]" if self.many else f"[{inside}]"
        which = f"`{self.which}`" if "=" in self.which else self.which
        return ", ".join([f"`{written}`", *([which] if which else [])])


def page():
    """Keys of a scene as Markdown."""
    from snowmpm.scenes.schema import Scene

    first = "[Scenes](../scenes/README.md) says by task which ones you need."
    return keys_page(Scene.model_json_schema(), INTRODUCTION.format(first=first), _scenes())


def keys_page(schema, introduction, files):
    """Keys of a schema as Markdown. files: texts of TOML from which the examples are."""
    examples = _examples(schema, files)
    lines = [introduction]
    sections = _told_apart(list(_sections(schema)))
    anchors = {id(place.node): anchor(place.heading()) for place in sections}
    chapter = ""
    for place in sections:
        if place.path and place.path[0] != chapter:
            chapter = place.path[0]
            if place.which:
                words = schema["properties"][chapter].get("description", "")
                lines += [f"## {chapter.replace('_', ' ').capitalize()}", "", plain(words[:1].upper() + words[1:]), ""]
        if place.path:
            lines += [("## " if len(place.path) == 1 and not place.which else "### ") + place.heading(), ""]
        if place.node.get("description"):
            lines += [plain(place.node["description"].split("\n\n")[0]), ""]
        lines += table(("key", "what it is", "unit", "default", "allowed", "example"),
                       [_row(schema, place, key, node, anchors, examples)
                        for key, node in place.node.get("properties", {}).items() if key not in WRITTEN])
    return "\n".join(lines)


def units(schema):
    """{(table, key): unit or None} of every key with a number."""
    return {(place.heading(), key): _unit(node) for place in _sections(schema)
            for key, node in place.node.get("properties", {}).items() if _has_number(schema, node)}


def _row(schema, place, key, node, anchors, examples):
    about = keytree.resolved(schema, node)
    below = _tables(schema, node)
    words = node.get("description", "") or (below[0].get("description", "").split("\n\n")[0] if len(below) == 1 else
                                            about.get("description", ""))
    unit = _unit(node) if _has_number(schema, node) else None
    words = _without(unit, " ".join(words.split()))
    default = "" if key in place.node.get("required", ()) else "none"
    if node.get("default") is not None:
        default = "its own" if isinstance(node["default"], dict) else code(value_text(node["default"]))
    links = [f"[{_short_name(one, len(below) == 1)}](#{anchors[id(one)]})" for one in below]
    example = examples(place.node, key, node)
    allowed = ", ".join([*_allowed(schema, node), *links])
    return code(key), plain(words), code(unit or ""), default, allowed, code(example)


def _unit(node):
    found = UNIT.findall(node.get("description", ""))
    return found[0] if found else None


def _without(unit, words):
    """Words without the unit, which has a column."""
    for written in (f" [{unit}]", f"[{unit}]; ", f"[{unit}]"):
        if written in words:
            return words.replace(written, "", 1)
    return words


def _has_number(schema, node):
    about = keytree.resolved(schema, node)
    members = [*about.get("anyOf", ()), *about.get("oneOf", ()), *([about["items"]] if "items" in about else ())]
    return about.get("type") == "number" or any(_has_number(schema, one) for one in members
                                                if "properties" not in keytree.resolved(schema, one))


def _members(schema, node):
    """Alternatives of a node, without null."""
    about = keytree.resolved(schema, node)
    members = about.get("anyOf") or about.get("oneOf")
    if not members:
        return [] if about.get("type") == "null" else [about]
    return [one for member in members for one in _members(schema, member)]


def _tables(schema, node):
    """Tables that a key may hold: itself, in a list, or by name."""
    found = []
    for one in _members(schema, node):
        below = [one] if "properties" in one else [
            *([one["items"]] if isinstance(one.get("items"), dict) else ()),
            *(more for more in (one.get("additionalProperties"), *one.get("patternProperties", {}).values())
              if isinstance(more, dict))]
        for inner in below:
            found += [inner] if "properties" in inner else _tables(schema, inner)
    return found


def _which(node):
    """`kind = "box"` of a table that is one of several."""
    keys = node.get("properties", {})
    for key in sorted(keys, key=lambda key: key not in keytree.MEMBERS):
        if "const" in keys[key]:
            return f'{key} = "{keys[key]["const"]}"'
    return ""


def _short_name(node, alone):
    which = _which(node)
    return plain(which.split('"')[1] if which else "table" if alone else _title(node))


def _allowed(schema, node):
    """What a key may hold beside tables, in words."""
    for one in _members(schema, node):
        if "enum" in one or "const" in one:
            values = one.get("enum", [one.get("const")])
            yield ", ".join(code(value_text(value)) for value in values)
        elif one.get("type") in ("number", "integer"):
            yield plain(" ".join(["integer" if one["type"] == "integer" else "number", *_range(one)]))
        elif one.get("type") == "boolean":
            yield "`true`, `false`"
        elif one.get("type") == "string":
            yield "text"
        elif one.get("type") == "array" and not _tables(schema, one):
            yield _list(schema, one)


def _list(schema, one):
    items = one.get("items")
    inner = " or ".join(dict.fromkeys(_allowed(schema, items))) if isinstance(items, dict) else "value"
    least, most = one.get("minItems"), one.get("maxItems")
    count = f" of {least}" if least and least == most else f" of {least} to {most}" if least and most else \
        f" of at least {least}" if least else ""
    return f"list{count}: {inner}"


def _range(one):
    bounds = (("gt", ">"), ("exclusiveMinimum", ">"), ("ge", ">="), ("minimum", ">="), ("lt", "<"),
              ("exclusiveMaximum", "<"), ("le", "<="), ("maximum", "<="))
    said = {sign[0]: f"{sign} {one[key]:g}" for key, sign in reversed(bounds) if key in one and abs(one[key]) < 1e12}
    return [", ".join(said[side] for side in "><" if side in said)] if said else []


def _sections(schema) -> Iterator[Place]:
    """Tables of a schema in the order of a scene, each where it comes first."""
    whole = Place(schema, (), "", False)
    first, waiting = {id(schema): whole}, [whole]
    while waiting:
        for one in _below(schema, waiting.pop(0)):
            if id(one.node) not in first:
                first[id(one.node)] = one
                waiting.append(one)
    yield from _in_order(schema, whole, first)


def _told_apart(places):
    """The same with names of tables that stand at one place."""
    headings = [place.heading() for place in places]
    return [place._replace(which=_title(place.node)) if headings.count(place.heading()) > 1 else place
            for place in places]


def _in_order(schema, place, first):
    yield place
    for one in _below(schema, place):
        if first.get(id(one.node)) == one:
            del first[id(one.node)]
            yield from _in_order(schema, one, first)


def _below(schema, place):
    """Tables right below one."""
    for key, node in place.node.get("properties", {}).items():
        found = _tables(schema, node)
        for one in found:
            which = _which(one) or (_title(one) if len(found) > 1 else "")
            yield Place(one, (*place.path, *_named(schema, node, key)), which, _in_list(schema, node))


def _title(node):
    """Name of a table that its keys alone tell from others."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", node.get("title", "")).lower()


def _named(schema, node, key):
    named = any(one.get("additionalProperties") or one.get("patternProperties") for one in _members(schema, node)
                if "properties" not in one)
    return (key, "NAME") if named else (key,)


def _in_list(schema, node):
    return any(_tables(schema, one) for one in _members(schema, node) if one.get("type") == "array")


def _scenes():
    """Texts of the library's scenes, then of the guides, then of the cards."""
    library = resources.files("snowmpm.scenes") / "library"
    guides = resources.files("snowmpm.guides")
    for folder in (library, guides):
        for path in sorted(folder.iterdir(), key=lambda path: path.name):
            if path.name.endswith(".toml"):
                yield path.read_text(encoding="utf-8")
    pages = [*guides.iterdir(), *resources.files("snowmpm.scenes").iterdir()]
    for path in sorted(pages, key=lambda path: path.name):
        if path.name.endswith(".md"):
            yield from blocks(path.read_text(encoding="utf-8"))
    for path in sorted((library / "materials").iterdir(), key=lambda path: path.name):
        yield path.read_text(encoding="utf-8").replace("[material]", "[materials.card]")
    for path in sorted((library / "friction").iterdir(), key=lambda path: path.name):
        text = path.read_text(encoding="utf-8")
        if "[friction]" in text:
            yield text.replace("[friction]", '[terrain]\nkind = "plane"\n[terrain.friction]')


def _examples(schema, files):
    """(table, key, its node) -> text of an example."""
    own: dict[tuple[int, str], str] = {}
    others: dict[str, list[Any]] = {}
    for text in files:
        for node, key, value in keytree.given(schema, _parsed(text)):
            if not isinstance(value, dict) and not (isinstance(value, list) and value and isinstance(value[0], dict)):
                written = value_text(value)
                if len(written) <= LONGEST or (id(node), key) not in own:
                    own.setdefault((id(node), key), written)
                    others.setdefault(key, []).append(value)

    def example(place, key, node):
        members = _members(schema, node)
        if "const" in keytree.resolved(schema, node):
            return value_text(keytree.resolved(schema, node)["const"])
        if "examples" in node:
            return value_text(node["examples"][0])
        if (id(place), key) in own:
            return _short(own[id(place), key])
        if all("properties" in one or _tables(schema, one) for one in members):
            return ""
        if node.get("default") not in (None, [], ()) and not isinstance(node["default"], dict):
            return value_text(node["default"])
        for member in members:
            for value in member.get("enum", [member["const"]] if "const" in member else []):
                return value_text(value)
        found = [value for value in others.get(key, ()) if _fits(schema, members, value)]
        return _short(value_text(found[0])) if found else ""

    return example


def _fits(schema, members, value):
    kinds = {"number": (int, float), "integer": (int,), "string": (str,), "array": (list,), "boolean": (bool,)}
    return any(isinstance(value, kinds.get(one.get("type"), ())) for one in members)


def _short(text):
    return text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"


def blocks(text):
    """TOML blocks of a guide."""
    return re.findall(r"```toml\n(.*?)```", text, re.DOTALL)


def _parsed(text):
    try:
        return tables(text, "an example")
    except TOMLDecodeError:  # a guide may show alternatives, one below the other
        return {}
