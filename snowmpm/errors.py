"""What can go wrong, in the words a user reads."""

import difflib
import os
from collections.abc import Iterable
from pathlib import Path

THIN_SPACE = "\u202f"
"""Between groups of three digits; not printable to Python, which counts it as a separator."""

MOST = 1000
"""Characters of a message's line; paths and lists of names are seldom longer."""


def printable(text: str) -> str:
    """Text on one line, without what would move a terminal's cursor, recolour it or turn the direction of reading:
    such characters as escapes."""
    if text.replace(THIN_SPACE, "").isprintable():
        return text
    return "".join(c if c.isprintable() or c == THIN_SPACE else ascii(c)[1:-1] for c in text)


def shortened(text: str, most: int = MOST) -> str:
    """The beginning and the end of a text, together at most so many characters."""
    if len(text) <= most:
        return text
    end = (most - 3) // 3
    return f"{text[:most - 3 - end]}...{text[-end:]}"


def shown_line(text: object, most: int = MOST) -> str:
    """A foreign text as it may stand on a line of its own."""
    return printable(shortened(str(text), most))


def shown_lines(text: str, lines: int = 3, most: int = MOST) -> str:
    """The first lines of a message whose names and values may be anything, each fit to be shown."""
    return "\n".join(shown_line(line, most) for line in text.split("\n")[:lines])


class InputError(Exception):
    """Bad input: one or two lines naming file, key, value and what is allowed. The command line exits with 2."""

    @classmethod
    def at(cls, key: str, value: object, allowed: str, file: object = None) -> "InputError":
        """`file: key = value: allowed`, the one form of every message about a scene key."""
        where = f"{file}: " if file else ""
        return cls(f"{where}{key} = {shortened(repr(value))}: {allowed}")

    @classmethod
    def not_in(cls, key: str, value: object, known: Iterable[str], file: object = None, more: str = "") -> "InputError":
        """`key = value: must be one of ...`, with the nearest of the `known` names; more: what is allowed besides."""
        return cls.at(key, value, f"must be one of {', '.join(known)}{more}{did_you_mean(value, known)}", file=file)


class SimulationError(Exception):
    """A simulation that cannot go on: which particle, when and why. The command line exits with 1."""


class EndedError(SimulationError):
    """Something that lived in a Taichi which has ended since: by `ti.init`, `ti.reset`, or in a forked process."""


class WriteError(SimulationError):
    """A run that cannot write what it has to (disk full, folder gone): where, why, and what is safe."""


LONGEST_NAME = 100
"""Characters of a word that may be meant to be one of our names."""


def nearest(word: object, known: Iterable[object]) -> str | None:
    """The name among `known` that `word` was probably meant to be, or None."""
    if not isinstance(word, str) or len(word) > LONGEST_NAME:
        return None
    folded = {name.lower().replace("-", "_"): name for name in map(str, known)}
    word = word.lower().replace("-", "_")
    near = difflib.get_close_matches(word, folded, n=1, cutoff=0.6)
    # A beginning is a guess too, though a short one: "vel", "cohesive"
    begun = [name for name in folded if len(word) >= 3 and name.startswith(word)]
    return folded[(near or begun)[0]] if near or begun else None


def did_you_mean(word: object, known: Iterable[object]) -> str:
    """"; did you mean NAME?" with the nearest of `known`, or "" when none is near."""
    near = nearest(word, known)
    return f"; did you mean {near}?" if near else ""


def nearest_file(path: str | os.PathLike[str]) -> str:
    """"; did you mean FILE?" with a file of about this name beside `path`, or ""."""
    path = Path(path)
    try:
        names = [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return ""
    near = nearest(path.name, names)
    return f"; did you mean {path.parent / near}?" if near else ""
