"""Prescribed motion from a table of text (CSV): displacement and angle over time."""

import csv

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain.load import existing

KEY = "motion.file"
SHIFTS = {2: ("x", "z"), 3: ("x", "y", "z")}
TURNS = {2: ("angle",), 3: ("angle_x", "angle_y", "angle_z")}


def read_motion_table(file, base_dir, dim):
    """Times (n,) [s], displacements (n, dim) [m] and turns (n,) or (n, 3) [rad] of a motion table.

    The first line names the columns, each line below is one row, at least two:
        time [s]                            growing from row to row
        x, y, z [m]                         displacement of the centre of rotation from where the scene draws it
        angle [degrees]                     2-D: from +x towards +z
        angle_x, angle_y, angle_z [degrees] 3-D: turn about an axis along this vector, right-handed
    Columns other than the time may be left out, and are then 0; units in brackets after a name are ignored. Lines that
    are empty or begin with # are skipped. InputError: unreadable, an unknown column, not a finite number, times that
    do not grow.
    """
    path = existing(file, base_dir, KEY)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    rows = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if len(rows) < 3:
        raise InputError(f"{path}: needs a line of column names and at least two rows of numbers")
    names = _columns(path, rows[0][1], dim)
    table = np.array([_numbers(path, n, line, names) for n, line in rows[1:]])
    columns = dict(zip(names, table.T, strict=True))
    times = columns["time"]
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if len(back):
        n = rows[back[0] + 2][0]
        raise InputError(f"{path}: line {n}: time = {times[back[0] + 1]:g}: must be after {times[back[0]]:g}, above it")
    shifts, turns = (
        np.stack([columns.get(name, np.zeros(len(times))) for name in wanted[dim]], axis=1)
        for wanted in (SHIFTS, TURNS)
    )
    return times, shifts, np.radians(turns[:, 0] if dim == 2 else turns)


def _cells(line):
    return [cell.strip() for cell in next(csv.reader([line]))]


def _columns(path, line, dim):
    names = [name.partition("[")[0].strip() for name in _cells(line)]
    known = ("time", *SHIFTS[dim], *TURNS[dim])
    for name in names:
        if name not in known or names.count(name) > 1:
            why = "twice" if name in known else f"must be one of {', '.join(known)} in a {dim}-D scene"
            raise InputError(f"{path}: column {name}: {why}")
    if "time" not in names or len(names) < 2:
        raise InputError(f"{path}: needs a column time and at least one of {', '.join(known[1:])}")
    return names


def _numbers(path, n, line, names):
    cells = _cells(line)
    try:
        row = [float(cell) for cell in cells]
    except ValueError:
        row = []
    if len(row) != len(names) or not np.isfinite(row).all():
        raise InputError(f"{path}: line {n}: must be {len(names)} finite numbers, {', '.join(names)}")
    return row
