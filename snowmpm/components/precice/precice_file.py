"""A configuration of preCICE, version 3: what it says of one participant and of the scheme that couples it."""

from dataclasses import dataclass

from snowmpm.errors import InputError, did_you_mean
from snowmpm.reading.xml_file import read_xml

ROOT = "precice-configuration"
SCHEME = "coupling-scheme:"


@dataclass(frozen=True)
class Windows:
    """Time windows of the scheme that couples a participant.

    scheme: its name, such as "serial-explicit"; implicit: whether windows are repeated until both programs agree;
    ahead: whether the answer for the end of a window is known in it: where they are, and to the second of two that
    take turns; size [s]: None where the steps of the first participant are the windows; end [s]: of the coupling;
    rounds: how often a window is computed at most, None without a limit.
    """

    scheme: str
    implicit: bool
    ahead: bool
    size: float | None
    end: float
    rounds: int | None = None


class PreciceFile:
    """The tags of a file. Messages name it, and the key of the scene that does not fit."""

    def __init__(self, path, table, source):
        """path: of the file; table: key of the scene's table that names it; source: of the scene.

        InputError: it cannot be read, or is no configuration of version 3.
        """
        self._path, self._table, self._source = path, table, source
        try:  # without namespaces: tags such as data:vector have prefixes that none declares
            self._root = read_xml(path)
        except OSError as error:
            raise self._refusal("file", str(path), f"cannot be read: {error.strerror}") from None
        except InputError as error:
            raise self._refusal("file", str(path), str(error).removeprefix(f"{path}: ")) from None
        if self._root.tag != ROOT or self._root.find("solver-interface") is not None:
            raise self._refusal("file", str(path), f"must be a <{ROOT}> of preCICE, version 3")

    def check(self, participant, mesh, dim, written, read):
        """Raise InputError unless a participant provides a mesh fit for such a scene, and writes and reads these data.

        mesh: its name; dim: of the scene; written, read: key of the scene -> name of vectors on that mesh.
        """
        own = self._named("participant", participant, self._root.findall("participant"), "a participant")
        self._named("mesh", mesh, own.findall("provide-mesh"), f"a mesh that {participant} provides")
        dimensions = self._named("mesh", mesh, self._root.findall("mesh"), "a mesh").get("dimensions")
        allowed = {2: ("2", "3"), 3: ("3",)}[dim]
        if dimensions not in allowed:
            raise self._refusal("mesh", mesh, f'must have dimensions="{allowed[-1]}" in {self._path}, as the scene is'
                                              f" {dim}-D, and has {dimensions}")
        vectors = self._root.findall("data:vector")
        for way, names in (("write", written), ("read", read)):
            there = [tag for tag in own.findall(f"{way}-data") if tag.get("mesh") == mesh]
            for key, name in names.items():
                self._named(key, name, there, f"what {participant} has as {way}-data of {mesh}")
                self._named(key, name, vectors, "a data:vector")

    def windows(self, participant):
        """`Windows` of a participant. InputError: not one scheme couples it, or windows are as long as steps where they
        are repeated or where the steps are those of the other program."""
        schemes = [tag for tag in self._root if tag.tag.startswith(SCHEME) and participant in _partners(tag)]
        if len(schemes) != 1:
            raise self._refusal("participant", participant,
                                f"must take part in one coupling-scheme of {self._path}, and does in {len(schemes)}")
        scheme = schemes[0]
        kind = scheme.tag.removeprefix(SCHEME)
        implicit = not kind.endswith("explicit")
        second = kind.startswith("serial") and _partners(scheme)[-1] == participant
        given = scheme.find("time-window-size")
        free = given is not None and given.get("method") == "first-participant"
        if free and (implicit or second):
            raise self._refusal("participant", participant, f'must be the first of a serial-explicit scheme in'
                                f' {self._path}, where time-window-size has method="first-participant"')
        size = None if free else self._number(scheme, "time-window-size")
        ends = [self._number(scheme, "max-time")]
        if size and (windows := self._number(scheme, "max-time-windows")):
            ends.append(size * windows)
        end, rounds = min(filter(None, ends), default=None), self._number(scheme, "max-iterations")
        if end is None:
            raise self._refusal("file", str(self._path), "must have a max-time in its coupling-scheme")
        return Windows(kind, implicit, implicit or second, size, end, rounds and int(rounds))

    def _number(self, scheme, name):
        """The value of a tag of a scheme; None where it is not there."""
        tag = scheme.find(name)
        if tag is None:
            return None
        try:
            return float(tag.get("value"))
        except (TypeError, ValueError):
            raise self._refusal("file", str(self._path), f"<{name}> must have a number as its value") from None

    def _named(self, key, name, tags, what):
        """The tag of this name; InputError where none has it."""
        by_name = {tag.get("name"): tag for tag in tags}
        if name not in by_name:
            known = ", ".join(map(str, by_name)) or "none"
            near = did_you_mean(name, by_name)
            raise self._refusal(key, name, f"must be {what} in {self._path}: {known}{near}")
        return by_name[name]

    def _refusal(self, key, value, allowed):
        return InputError.at(f"{self._table}.{key}", value, allowed, self._source)


def _partners(scheme):
    """Names of the participants of a scheme."""
    both = scheme.find("participants")
    if both is not None:
        return [both.get("first"), both.get("second")]
    return [tag.get("name") for tag in scheme.findall("participant")]
