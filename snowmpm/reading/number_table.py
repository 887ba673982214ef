"""Tables of numbers in text (CSV), with names of columns in their first line."""

import csv

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget

UNITS = {
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "m": {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "ft": 0.3048},
    "degrees": {"degrees": 1.0, "rad": 180.0 / np.pi, "mrad": 0.18 / np.pi},
    "m/s2": {"m/s2": 1.0, "cm/s2": 1e-2, "mm/s2": 1e-3, "g": 9.80665},
    "Pa": {"Pa": 1.0, "hPa": 100.0, "kPa": 1e3, "MPa": 1e6, "mbar": 100.0, "bar": 1e5},
}
"""Factors to each unit from those that a table may name in brackets."""

SPELLINGS = {"sec": "s", "seconds": "s", "deg": "degrees", "degree": "degrees", "radians": "rad", "m/s/s": "m/s2",
             "ms-2": "m/s2", "m*s-2": "m/s2", "gal": "cm/s2", "Gal": "cm/s2", "meters": "m", "metres": "m"}
"""Other ways to write them."""

LONGEST_LINE = 10_000
MEMORY_PER_BYTE = 60
"""Bytes of memory that a byte of text takes while its numbers are read, about: `0,0,0`."""


def read_number_table(path, known, where=""):
    """Columns of a table by name, each (n,), and the line number of each row (n,).

    known: {name: its unit}, a key of UNITS. The first line names the columns; each line below is one row of finite
    numbers. A unit in brackets after a name, `x [mm]`, is converted. Lines that are empty or begin with # are skipped.
    where: what messages add to the known names. InputError: unreadable, too large, an unknown column or one named
    twice, a unit of another quantity, a cell that is not a finite number, less than two rows.
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
    names, factors = _columns(path, *rows[0], known, where)
    table = np.array([_numbers(path, n, line, names) for n, line in rows[1:]]) * factors
    return dict(zip(names, table.T, strict=True)), np.array([n for n, _ in rows[1:]])


def _cells(path, n, line):
    if len(line) > LONGEST_LINE:
        raise InputError(f"{path}: line {n}: {len(line)} characters, at most {LONGEST_LINE} allowed")
    return [cell.strip() for cell in next(csv.reader([line]))]


def _columns(path, n, line, known, where):
    try:
        cells = [name.partition("[") for name in _cells(path, n, line)]
    except csv.Error as error:
        raise InputError(f"{path}: not a table of text ({error})") from None
    names, factors = [name.strip() for name, _, _ in cells], []
    names = [name.lower() if name not in known and name.lower() in known else name for name in names]
    for name in names:
        if name not in known or names.count(name) > 1:
            why = "twice" if name in known else f"must be one of {', '.join(known)}{where}"
            raise InputError(f"{path}: column {ascii(name[:60])[1:-1]}: {why}{_semicolons(line)}")
    for name, (_, bracket, rest) in zip(names, cells, strict=True):
        written, closed, after = rest.partition("]")
        if bracket and (not closed or after.strip()):
            raise InputError(f"{path}: column {name}: {ascii(bracket + rest)[1:-1][:60]}: must be a unit in brackets,"
                             " and no more")
        factor = _factor(written, known[name]) if bracket else 1.0
        if factor is None:
            written = ascii(rest.partition("]")[0][:40])
            raise InputError(f"{path}: column {name}: unit {written}: must be {' or '.join(_units(known[name]))}")
        factors.append(factor)
    return names, np.array(factors)


def _factor(written, unit):
    """What a number in a unit as written is multiplied with to be in `unit`; None for a unit of another quantity."""
    plain = written.strip().replace("\N{DEGREE SIGN}", "degrees").replace("²", "2").replace("^", "").replace(" ", "")
    return _units(unit).get(SPELLINGS.get(plain, plain))


def _units(unit):
    """Factors to a unit by the names of units; of one that is not in UNITS, itself."""
    return UNITS.get(unit, {unit: 1.0})


def _numbers(path, n, line, names):
    try:
        row = [float(cell.replace("_", "?")) for cell in _cells(path, n, line)]  # Python takes _ for a mark in numbers
    except (ValueError, csv.Error):
        row = []
    if len(row) != len(names) or not np.isfinite(row).all():
        found = ascii(line.strip()[:40])
        raise InputError(f"{path}: line {n}: {found}: must be {len(names)} finite numbers, for {', '.join(names)}"
                         f"{_semicolons(line)}")
    return row


def _semicolons(line):
    """Advice for tables as programs write them where the comma is the decimal mark."""
    return "; save the table with commas between numbers, and with decimal points" if ";" in line else ""
