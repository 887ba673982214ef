"""What can go wrong, in the words a user reads."""

import difflib
from pathlib import Path


class InputError(Exception):
    """Bad input: one or two lines naming file, key, value and what is allowed. The command line exits with 2."""

    @classmethod
    def at(cls, key, value, allowed, file=None):
        """`file: key = value: allowed`, the one form of every message about a scene key."""
        where = f"{file}: " if file else ""
        return cls(f"{where}{key} = {value!r}: {allowed}")

    @classmethod
    def not_in(cls, key, value, known, file=None, more=""):
        """`key = value: must be one of ...`, with the nearest of the `known` names; more: what is allowed besides."""
        return cls.at(key, value, f"must be one of {', '.join(known)}{more}{did_you_mean(value, known)}", file=file)


class SimulationError(Exception):
    """A simulation that cannot go on: which particle, when and why. The command line exits with 1."""


class WriteError(SimulationError):
    """A run that cannot write what it has to (disk full, folder gone): where, why, and what is safe."""


def nearest(word, known):
    """The name among `known` that `word` was probably meant to be, or None."""
    if not isinstance(word, str):
        return None
    folded = {name.lower().replace("-", "_"): name for name in map(str, known)}
    word = word.lower().replace("-", "_")
    near = difflib.get_close_matches(word, folded, n=1, cutoff=0.6)
    # A beginning is a guess too, though a short one: "vel", "cohesive"
    begun = [name for name in folded if len(word) >= 3 and name.startswith(word)]
    return folded[(near or begun)[0]] if near or begun else None


def did_you_mean(word, known):
    """"; did you mean NAME?" with the nearest of `known`, or "" when none is near."""
    near = nearest(word, known)
    return f"; did you mean {near}?" if near else ""


def nearest_file(path):
    """"; did you mean FILE?" with a file of about this name beside `path`, or ""."""
    path = Path(path)
    try:
        names = [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return ""
    near = nearest(path.name, names)
    return f"; did you mean {path.parent / near}?" if near else ""
