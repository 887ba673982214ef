"""Files that a scene names: found where it says, and what was in them noted when they are read."""

import contextlib
import hashlib
from contextvars import ContextVar
from pathlib import Path

from snowmpm import overwriting
from snowmpm.errors import InputError

BESIDE = (".shx", ".dbf", ".cpg", ".prj", ".tfw", ".raw", ".zraw")
"""Endings of files of the same name that belong to one: of shapefiles, world files, voxel images."""

CHUNK = 1 << 22

_noted: ContextVar[dict | None] = ContextVar("noted", default=None)


@contextlib.contextmanager
def noting(found):
    """Context in which the digest of each file that is read is noted in a dict: {resolved path: digest}, and in that of
    a context around it."""
    around, before = _noted.get(), _noted.set(found)
    try:
        yield found
    finally:
        _noted.reset(before)
        if around is not None:
            around.update(found)


def existing(file, base_dir, key):
    """Path of a file named in a scene, which is about to be read; InputError when there is none."""
    path = Path(base_dir) / Path(str(file)).expanduser()
    if not path.is_file():
        raise InputError.at(key, str(file), f"no such file (looked for {path})")
    overwriting.reads(path)
    found = _noted.get()
    if found is not None and path.resolve() not in found:
        found[path.resolve()] = digest_of(path)
    return path


def digest_of(path):
    """SHA-256 of a file and of those beside it that belong to it. Raises InputError where it cannot be read."""
    digest = hashlib.sha256()
    try:
        for one in (path, *beside(path)):
            with open(one, "rb") as file:
                while chunk := file.read(CHUNK):
                    digest.update(chunk)
            digest.update(one.suffix.lower().encode())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    return digest.hexdigest()


def beside(path):
    """Files of the same name that belong to one, in order."""
    path = Path(path)
    names = {one for ending in BESIDE for one in (ending, ending.upper())} - {path.suffix}
    candidates = [*(path.with_suffix(name) for name in sorted(names)), path.with_name(f"{path.name}.aux.xml")]
    return [one for one in candidates if one.is_file()]


def files_named(value, key=""):
    """Yield (dotted key, name) of each file that the tables of a scene name."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list | tuple) else ()
    for name, item in items:
        inner = f"{key}.{name}".lstrip(".")
        if name == "file" and isinstance(item, str):
            yield inner, item
        else:
            yield from files_named(item, inner)


def companion(path, suffix):
    """The file of the same name with another suffix, in small letters or in capitals; None where there is none."""
    found = (Path(path).with_suffix(one) for one in (suffix, suffix.upper()))
    return next((one for one in found if one.is_file()), None)
