"""JSON records of a run: provenance, hazard, summary. They are checked, since the file may come from anybody.

Keys that are used must have the right type; others may be anything that JSON can hold.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError, shown_line
from snowmpm.io.archive import MEMORY_PER_BYTE
from snowmpm.reading import budget as read_budget

LONGEST = 100
"""Largest number of characters of a name on pictures and pages."""


class Record(dict[str, Any]):
    """A dict that raises InputError, which names the file, for a missing key."""

    file: PathLike

    def __init__(self, values: Mapping[str, Any], file: PathLike) -> None:
        super().__init__(values)
        self.file = file

    def __missing__(self, key: str) -> NoReturn:
        raise InputError(f"{self.file}: has no {key}")


def read_record(text: str | bytes, file: PathLike, kinds: Mapping[str, Callable[[Any], Any]]) -> Record:
    """The `Record` in a JSON text (str or bytes). kinds: {key: function that returns the value or raises ValueError}.

    Raises InputError, which names the file, if it is no table or has a value of another type.
    """
    read_budget.allow(file, float(MEMORY_PER_BYTE * len(text)), "its text")
    try:
        record = json.loads(text)
    except RecursionError:
        raise InputError(f"{file}: nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{file}: not readable as JSON ({shown_line(error, LONGEST)})") from None
    if not isinstance(record, dict):
        raise InputError(f"{file}: must hold a table of names and values")
    for key, kind in kinds.items():
        if record.get(key) is None:
            record.pop(key, None)
            continue
        try:
            record[key] = kind(record[key])
        except ValueError as error:
            raise InputError(f"{file}: {key} = {shown_line(record[key], LONGEST)}: must be {error}") from None
    return Record({key: Record(value, f"{file}: {key}") if isinstance(value, dict) else value
                   for key, value in record.items()}, file)


def number(value):
    """A number. ValueError: not a number, or too large."""
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e300:
        raise ValueError("a number")
    return value


def name(value):
    """A text as it may stand on one line. ValueError: not a text."""
    if not isinstance(value, str):
        raise ValueError("a text")
    return shown_line(value, LONGEST)


def text(value):
    """A text of any length. ValueError: not a text."""
    if not isinstance(value, str):
        raise ValueError("a text")
    return value


def names(value):
    """A list of names. ValueError: not such a list, or too long."""
    if not isinstance(value, list) or len(value) > 1000:
        raise ValueError("a list of names")
    return [name(item) for item in value]


def table(value):
    """A table by names. ValueError: not a table."""
    if not isinstance(value, dict):
        raise ValueError("a table")
    return {name(key): item for key, item in value.items()}


def numbers(value):
    """{name: number}, without nan and infinity, which JSON lacks."""
    return {key: number(item) for key, item in table(value).items() if item is not None}


def measured(value):
    """{name: number, truth value or None, or a table of these}, and under "reasons" {name: text}"""
    return {key: texts(item) if key == "reasons" else measured(item) if isinstance(item, dict)
            else item if item is None or isinstance(item, bool) else number(item) for key, item in table(value).items()}


def texts(value):
    """{name: text}"""
    return {key: name(item) for key, item in table(value).items()}


def profile(value):
    """{name: list of as many numbers as the others have}"""
    columns = table(value)
    if any(not isinstance(column, list) for column in columns.values()) or len(set(map(len, columns.values()))) > 1:
        raise ValueError("columns of one length")
    return {key: [number(item) for item in column] for key, column in columns.items()}


def line(value):
    """[[x, y], [x, y]]"""
    if not isinstance(value, list) or [len(point) if isinstance(point, list) else 0 for point in value] != [2, 2]:
        raise ValueError("two points [x, y]")
    return [[number(x) for x in point] for point in value]


def rings(value):
    """[[ring, hole, ...], ...], each ring a list of four points [x, y] or more. ValueError: not such a list."""
    if not isinstance(value, list) or not all(isinstance(part, list) and part for part in value):
        raise ValueError("polygons of rings")
    for ring in (ring for part in value for ring in part):
        if not isinstance(ring, list) or len(ring) < 4 or not all(isinstance(p, list) and len(p) == 2 for p in ring):
            raise ValueError("polygons of rings")
        if ring[0] != ring[-1]:
            raise ValueError("polygons of closed rings")
    return [[[[number(x) for x in point] for point in ring] for ring in part] for part in value]


def classes(value):
    """{map: [{"class": name, "from": number, "to": number or None, "area": number}]}"""
    found = {}
    for key, rows in table(value).items():
        if not isinstance(rows, list) or not all(isinstance(row, dict) and row.keys() >= CLASS.keys() for row in rows):
            raise ValueError("areas by class")
        found[key] = [{entry: kind(row[entry]) for entry, kind in CLASS.items()} for row in rows]
    return found


def methods(value):
    """[{"method": name, "time": number, "particle_spacing": number}]"""
    if not isinstance(value, list) or not all(isinstance(row, dict) and row.keys() >= METHOD.keys() for row in value):
        raise ValueError("a list of methods")
    return [{**row, **{entry: kind(row[entry]) for entry, kind in METHOD.items()}} for row in value]


METHOD = {"method": name, "time": number, "dx": number, "particle_spacing": number, "particles": number}
CLASS = {"class": name, "from": number, "to": lambda value: None if value is None else number(value), "area": number}
PROVENANCE = {"scene": text, "scene_name": name, "version": name, "materials": names, "bodies": names, "dx": number,
              "particle_spacing": number, "crs": text, "device": name, "backend": name, "precision": name,
              "wall_time": number, "end_time": number, "end_state": numbers, "methods": methods}
HAZARD = {"numbers": numbers, "profile": profile, "runout_line": line, "classes": classes, "release": rings}
SUMMARY = {"scene": name, "wall_time": number, "wall_time_of": numbers, "processor_time": number, "time": number,
           "particles": number, "steps": number, "sorts": number, "frames": number, "writing_time": number,
           "particle_steps": number, "ns_per_particle_step": number, "smallest_dt": number, "dt_causes": numbers,
           "last": numbers, "saw_test": measured, "hazard": table, "backend": name, "precision": name}
