"""Files that are whole or absent: archives of numbers and arrays (the format of checkpoints), and any other file.

An archive is an uncompressed .npz file: `record`, JSON text (UTF-8) of the tree, in which an array is
{"array": member}; the arrays; and `digest`, the SHA-256 of all of them. NumPy opens it; nothing in it is ever
unpickled.
"""

import contextlib
import hashlib
import json
import os
import zipfile
from pathlib import Path

import numpy as np

from snowmpm import memory, overwriting
from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget

MEMORY_PER_BYTE = 40
"""Approximate largest memory per byte of JSON text once it is read: `[[],[],...`."""

_RECORD, _DIGEST = "record", "digest"


def write_archive(path, tree, keep=None):
    """Write a tree (dicts, lists, text, numbers, NumPy arrays) to `path`; an existing file moves to `keep` if given.

    At any moment `path`, or else `keep`, is whole, also through a power cut. Raises OSError, with the old files in
    place, when it cannot be written.
    """
    path = Path(path)
    arrays = {}
    record = json.dumps(_plain(tree, arrays, ""))
    arrays[_RECORD] = np.frombuffer(record.encode(), np.uint8)
    arrays[_DIGEST] = _digest(arrays)
    with _replacement(path, keep) as file:
        np.savez(file, **arrays)


def write_bytes(path, content):
    """Write a file that is whole or the one before. Raises OSError when it cannot be written."""
    with _replacement(Path(path)) as file:
        file.write(content)


def write_text(path, text):
    """Write a text file (UTF-8) that is whole or the one before. Raises OSError when it cannot be written."""
    write_bytes(path, text.encode())


@contextlib.contextmanager
def _replacement(path, keep=None):
    """Context: a file that replaces `path` once all is written; the old one moves to `keep` if given."""
    overwriting.guard(path, *([keep] if keep else []))
    part = part_of(path)
    try:
        with create_new(part) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        overwriting.note(path, part)
        if keep is not None and path.exists():
            overwriting.note(keep, path)
            os.replace(path, keep)
        os.replace(part, path)
        overwriting.note_written(path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise
    sync_folder(path.parent)


def part_of(path):
    """Path of a file that is written in place of `path`."""
    return Path(path).with_name(Path(path).name + ".part")


def create_new(path):
    """A new file to write to, in place of anything of that name; a link of that name is never followed."""
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb")


def read_archive(path):
    """The tree that `write_archive` wrote. Raises InputError when the file is missing, damaged or of another kind."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        arrays = _read_members(path)
        digest = arrays.pop(_DIGEST)
        if not np.array_equal(digest, _digest(arrays)):
            raise ValueError("its checksum is wrong")
        tree = _whole(json.loads(arrays[_RECORD].tobytes()), arrays)
        if not isinstance(tree, dict):
            raise ValueError("it holds no table")
        return tree
    except InputError:
        raise
    except Exception as error:  # truncated and foreign files raise many kinds of errors in zipfile, NumPy and JSON
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{path}: damaged, or not written by this program ({reason})") from error


def _read_members(path):
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        # Stored, not deflated, and no larger than the file: a small file cannot ask for much memory.
        members = archive.infolist()
        if sum(member.file_size for member in members) > path.stat().st_size:
            raise ValueError("its sizes are wrong")
        memory.require(2.0 * path.stat().st_size, str(path), "nothing less than all of it is read")
        text = sum(member.file_size for member in members if member.filename == f"{_RECORD}.npy")
        read_budget.allow(path, float(MEMORY_PER_BYTE * text), "its record")
        for member in members:
            with archive.open(member) as file:
                arrays[member.filename.removesuffix(".npy")] = np.lib.format.read_array(file, allow_pickle=False)
    return arrays


def _plain(value, arrays, path):
    """The value as JSON can hold it; its arrays are stored separately under their paths."""
    if isinstance(value, np.ndarray):
        arrays[path] = np.ascontiguousarray(value)
        return {"array": path}
    if isinstance(value, dict):
        return {key: _plain(item, arrays, f"{path}/{key}".lstrip("/")) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, arrays, f"{path}/{i}") for i, item in enumerate(value)]
    return value.item() if isinstance(value, np.generic) else value


def _whole(value, arrays):
    if isinstance(value, dict):
        if value.keys() == {"array"}:
            return arrays[value["array"]]
        return {key: _whole(item, arrays) for key, item in value.items()}
    return [_whole(item, arrays) for item in value] if isinstance(value, list) else value


def _digest(arrays):
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"{name} {array.dtype.str} {array.shape};".encode())
        digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8))
    return np.frombuffer(digest.digest(), np.uint8)


def sync_folder(folder):
    """Wait until the new names are on the disk, where the system can tell."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
