"""Where observed avalanches are: their descriptions with the program, their files fetched once and kept.

`SNOWMPM_EVENTS` names a folder of the user with a folder for each event. Files that are there are taken from it and not
from the network; an event of which it holds event.toml and scene.toml is one more. What is in it may come from anybody:
links are not followed, and nothing is read that is no plain file of a bounded size.
"""

import contextlib
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urljoin, urlsplit

from snowmpm.errors import InputError, did_you_mean, shown_line
from snowmpm.events.spec import FILE, MOST_BYTES, SCENE, Event, is_loopback, is_web, read_event
from snowmpm.scenes.library import FOLDER as LIBRARY
from snowmpm.scenes.toml import MAX_BYTES

PREFIX = "event:"
VARIABLE = "SNOWMPM_EVENTS"
FOLDER = LIBRARY / "events"
NAME = re.compile("[A-Za-z0-9][A-Za-z0-9_-]{0,60}")
PIECE = 1 << 20
"""Bytes that are read at a time."""
PATIENCE = 30.0
"""Seconds without an answer after which a server is given up."""
SLOWEST = 1e4
"""Bytes a second [1/s] that a server must send on average, beside PATIENCE."""
HOPS = 5
"""Times that a server may send on to another address."""


def mirror() -> Path | None:
    """The folder that the user names, None without one. Raises InputError for a name that is no folder."""
    name = os.environ.get(VARIABLE)
    if not name:
        return None
    if not Path(name).is_dir():
        raise InputError(f"{VARIABLE} = {name}: must be a folder")
    return Path(name)


def events() -> dict[str, Path]:
    """Name -> folder of the description, in alphabetical order. Names are letters, digits, _ and -; others are no
    events. Raises InputError for a folder of the user with another event of the name of one of the program."""
    found = {path.parent.name: path.parent for path in sorted(FOLDER.glob(f"*/{FILE}"))}
    folder = mirror()
    for path in sorted(folder.glob(f"*/{FILE}")) if folder else ():
        name = path.parent.name
        if not NAME.fullmatch(name) or path.parent.is_symlink():
            continue
        if name in found:
            if plain(path, MAX_BYTES).read_bytes() != (found[name] / FILE).read_bytes():
                raise InputError(f"{path}: another event of this name comes with the program: rename the folder")
            continue
        found[name] = path.parent
    return dict(sorted(found.items()))


def event(name: str) -> Event:
    """The event of this name. Raises InputError for an unknown one."""
    return read_event(plain(_folder(name) / FILE, MAX_BYTES))


def plain(path: Path, most: int) -> Path:
    """A path that is a plain file of at most so many bytes. Raises InputError for another: a link, a pipe, a device."""
    try:
        found = os.lstat(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: must be a file, no link")
    if found.st_size > most:
        raise InputError(f"{path}: has {found.st_size} bytes: at most {most}")
    return path


def kept(name: str) -> Path:
    """Folder in which the files of an event are kept: in the user's cache, or that of the user's own event, if none of
    its files is fetched."""
    folder = _folder(name)
    if folder.parent != FOLDER and not event(name).files:
        return folder
    return Path(_pooch().os_cache("snowmpm"), "events", name)


def scene_file(name: str, accept: bool = False, quiet: bool = False) -> Path:
    """Scene of an event, in a folder with all its files; those that are missing are fetched.

    accept: the user accepts the licence; quiet: nothing is said. Raises InputError for a licence that must be accepted,
    for a file that cannot be fetched or has another checksum, and for one that the user must bring.
    """
    known, source, folder = event(name), _folder(name), kept(name)
    plain(source / SCENE, MAX_BYTES)
    for one in known.brought:
        _bring(name, one, folder)
    if folder == source:
        return folder / SCENE
    missing = [one for one in known.files if _flaw(folder / one.name, one)]
    if missing and known.accept and not accept:
        raise InputError(f"{PREFIX}{name}: its data are under {known.licence} ({known.terms}), which must be accepted"
                         f" once:\nsnowmpm events get {name} --accept-licence")
    for one in missing:
        _get(name, one, folder, quiet)
    for one in (*known.files, *known.brought):
        beside = folder / Path(one.name).with_suffix(".prj")
        if one.crs and not beside.exists():
            with _placed(beside) as part:
                part.write(_system(one, name).encode())
    content = (source / SCENE).read_bytes()
    if not (folder / SCENE).is_file() or (folder / SCENE).read_bytes() != content:
        with _placed(folder / SCENE) as part:
            part.write(content)
    return folder / SCENE


def outline_file(name: str) -> Path:
    """File of the outline of an event, which is fetched. Raises InputError for an event without one."""
    seen = event(name).observed.outline
    if seen is None:
        raise InputError(f"{PREFIX}{name}: no outline was observed")
    return scene_file(name).parent / seen.file


def is_here(name: str) -> bool:
    """Whether all files of an event are kept; their size is looked at, not their content."""
    known, folder = event(name), kept(name)
    sizes = {one.name: one.bytes for one in known.files}
    return all((folder / one.name).is_file() and sizes.get(one.name) in (None, (folder / one.name).stat().st_size)
               for one in (*known.files, *known.brought))


def _folder(name):
    found = events()
    if name not in found:
        raise InputError(f"no event {shown_line(name, 100)!r}, only {', '.join(found)}{did_you_mean(name, found)}")
    return found[name]


def _pooch():
    try:
        import pooch
    except ImportError:
        raise InputError("events need the gis extra: pip install 'snowmpm[gis]'") from None
    return pooch


def _flaw(path, source):
    """Why a file is not that of the registry; "" where it is."""
    if not path.is_file():
        return "there is no such file"
    size = path.stat().st_size
    if size != source.bytes:
        return f"has {size} bytes of {source.bytes}: it is not whole" if size < source.bytes else f"has {size} bytes" \
               f" and not {source.bytes}"
    return "" if _digest(path) == source.sha256 else "has another checksum than the registry's"


def _digest(path):
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
    return digest.hexdigest()


def _get(name, source, folder, quiet):
    """Put a file into the folder, from the user's own or from the network."""
    own = mirror()
    there = own / name / source.name if own else None
    if there and os.path.lexists(there):
        if flaw := _flaw(plain(there, MOST_BYTES), source):
            raise InputError(f"{there}: {flaw}")
        _copy(there, folder / source.name)
        return
    if not quiet:
        print(f"fetching {source.name} ({source.bytes / 1e6:.2g} MB) of {PREFIX}{name}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as where:
        try:
            path = Path(_fetched(source, where))
        except (OSError, ValueError) as error:
            raise InputError(f"{PREFIX}{name}: {source.name}: {_why(error, source, name)}") from None
        if flaw := _flaw(path, source):
            raise InputError(f"{PREFIX}{name}: {source.name} as {_host(source)} gave it {flaw}: not kept")
        _copy(path, folder / source.name)


def _fetched(source, where):
    pooch = _pooch()
    pooch.get_logger().setLevel("ERROR")

    def download(url, output, _):
        latest = time.monotonic() + PATIENCE + source.bytes / SLOWEST
        with _answer(url) as answer, open(output, "wb") as file:
            size = 0
            # As it is sent: what unpacks itself has no bound
            while size <= source.bytes and (piece := _piece(answer)):
                file.write(piece)
                size += len(piece)
                if time.monotonic() > latest:
                    raise TimeoutError

    return pooch.retrieve(source.url, None, fname=source.name, path=where, downloader=download)


def _piece(answer):
    """The next bytes of an answer, as they are sent."""
    try:
        return answer.raw.read(PIECE // 16, decode_content=False)
    except OSError:
        raise
    except Exception as error:  # of urllib3, which has kinds of its own
        raise ConnectionResetError(f"the connection broke off: {error}") from None


def _answer(url):
    """Answer of a server, whose body is not read yet. Where it sends on, each address is looked at first, and no name
    or password of the user is sent."""
    import requests

    local = is_loopback(url)
    with requests.Session() as session:
        for _ in range(HOPS):
            answer = session.get(url, stream=True, timeout=PATIENCE, allow_redirects=False,
                                 auth=lambda request: request, headers={"Accept-Encoding": "identity"})
            if not answer.is_redirect:
                answer.raise_for_status()
                return answer
            url = urljoin(url, answer.headers["Location"])
            answer.close()
            if not is_web(url) or (is_loopback(url) and not local):
                raise requests.exceptions.InvalidURL("it leads to an address that files may not come from")
    raise requests.exceptions.TooManyRedirects(f"it leads on more than {HOPS} times")


def _host(source):
    return urlsplit(source.url).hostname


def _why(error, source, name):
    """Why a file was not fetched, and what to do."""
    from requests.exceptions import HTTPError, InvalidURL, TooManyRedirects

    if isinstance(error, HTTPError):
        answer = error.response
        return f"{_host(source)} answers {answer.status_code} {shown_line(answer.reason or '', 60)}"
    if isinstance(error, InvalidURL | TooManyRedirects | ValueError):
        return f"{_host(source)}: {shown_line(str(error), 200)}"
    kind = type(error).__name__
    reason = {"ConnectionError": "no connection", "ConnectTimeout": "no answer", "ReadTimeout": "no answer",
              "TimeoutError": "too slow a connection", "SSLError": "no trusted connection",
              "ConnectionResetError": "the connection broke off"}.get(kind, shown_line(str(error), 100) or kind)
    return (f"{reason} to {_host(source)}; with a copy of the files, name the folder that holds"
            f" {name}/{source.name} in {VARIABLE}")


def _bring(name, one, folder):
    """Take a file that the user brings from their folder, if it is not kept yet. Raises InputError where it is not that
    of the description."""
    own, here = mirror(), folder / one.name
    there = own / name / one.name if own else None
    if there and there != here and os.path.lexists(there):
        _copy(plain(there, MOST_BYTES), here)
    elif not os.path.lexists(here):
        raise InputError(f"{PREFIX}{name}: needs {one.name}, which you must bring: {one.what}, from {one.source};\n"
                         f"save it as {here}")
    if one.sha256 and _digest(plain(here, MOST_BYTES)) != one.sha256:
        raise InputError(f"{here}: has another checksum than that of event.toml")


def _system(source, name):
    from snowmpm.terrain.reference_system import ReferenceSystem

    return ReferenceSystem.named(source.crs, f"{PREFIX}{name}: {source.name}: crs").wkt


@contextlib.contextmanager
def _placed(path: Path) -> Iterator[Any]:
    """A file of the cache, whole or not at all. Raises InputError where it cannot be written."""
    part = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as part:
            yield part
        os.replace(part.name, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}; XDG_CACHE_HOME names another place") from None
    finally:
        if part is not None:
            with contextlib.suppress(OSError):
                os.unlink(part.name)


def _copy(source, path):
    with _placed(path) as part, open(source, "rb") as file:
        shutil.copyfileobj(file, part)
