"""Where observed avalanches are: their descriptions with the program, their files fetched once and kept.

`SNOWMPM_EVENTS` names a folder of the user with a folder for each event. Files that are there are taken from it and not
from the network; an event of which it holds event.toml and scene.toml is one more.
"""

import hashlib
import os
import shutil
import sys
import tempfile
from pathlib import Path
from urllib.parse import urlsplit

from snowmpm.errors import InputError, did_you_mean, shown_line
from snowmpm.events.spec import FILE, SCENE, Event, is_web, read_event
from snowmpm.scenes.library import FOLDER as LIBRARY

PREFIX = "event:"
VARIABLE = "SNOWMPM_EVENTS"
FOLDER = LIBRARY / "events"
PIECE = 1 << 20
"""Bytes that are read at a time."""
PATIENCE = 30.0
"""Seconds without an answer after which a server is given up."""


def mirror() -> Path | None:
    """The folder that the user names, None without one. Raises InputError for a name that is no folder."""
    name = os.environ.get(VARIABLE)
    if not name:
        return None
    if not Path(name).is_dir():
        raise InputError(f"{VARIABLE} = {name}: must be a folder")
    return Path(name)


def events() -> dict[str, Path]:
    """Name -> folder of the description, in alphabetical order."""
    folders = [FOLDER, *([own] if (own := mirror()) else [])]
    return {path.parent.name: path.parent for folder in folders for path in sorted(folder.glob(f"*/{FILE}"))}


def event(name: str) -> Event:
    """The event of this name. Raises InputError for an unknown one."""
    return read_event(_folder(name) / FILE)


def kept(name: str) -> Path:
    """Folder in which the files of an event are kept, in the user's cache."""
    return Path(_pooch().os_cache("snowmpm"), "events", name)


def scene_file(name: str, accept: bool = False) -> Path:
    """Scene of an event, in a folder with all its files; those that are missing are fetched.

    accept: the user accepts the licence. Raises InputError for a licence that must be accepted, for a file that cannot
    be fetched or has another checksum, and for one that the user must bring.
    """
    known, source, folder = event(name), _folder(name), kept(name)
    missing = [one for one in known.files if _flaw(folder / one.name, one)]
    if missing and known.accept and not accept:
        raise InputError(f"{PREFIX}{name}: its data are under {known.licence} ({known.terms}), which must be accepted"
                         f" once:\nsnowmpm events get {name} --accept-licence")
    for one in missing:
        _get(name, one, folder)
    for one in known.brought:
        _bring(name, one, folder)
    for one in (*known.files, *known.brought):
        if one.crs:
            _place(folder / Path(one.name).with_suffix(".prj"), _system(one, name).encode())
    for file in (SCENE, FILE):
        _place(folder / file, (source / file).read_bytes())
    return folder / SCENE


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
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while piece := file.read(PIECE):
            digest.update(piece)
    return "" if digest.hexdigest() == source.sha256 else "has another checksum than the registry's"


def _get(name, source, folder):
    """Put a file into the folder, from the user's own or from the network."""
    own = mirror()
    there = own / name / source.name if own else None
    if there and there.is_file():
        if flaw := _flaw(there, source):
            raise InputError(f"{there}: {flaw}")
        _copy(there, folder / source.name)
        return
    print(f"fetching {source.name} ({source.bytes / 1e6:.2g} MB) of {PREFIX}{name}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as where:
        try:
            path = Path(_fetched(source, where))
        except OSError as error:
            raise InputError(f"{PREFIX}{name}: {source.name}: {_why(error, source, name)}") from None
        if flaw := _flaw(path, source):
            raise InputError(f"{PREFIX}{name}: {source.name} as {_host(source)} gave it {flaw}: not kept")
        _copy(path, folder / source.name)


def _fetched(source, where):
    pooch = _pooch()
    pooch.get_logger().setLevel("ERROR")

    def download(url, output, _):
        import requests

        with requests.get(url, stream=True, timeout=PATIENCE) as answer:
            if not is_web(answer.url):
                raise requests.exceptions.InvalidURL("it leads to an address that is not encrypted")
            answer.raise_for_status()
            size = 0
            with open(output, "wb") as file:
                for piece in answer.iter_content(PIECE):
                    file.write(piece)
                    size += len(piece)
                    if size > source.bytes:  # whatever more may come, it is not the file
                        break

    return pooch.retrieve(source.url, None, fname=source.name, path=where, downloader=download)


def _host(source):
    return urlsplit(source.url).hostname


def _why(error, source, name):
    """Why a file was not fetched, and what to do."""
    from requests.exceptions import HTTPError

    if isinstance(error, HTTPError):
        answer = error.response
        return f"{_host(source)} answers {answer.status_code} {shown_line(answer.reason or '', 60)}"
    kind = type(error).__name__
    reason = {"ConnectionError": "no connection", "ConnectTimeout": "no answer", "ReadTimeout": "no answer",
              "SSLError": "no trusted connection", "ChunkedEncodingError": "the connection broke off"}.get(kind, kind)
    return (f"{reason} to {_host(source)}; with a copy of the files, name the folder that holds"
            f" {name}/{source.name} in {VARIABLE}")


def _bring(name, one, folder):
    """Take a file that the user brings from their folder, if it is not kept yet."""
    own = mirror()
    there = own / name / one.name if own else None
    if there and there.is_file():
        _copy(there, folder / one.name)
    elif not (folder / one.name).is_file():
        raise InputError(f"{PREFIX}{name}: needs {one.name}, which you must bring: {one.what}, from {one.source};\n"
                         f"save it as {folder / one.name}")


def _system(source, name):
    from snowmpm.terrain.reference_system import ReferenceSystem

    return ReferenceSystem.named(source.crs, f"{PREFIX}{name}: {source.name}: crs").wkt


def _place(path, content):
    """Write a file of the cache, unless it is there as it is."""
    if path.is_file() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as part:
        part.write(content)
    os.replace(part.name, path)


def _copy(source, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as part, open(source, "rb") as file:
        shutil.copyfileobj(file, part)
    os.replace(part.name, path)
