"""What components recorded over time, finer than the frames: tables in a run file."""

import json
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np

from snowmpm.annotations import Numbers, PathLike
from snowmpm.errors import InputError
from snowmpm.glance import ArraysGlance
from snowmpm.io.records import Record, read_record
from snowmpm.io.rows import units_of
from snowmpm.io.vtkhdf import COMPRESSION, append

GROUP = "series"
MOST_AXES = 4
ROWS = 64
"""Of a chunk."""


@dataclass(frozen=True, repr=False)
class Series(ArraysGlance):
    """time (k,) [s] and columns {name: (k, ...)} with their units; about: what the record is of, by name.

    The rows end at the times; values are means since the row before, where the component does not say otherwise.
    """

    about: Record
    time: Numbers
    columns: dict[str, Numbers]
    units: dict[str, str]


def append_series(h5, series):
    """Add rows {kind: {name: (about, {column: (values (k, ...), unit)})}}; the first ones make the tables."""
    for kind, records in series.items():
        for name, (about, columns) in records.items():
            group = h5.require_group(GROUP).require_group(kind).require_group(name)
            group.attrs["about"] = json.dumps(about)
            for column, (values, unit) in columns.items():
                if column not in group:
                    rest = values.shape[1:]
                    group.create_dataset(column, (0, *rest), values.dtype, maxshape=(None, *rest), chunks=(ROWS, *rest),
                                         **COMPRESSION).attrs["units"] = unit
                if len(values):
                    append(group[column], values)


def keep_series(h5, limit):
    """Drop the rows later than `limit` [s]."""
    for group in _groups(h5):
        rows = int(np.searchsorted(group["time"][:], limit, side="right"))
        for data in group.values():
            data.resize(rows, axis=0)


def check_series(h5, path):
    """Raise InputError for tables that do not fit each other, of a file that may come from anybody."""
    if GROUP in h5 and not isinstance(h5[GROUP], h5py.Group):
        raise InputError(f"{path}: {GROUP} is not a group of records")
    for group in _groups(h5):
        if "time" not in group or not isinstance(group.attrs.get("about"), str):
            raise InputError(f"{path}: {group.name} is not what a component records")
        for data in group.values():
            if not isinstance(data, h5py.Dataset) or not 1 <= data.ndim <= MOST_AXES or len(data) != len(group["time"]):
                raise InputError(f"{path}: {data.name} does not fit its times")
        time = group["time"]
        if time.ndim != 1 or not np.isfinite(time[:]).all() or (np.diff(time[:], prepend=0.0) <= 0.0).any():
            raise InputError(f"{path}: {group.name}/time is not a row of times that rise from above 0")


def read_series(h5: h5py.File, path: PathLike) -> dict[str, dict[str, Series]]:
    """`Series` by kind and name."""
    found: dict[str, dict[str, Series]] = {}
    for group in _groups(h5):
        kind, name = group.name.split("/")[-2:]
        about = read_record(group.attrs["about"], f"{path}: {group.name}", {})
        columns = {column: data[:] for column, data in group.items() if column != "time"}
        units = {column: units_of(data) for column, data in group.items()}
        found.setdefault(kind, {})[name] = Series(about, group["time"][:], columns, units)
    return found


def _groups(h5: h5py.File) -> list[Any]:
    """Groups of the records. Raises nothing: what is no group is left out."""
    root = h5.get(GROUP, {})
    parts = [part for part in root.values() if isinstance(part, h5py.Group)]
    return [group for part in parts for group in part.values() if isinstance(group, h5py.Group)]
