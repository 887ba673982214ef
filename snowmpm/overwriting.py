"""What may be replaced: files that this program wrote and nobody has changed since, and no other unless it is told to.

Each folder keeps a list of what was written there, `LIST`: a line a file, with the digest of its content and its name.
A file that changed since, that came from elsewhere, or that the present command reads, is the user's. Commands, runs
and campaigns keep it. A function that is called from Python with the name of a file writes it, and lists nothing.
"""

import contextlib
import errno
import hashlib
import os
import stat
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from snowmpm.errors import InputError

LIST = ".snowmpm-files"
"""Hidden list of a folder of results."""

PIECE = 1 << 20
"""Bytes of a file that are read at a time."""

MOST = 1 << 20
"""Bytes of a list beyond which only the newest lines of each name are kept."""

KEPT = 2
"""Lines of a name that are kept: the newest may be of a file that a killed program did not put in place."""

ANY = "*"
"""In place of a digest: a file that the program changes in place, such as a run file."""

NO_LINK, NO_WAIT = (getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK"))

_kept: ContextVar[bool | None] = ContextVar("kept", default=None)
"""Whether files of the user are kept; None where nobody has said."""
_read: dict[tuple[int, int], Path] = {}
_written: dict[str, tuple[int, int]] = {}


@contextlib.contextmanager
def keeping(overwrite: bool | None = None) -> Iterator[None]:
    """Context in which files of the user are kept. overwrite: True: in which they may be replaced, as `--overwrite`
    says; None: as the context around it says, where one does."""
    wanted = not overwrite if overwrite is not None else _kept.get() is not False
    before = _kept.set(wanted)
    try:
        yield
    finally:
        _kept.reset(before)


def reads(path: str | os.PathLike[str]) -> None:
    """Note a file of the user that is an input: it is not replaced, even if this program wrote it before."""
    with contextlib.suppress(OSError):
        found = os.stat(path)
        if str(Path(path).resolve()) not in _written:
            _read[(found.st_dev, found.st_ino)] = Path(path)


@contextlib.contextmanager
def looking() -> Iterator[None]:
    """Context in which files are read that are no inputs, such as those that an earlier run left in its folder."""
    before = dict(_read)
    try:
        yield
    finally:
        _read.clear()
        _read.update(before)


def forget_inputs() -> None:
    """Forget what was read: another command begins."""
    _read.clear()


def guard(*paths: str | os.PathLike[str]) -> None:
    """Raise InputError for the first of the paths that may not be replaced; one that does not exist may be written."""
    if not _kept.get():
        return
    for path in map(Path, paths):
        _require_list(path.parent)
        # Resolved: a folder on the way may be missing now, and made before the file is written
        reason = _reason(path.parent.resolve() / path.name)
        if reason:
            raise InputError(f"{path}: {reason};\nchoose another place with -o, or replace it with --overwrite")


def _require_list(folder: Path) -> None:
    """Raise InputError where something else than a file has the name of the list of a folder."""
    with contextlib.suppress(OSError):
        if not stat.S_ISREG(os.lstat(folder / LIST).st_mode):
            raise InputError(f"{folder / LIST}: is not a file of snowmpm; choose another place")


def new_file(path: Path) -> tuple[Path, int]:
    """(path, descriptor) of a new file of that name to be written to, or, where there is one of which nobody knows
    whose it is, of its name with a number. Raises OSError."""
    name, number = path, 0
    while True:
        try:
            return name, os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            number += 1
            name = path.with_name(f"{path.stem}.{number}{path.suffix}")


def guard_in(folder: str | os.PathLike[str], names: Iterable[str]) -> None:
    """`guard` of files of one folder."""
    guard(*(Path(folder) / name for name in names))


def adopt(folder: str | os.PathLike[str], names: Iterable[str]) -> None:
    """`guard_in` of files that an earlier command wrote; where their folder has lost its list, such as in a copy, they
    are listed as they are."""
    folder = Path(folder)
    if (folder / LIST).exists():
        guard_in(folder, names)
        return
    for name in names:
        if (folder / name).is_file():
            note(folder / name)


def note(path: str | os.PathLike[str], content: str | os.PathLike[str] | None = None) -> None:
    """Note that `path` is about to get the content of the file `content`, or was written as it is now.

    Before the file gets its name, so that no kill in between leaves one that is not known. Raises OSError.
    """
    path = Path(path)
    if _kept.get() is None or (ANY, path.name) in _lines(path.parent):
        return
    _append(path, _digest(Path(content or path)))


def note_changing(*paths: str | os.PathLike[str]) -> None:
    """Note files, or folders, that the program changes in place: whatever they hold, they are its own."""
    if _kept.get() is None:
        return
    for path in map(Path, paths):
        _append(path, ANY)


def note_written(path: str | os.PathLike[str]) -> None:
    """Note that `path` is now as this process wrote it."""
    with contextlib.suppress(OSError):
        found = os.stat(path)
        _written[str(Path(path).resolve())] = (found.st_size, found.st_mtime_ns)


def is_own(path: str | os.PathLike[str]) -> bool:
    """Whether a file was written by this program and not changed since."""
    path = Path(path)
    try:
        found = os.stat(path)
    except OSError:
        return False
    if _written.get(str(path.resolve())) == (found.st_size, found.st_mtime_ns):
        return True
    known = [digest for digest, name in _lines(path.parent) if name == path.name]
    if ANY in known:
        return True
    try:
        return bool(known) and path.is_file() and _digest(path) in known
    except OSError:
        return False


def remove_own(folder: str | os.PathLike[str]) -> None:
    """Remove the files of a folder that this program wrote and nobody changed since, and the folder if that is all."""
    folder = Path(folder)
    if folder.is_symlink() or not folder.is_dir():
        return
    with contextlib.suppress(OSError):
        for path in [one for one in folder.iterdir() if is_own(one) and not one.is_dir()]:
            path.unlink()
        if [one.name for one in folder.iterdir()] in ([], [LIST]):
            (folder / LIST).unlink(missing_ok=True)
            folder.rmdir()


def _reason(path: Path) -> str:
    """Why a path may not be replaced, or nothing."""
    try:
        found = os.lstat(path)
    except OSError:
        return ""
    with contextlib.suppress(OSError):
        if _is_read(os.stat(path)):
            return "is read by this command"
    if os.path.islink(path):
        return "is a link, and not of snowmpm"
    if os.path.isfile(path) and found.st_size == 0:
        return ""  # nothing to lose
    return "" if is_own(path) else "was not written by a command of snowmpm, or was changed since"


def _is_read(found: os.stat_result) -> bool:
    """Whether a file is one that was read. The number of a file that is gone may be that of a new one."""
    key = (found.st_dev, found.st_ino)
    if key not in _read:
        return False
    try:
        read = os.stat(_read[key])
    except OSError:
        return False
    return (read.st_dev, read.st_ino) == key


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
    return digest.hexdigest()[:32]


def _lines(folder: Path) -> list[tuple[str, str]]:
    """(digest, name) of what was written to a folder, in order."""
    try:
        # Of a folder from anybody: a pipe of that name would wait for a writer for ever
        descriptor = os.open(folder / LIST, os.O_RDONLY | NO_LINK | NO_WAIT)
        with open(descriptor, encoding="utf-8", errors="replace") as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                return []
            rows = [line.rstrip("\n").partition(" ") for line in file.read(64 * MOST).split("\n")]
    except OSError:
        return []
    return [(digest, name) for digest, _, name in rows if name]


def _append(path: Path, digest: str) -> None:
    """Add a line to the list of the folder of a file."""
    if "\n" in path.name:
        return
    line = f"{digest} {path.name}\n".encode("utf-8", "replace")
    # In one write, so that several programs may do so at once; a link of that name is never followed
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | NO_LINK | NO_WAIT
    descriptor = os.open(path.parent / LIST, flags, 0o666)
    try:
        written = os.write(descriptor, line)
        size = os.fstat(descriptor).st_size
        if written < len(line):  # a full disk takes the beginning: the next line would be a part of this one
            os.ftruncate(descriptor, size - written)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    finally:
        os.close(descriptor)
    if size > MOST:
        _shorten(path.parent)


def _shorten(folder: Path) -> None:
    """Keep the newest lines of each name."""
    kept: list[tuple[str, str]] = []
    count: dict[str, int] = {}
    for digest, name in reversed(_lines(folder)):
        count[name] = count.get(name, 0) + 1
        if count[name] <= KEPT:
            kept.append((digest, name))
    part = folder / f"{LIST}.{os.getpid()}"
    with contextlib.suppress(OSError):
        part.unlink(missing_ok=True)
        with open(part, "x", encoding="utf-8") as file:
            file.writelines(f"{digest} {name}\n" for digest, name in reversed(kept))
        os.replace(part, folder / LIST)
