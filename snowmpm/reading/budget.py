"""How much memory reading a file may take: asked of its header, before anything of it is read.

A file of some kilobytes can declare terabytes: sparse or compressed pixels, tables, arrays. What reads a file adds up
from its header what it is about to take and asks `allow` first.
"""

import math
import os

from snowmpm import memory
from snowmpm.errors import InputError

GIBIBYTES = 4.0
"""What one file may take, unless the environment variable VARIABLE says otherwise."""

VARIABLE = "SNOWMPM_READ_GIB"


def budget():
    """Bytes that reading one file may take: GIBIBYTES or VARIABLE. InputError where that is no number above 0."""
    text = os.environ.get(VARIABLE)
    try:
        size = GIBIBYTES if text is None else float(text)
    except ValueError:
        size = math.nan
    if not size > 0:
        raise InputError.at(f"environment variable {VARIABLE}", text, "must be a number of GiB above 0")
    return size * 2.0**30


def allow(file, size, what, remedy=""):
    """Refuse a file that takes too much memory to read, before it is read.

    file: path or text that names it, as `terrain.file = "dem.tif"` does; size: bytes that will be taken, compressed
    data unpacked and working copies counted (a float, so that products of declared numbers cannot overflow); what: that
    needs them, as "100000 x 100000 cells"; remedy: what makes it smaller. Raises InputError where `size` is more than
    the budget or than the memory that is free, or no number at all.
    """
    limit = budget()
    if not 0 <= size <= limit:
        raise InputError(f"{file}: {what} need{_gibibytes(size)} of memory, and {memory.gibibytes(limit)} are allowed "
                         f"for a file ({VARIABLE} sets it){_clause(remedy)}")
    free = memory.available()
    if size > free:
        raise InputError(f"{file}: {what} need{_gibibytes(size)} of memory, and {memory.gibibytes(free)} are free"
                         f"{_clause(remedy)}")


def _gibibytes(size):
    return f" {memory.gibibytes(size)}" if math.isfinite(size) and size >= 0 else " more than there is"


def _clause(remedy):
    return f"; {remedy}" if remedy else ""
