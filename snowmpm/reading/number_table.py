"""Tables of numbers in text (CSV), with names of columns in their first line."""

import csv

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget

LONGEST_LINE = 10_000
MEMORY_PER_BYTE = 60
"""Bytes of memory that a byte of text takes while its numbers are read, about: `0,0,0`."""


def read_number_table(path, known, where=""):
    """Columns of a table by name, each (n,), and the line number of each row (n,).

    The first line names the columns, all among `known`; each line below is one row of finite numbers. Units in brackets
    after a name are ignored, and so are lines that are empty or begin with #. where: what messages add to the known
    names. InputError: unreadable, too large, an unknown column or one named twice, a cell that is not a finite number,
    less than two rows.
    """
    try:
        read_budget.allow(path, float(MEMORY_PER_BYTE * path.stat().st_size), "its rows")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    rows = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if len(rows) < 3:
        raise InputError(f"{path}: needs a line of column names and at least two rows of numbers")
    names = _columns(path, *rows[0], known, where)
    table = np.array([_numbers(path, n, line, names) for n, line in rows[1:]])
    return dict(zip(names, table.T, strict=True)), np.array([n for n, _ in rows[1:]])


def _cells(path, n, line):
    if len(line) > LONGEST_LINE:
        raise InputError(f"{path}: line {n}: {len(line)} characters, at most {LONGEST_LINE} allowed")
    return [cell.strip() for cell in next(csv.reader([line]))]


def _columns(path, n, line, known, where):
    try:
        names = [name.partition("[")[0].strip() for name in _cells(path, n, line)]
    except csv.Error as error:
        raise InputError(f"{path}: not a table of text ({error})") from None
    for name in names:
        if name not in known or names.count(name) > 1:
            why = "twice" if name in known else f"must be one of {', '.join(known)}{where}"
            raise InputError(f"{path}: column {ascii(name[:60])[1:-1]}: {why}")
    return names


def _numbers(path, n, line, names):
    try:
        row = [float(cell) for cell in _cells(path, n, line)]
    except (ValueError, csv.Error):
        row = []
    if len(row) != len(names) or not np.isfinite(row).all():
        raise InputError(f"{path}: line {n}: must be {len(names)} finite numbers, {', '.join(names)}")
    return row
