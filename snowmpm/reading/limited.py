"""Whole files that anybody may have put there: regular ones, of at most so many bytes."""

import os
import stat

from snowmpm.errors import InputError

NO_WAIT = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""A pipe would wait for a writer for ever."""


def read_limited(path, most):
    """Bytes of a regular file. Raises InputError for another kind of file and for more than `most` bytes; OSError."""
    descriptor = os.open(path, os.O_RDONLY | NO_WAIT)
    with open(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise InputError(f"{path}: not a file")
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
