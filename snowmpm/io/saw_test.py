"""A propagation saw test in a run file: records along the column, at more times than the frames."""

import json
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np

from snowmpm.annotations import Numbers, PathLike
from snowmpm.glance import ArraysGlance
from snowmpm.io.records import Record, number, numbers, read_record
from snowmpm.io.rows import units_of
from snowmpm.io.vtkhdf import COMPRESSION, append, growing

GROUP = "saw_test"
ABOUT = dict.fromkeys(("slope_angle", "length", "slab_thickness", "weak_layer_thickness", "saw_speed", "saw_start",
                       "saw_length", "notch", "normal_stress", "shear_stress", "shear_wave_speed", "plate_wave_speed"),
                      number) | {"theory": numbers}
"""Numbers of the set-up, and of theories that need nothing measured; older files lack the latter."""


@dataclass(frozen=True, repr=False)
class SawTest(ArraysGlance):
    """values, units: by name; `saw_test[name]` is values[name]. about: set-up, numbers and texts by name. bins: names
    of the values with one entry a bin.

    Rows in time: (k,) time [s], saw, tip [m] ..., and (k, bins) settlement, settling_speed, slip ...; one value a bin:
    x [m], arrival [s] ... (`snowmpm.saw_test.crack`).
    """

    values: dict[str, Numbers]
    units: dict[str, str]
    about: dict[str, Any]
    bins: frozenset[str] = frozenset()

    def __getitem__(self, name: str) -> Numbers:
        return self.values[name]


def create_saw_test(h5, about, series, lines, bins):
    """Group in a new run file. series, lines: {name: unit} of records that grow row by row, with one value or one value
    per bin; bins: {name: (values (n,), unit)}; about: anything JSON can hold."""
    group = h5.create_group(GROUP)
    group.attrs["about"] = json.dumps(about)
    n = len(next(iter(bins.values()))[0])
    for name, unit in series.items():
        growing(group, name, dtype=np.float64).attrs["units"] = unit
    for name, unit in lines.items():
        growing(group, name, dtype=np.float32, columns=n, **COMPRESSION).attrs["units"] = unit
    for name, (values, unit) in bins.items():
        group.create_dataset(name, data=values).attrs["units"] = unit


def append_saw_test(h5, rows, bins):
    """Add rows {name: (k,) or (k, bins)}, and replace the values of the bins {name: (bins,)}."""
    for name, values in rows.items():
        if len(values):  # an empty record has as many columns as there are bins
            append(h5[GROUP][name], values.astype(h5[GROUP][name].dtype))
    for name, values in bins.items():
        h5[GROUP][name][:] = values


def keep_saw_test(h5, limit):
    """Drop the rows later than `limit` [s]."""
    if GROUP not in h5:
        return
    group = h5[GROUP]
    rows = int(np.searchsorted(group["time"][:], limit, side="right"))
    for data in group.values():
        if data.maxshape[0] is None:
            data.resize(rows, axis=0)


def read_saw_test(h5: h5py.File, path: PathLike) -> SawTest | None:
    """`SawTest`, or None if the run is no saw test."""
    if GROUP not in h5:
        return None
    group = h5[GROUP]
    where = f"{path}: saw_test"
    return SawTest(Record({name: data[:] for name, data in group.items()}, where),
                   Record({name: units_of(data) for name, data in group.items()}, where),
                   read_record(group.attrs["about"], where, ABOUT),
                   frozenset(name for name, data in group.items() if data.maxshape[0] is not None))
