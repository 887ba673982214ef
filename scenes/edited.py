"""Changes of values in the text of a scene that keep its comments."""

import re
import sys

from snowmpm.errors import InputError
from snowmpm.scenes.messages import dotted
from snowmpm.scenes.toml import value_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HEADER = re.compile(r"\s*\[(\[?)\s*([A-Za-z0-9_.-]+)\s*\]\]?\s*(#.*)?$")
ENTRY = re.compile(r"\s*([A-Za-z0-9_-]+)\s*=\s*(.*)$")


def edited(text, overrides):
    """Text of a scene with other values: dotted key -> value, as `load_scene` takes overrides.

    An existing key keeps its line and its comment; a new key is added to its table, and takes the place of a table of
    that name. InputError: a key within a value of
    several lines, or within something that is no table.
    """
    for key, value in overrides.items():
        text = _with(text, key.split("."), value)
    return text


def _with(text, parts, value):
    lines = _without_table(text.split("\n"), parts)
    end = None
    for path, start, stop in _tables(lines):
        if path != parts[: len(path)] or len(path) == len(parts):
            continue
        rest = parts[len(path) :]
        for i in range(start, stop):
            entry = ENTRY.match(lines[i])
            if entry and entry[1] == rest[0]:
                lines[i] = _line(lines[i], entry, rest, value, parts)
                return "\n".join(lines)
        if len(rest) == 1:
            end = max([start, *(i + 1 for i in range(start, stop) if ENTRY.match(lines[i]))])
    if end is None:  # a new table at the end
        if any(part.isdigit() for part in parts):
            raise InputError(f"--set {dotted(parts)}: the scene has no such table")
        text = "\n".join(lines).rstrip()
        return f"{text}\n\n[{'.'.join(parts[:-1])}]\n{parts[-1]} = {value_text(value)}\n"
    lines.insert(end, f"{parts[-1]} = {value_text(value)}")
    return "\n".join(lines)


def _without_table(lines, parts):
    """The lines without the headers and entries of the table that has the name of the key, and of those below it."""
    kept = list(lines)
    for path, start, stop in _tables(lines):
        if path[: len(parts)] == parts and start:
            kept[start - 1 : stop] = [None, *(line if not line.strip() or line.lstrip().startswith("#") else None
                                              for line in lines[start:stop])]
    return [line for line in kept if line is not None]


def _tables(lines):
    """(path, first line, one past the last) of each table; entries of lists have their number in the path."""
    path, start, counts = [], 0, {}
    for i, line in enumerate(lines):
        header = HEADER.match(line)
        if not header:
            continue
        yield path, start, i
        name = header[2].split(".")
        if header[1]:
            counts[header[2]] = counts.get(header[2], -1) + 1
            path = [*name, str(counts[header[2]])]
        else:
            path = [part for k, part in enumerate(name) for part in
                    ([part] if ".".join(name[: k + 1]) not in counts else [part, str(counts[".".join(name[: k + 1])])])]
        start = i + 1
    yield path, start, len(lines)


def _line(line, entry, rest, value, parts):
    """A line with a new value, or with a new value of a key in its inline table."""
    own, comment = _split(entry[2], parts)
    if len(rest) > 1:
        here = own
        for part in rest[1:-1]:
            here = here.setdefault(part, {}) if isinstance(here, dict) else None
        if not isinstance(here, dict):
            raise InputError(f"--set {dotted(parts)}: {entry[1]} has no such key")
        here[rest[-1]] = value
        value = own
    return f"{line[: entry.start(2)]}{value_text(value)}{comment}"


def _split(text, parts):
    """The value of an entry, and the comment behind it with the blanks before that."""
    for end in [*(match.start() for match in re.finditer("#", text)), len(text)]:
        try:
            return tomllib.loads(f"value = {text[:end]}")["value"], text[len(text[:end].rstrip()) :]
        except tomllib.TOMLDecodeError:
            continue
    raise InputError(f"--set {dotted(parts)}: its value has several lines: change it in the file")
