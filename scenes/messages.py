"""Error messages for a scene, one or two lines: file, key, value and what is allowed."""

import functools
import re

from snowmpm import registry
from snowmpm.errors import did_you_mean, printable, shown_line
from snowmpm.scenes.keytree import kinds_at, places, real_keys, table_at

MAX_LINES = 2
MAX_VALUE = 60  # characters of a value that a message repeats
MAX_KEY = 120  # and of a key

ALLOWED = {
    "greater_than": "must be > {gt:g}",
    "greater_than_equal": "must be >= {ge:g}",
    "less_than": "must be < {lt:g}",
    "less_than_equal": "must be <= {le:g}",
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "string_type": 'must be text in quotes: "..."',
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must be made of letters, digits, _, - and ., and start with a letter or digit",
    "too_short": "too few entries, at least {min_length} needed",
    "too_long": "too many entries, at most {max_length} allowed",
    "tuple_type": "must be a list: [...]",
    "list_type": "must be a list: [...]",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "dataclass_type": "must be a table",
    "literal_error": "must be {expected}",
    "enum": "must be {expected}",
    "union_tag_invalid": "must be {expected_tags}",
    "scene_check": "{allowed}",
}


def describe(error, data, model, file):
    """Text of a pydantic ValidationError of `model` on `data`, at most MAX_LINES lines, the most helpful first.

    file: name that stands before each line.
    """
    schema = schema_of(model)
    # An unknown key usually explains the missing one.
    order = {"extra_forbidden": 0, "unexpected_keyword_argument": 0, "missing": 2, "missing_keyword_only_argument": 2}
    problems = error.errors(include_url=False)
    # A list with a bad entry is also reported as too short; the entry is the error.
    within = {problem["loc"][:n] for problem in problems for n in range(len(problem["loc"]))}
    problems = sorted(
        (problem for problem in problems if problem["loc"] not in within or not problem["loc"]),
        key=lambda problem: order.get(problem["type"], 1),
    )
    lines = list(dict.fromkeys(f"{file}: {_line(problem, data, schema)}" for problem in problems))
    if len(lines) > MAX_LINES:
        lines = [*lines[: MAX_LINES - 1], f"{lines[MAX_LINES - 1]} (and {len(lines) - MAX_LINES} more)"]
    return "\n".join(lines)


def schema_of(model):
    """JSON schema of a pydantic model."""
    return _schema(model, registry.generation)


@functools.cache
def _schema(model, generation):
    return model.model_json_schema()


def _line(problem, data, schema):
    kind, context = problem["type"], problem.get("ctx", {})
    path = real_keys(problem["loc"], data)
    key = dotted(path)
    if kind in ("missing", "missing_keyword_only_argument", "missing_argument"):
        about = table_at(schema, path, data).get("description", "")
        return f"{key} is missing" + (f": {' '.join(about.split())}" if about else "")
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        known = sorted(table_at(schema, path[:-1], data).get("properties", {}))
        return f"{key} = {shown(problem['input'])}: unknown key{_meant(schema, path, data, known)}"
    value = problem["input"]
    if context.get("key"):
        key, value = dotted((*path, context["key"])), context["value"]
        if value is None:
            return f"{key} {context['allowed']}"
    if kind == "union_tag_invalid":
        key, value = dotted((*path, _name_of_kind(context))), context["tag"]
        tags = context["expected_tags"]
        return f"{key} = {shown(value)}: must be one of {tags.replace(chr(39), chr(34))}{_nearest_of(value, tags)}"
    if kind == "union_tag_not_found":
        if isinstance(value, dict):
            kinds = ", ".join(map(shown, kinds_at(schema, path, data)))
            return f"{dotted((*path, _name_of_kind(context)))} is missing: one of {kinds}"
        return f"{key} = {shown(value)}: must be a table with a key {_name_of_kind(context)}"
    template = ALLOWED.get(kind)
    if template is None:
        return f"{key} = {shown(value)}: {problem['msg']}"
    text = template.format(**{name: _plain(entry) for name, entry in context.items()})
    if "expected" in context:
        text += _nearest_of(value, context["expected"])
    return f"{key} = {shown(value)}: {text}" if key else text


def _name_of_kind(context):
    """Key that says which member of a union a table is."""
    return context["discriminator"].strip("'")


def _plain(entry):
    return entry.replace("'", '"') if isinstance(entry, str) and entry.startswith("'") else entry


def _nearest_of(value, listed):
    """The suggestion for a value among the names that pydantic lists in quotes: 'apic', 'pic' or 'flip'."""
    return did_you_mean(value, re.findall(r"'([^']+)'", listed))


SYNONYMS = {"E": "youngs_modulus", "nu": "poisson_ratio", "rho": "density", "g": "gravity", "phi": "friction_angle",
            "c": "cohesion"}
"""Usual symbols, and the keys that they are meant to be."""

MOST_PLACES = 3
"""Places that are named for a key at a wrong one."""


def _meant(schema, path, data, known):
    """What an unknown key may be meant to be: by another name here, the same name elsewhere, or nearly a name here."""
    word = str(path[-1])
    named = SYNONYMS.get(word, word)
    if named in known:
        return f"; did you mean {named}?"
    elsewhere = _elsewhere(schema, named, path, data)
    if elsewhere:
        return f"; did you mean {' or '.join(elsewhere)}?"
    return _suggestion(word, known)


def _elsewhere(schema, word, path, data):
    """Keys of this name at other places of the schema: of the same top table, else of those that are there, else of
    all, the shortest of them."""
    found = [place for place in _places(schema["title"], schema) if place[-1] == word and place != tuple(path)
             and (0 not in place or place[0] in data or len(place) == 3)]
    for near in ((place for place in found if place[0] == path[0]), (place for place in found if place[0] in data)):
        if chosen := list(near):
            found = chosen
            break
    shortest = min(map(len, found), default=0)
    return [dotted(place) for place in found if len(place) == shortest][:MOST_PLACES]


_PLACES: dict[tuple[str, int], list[tuple[str | int, ...]]] = {}


def _places(title, schema):
    """All places of a schema, which takes a second to walk: only once."""
    key = title, registry.generation
    if key not in _PLACES:
        _PLACES[key] = [place for paths in places(schema).values() for place in paths]
    return _PLACES[key]


def _suggestion(word, known):
    return did_you_mean(word, known) or (f"; known here: {', '.join(known)}" if known else "")


def dotted(path):
    """Path to a value as one key: bodies.0.velocity."""
    return shown_line(".".join(str(part) for part in path), MAX_KEY)


def shown(value):
    """A value as it stands in TOML, shortened."""
    if isinstance(value, bool):
        text = "true" if value else "false"
    elif isinstance(value, str):
        text = f'"{printable(value[: MAX_VALUE + 1])}"'
    elif isinstance(value, dict):
        items = [f"{printable(key[:MAX_VALUE])} = {shown(item)}" for key, item in list(value.items())[:5]]
        text = "{" + ", ".join(items) + "}"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(shown(item) for item in value[:20]) + "]"
    else:
        text = str(value)
    return text if len(text) <= MAX_VALUE else text[: MAX_VALUE - 3] + "..."
