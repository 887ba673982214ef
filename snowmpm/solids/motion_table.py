"""Prescribed motion from a table of text (CSV): displacement and angle over time."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.reading.number_table import read_number_table

KEY = "motion.file"

SHIFTS = {2: ("x", "z"), 3: ("x", "y", "z")}
TURNS = {2: ("angle",), 3: ("angle_x", "angle_y", "angle_z")}


def read_motion_table(file, base_dir, dim):
    """Times (n,) [s], displacements (n, dim) [m] and turns (n,) or (n, 3) [rad] of a motion table.

    The first line names the columns, each line below is one row, at least two:
        time [s]                            growing from row to row
        x, y, z [m]                         displacement of the centre of rotation from its initial position
        angle [degrees]                     2-D: from +x towards +z
        angle_x, angle_y, angle_z [degrees] 3-D: turn about an axis along this vector, right-handed
    Columns other than the time may be missing, and are then 0; other units in brackets after a name are converted.
    Lines that are empty or begin with # are skipped. InputError: unreadable, an unknown column or unit, not a finite
    number, times that do not grow.
    """
    path = existing(file, base_dir, KEY)
    known = {"time": "s", **dict.fromkeys(SHIFTS[dim], "m"), **dict.fromkeys(TURNS[dim], "degrees")}
    columns, lines = read_number_table(path, known, f" in a {dim}-D scene")
    if "time" not in columns or len(columns) < 2:
        raise InputError(f"{path}: needs a column time and at least one of {', '.join(list(known)[1:])}")
    times = columns["time"]
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if len(back):
        n = lines[back[0] + 1]
        raise InputError(f"{path}: line {n}: time = {times[back[0] + 1]:g}: must be after {times[back[0]]:g}, above it")
    shifts, turns = (
        np.stack([columns.get(name, np.zeros(len(times))) for name in wanted[dim]], axis=1)
        for wanted in (SHIFTS, TURNS)
    )
    return times, shifts, np.radians(turns[:, 0] if dim == 2 else turns)
