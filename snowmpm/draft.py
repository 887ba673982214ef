"""Files of results, pictures and tables: each gets its name when it is whole, and is gone when it fails.

What a run cannot do without (checkpoints, `snowmpm.io.archive`) also waits for the disk; these need not.
"""

import contextlib
import csv
import errno
import io
import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

from snowmpm import overwriting

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

LITTLE = 1 << 16
"""Free bytes [B] of a disk that is full to who writes through a buffer."""


@contextlib.contextmanager
def draft(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Path to write to, beside `path` and with its ending; it becomes `path` when the block ends well.

    Folders are made. Raises InputError for a file that is not to be replaced (`snowmpm.overwriting`), and OSError that
    names `path`, and says so when the disk is full, whatever the writer said.
    """
    path = Path(path)
    overwriting.guard(path)
    part, made = path.with_name(f".{path.stem}.unfinished{path.suffix}"), False
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # A file of our own, before a writer opens it by its name: a link of that name would be written through
        part, descriptor = overwriting.new_file(part)
        os.close(descriptor)
        made = True
        yield part
        overwriting.note(path, part)
        os.replace(part, path)
        overwriting.note_written(path)
    except OSError as error:
        ours = error.filename in (None, part, str(part)) or error.errno in FULL
        if not ours:
            raise
        raise OSError(*_reason(error, path), str(path)) from error
    finally:
        if made:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Write a text file (UTF-8); -> its path. Folders are made. Raises OSError when it cannot be written."""
    with draft(path) as part:
        part.write_bytes(text.encode())
    return Path(path)


def write_table(path: str | os.PathLike[str], names: Iterable[str], rows: Iterable[Iterable[object]]) -> Path:
    """Write a heading and rows of values as CSV; -> its path. Errors as of `write_text`."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(rows)
    return write_text(path, text.getvalue())


def _reason(error: OSError, path: Path) -> tuple[int, str]:
    """(number, text) of what kept `path` from being written."""
    if error.errno in FULL or _is_full(path):
        return errno.ENOSPC, os.strerror(errno.ENOSPC)
    if error.errno in (None, errno.EPIPE):  # of an encoder that died, and nobody's pipe out of this program
        lines = str(error).splitlines()
        return errno.EIO, error.strerror or (lines[0] if lines else os.strerror(errno.EIO))
    return error.errno, error.strerror or os.strerror(error.errno)


def _is_full(path: Path) -> bool:
    try:
        usage = shutil.disk_usage(path.parent)
        return usage.total > 0 and usage.free < LITTLE  # what holds no files at all, such as /proc, has no room either
    except OSError:
        return False
