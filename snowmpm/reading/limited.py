"""Whole files that anybody may have put there: regular ones, of at most so many bytes."""

import stat

from snowmpm.errors import InputError


def read_limited(path, most):
    """Bytes of a regular file. Raises InputError for another kind of file, as a pipe, which would wait for a writer for
    ever, and for more than `most` bytes; OSError."""
    if not stat.S_ISREG(path.stat().st_mode):
        raise InputError(f"{path}: not a file")
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise InputError(f"{path}: too large: more than {most >> 20} MiB")
    return content


def read_text_limited(path, most):
    """Text of such a file, in UTF-8. Raises InputError, also for other text; OSError."""
    try:
        return read_limited(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
