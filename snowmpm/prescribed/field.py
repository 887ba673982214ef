"""Values as functions of place, velocity and time: numbers, formulas, or a table."""

import math

import numpy as np

from snowmpm.errors import InputError, SimulationError
from snowmpm.prescribed.space_time_table import SpaceTimeTable

PLACES, MOMENTS = 500, 61
"""Places and times at which a formula is tried before a run."""


class Field:
    """One of a scene's tables of forces. numbers: (first, one past last) particle number that it acts on, or None for
    all; until: when it changes for the last time [s]."""

    def __init__(self, spec, dim, base_dir, key, formula_of, numbers=None):
        """formula_of: text -> function of the variables of a formula (`snowmpm.scenes.formula`)."""
        self.spec, self.key, self.dim = spec, key, dim
        self.numbers = numbers
        self._functions = self._table = None
        if spec.file is not None:
            self._table = SpaceTimeTable(spec.file, base_dir, f"{key}.file", dim, self.columns(dim), spec.UNIT)
            lasting = self._table.until
        else:
            values = spec.value if isinstance(spec.value, tuple) else (spec.value,)
            self._functions = [formula_of(value) if isinstance(value, str) else _constant(value) for value in values]
            lasting = math.inf if any("t" in f.names for f in self._functions) else 0.0
        self.until = spec.start + lasting if spec.stop is None else spec.stop

    def share(self, time, dt):
        """Share of a step of dt [s] from `time` [s] in which it acts."""
        stop = math.inf if self.spec.stop is None else self.spec.stop
        return max(0.0, min(time + dt, stop) - max(time, self.spec.start)) / dt

    def refuse_infinite(self, points, end_time):
        """Raise InputError for a formula that gives no finite number at places (n, dim) [m], at rest, within a run."""
        last = end_time if self.spec.stop is None else min(self.spec.stop, end_time)
        if self._functions is None or not len(points) or not last >= self.spec.start:
            return
        points = points[:: max(1, len(points) // PLACES)]
        for time in np.linspace(self.spec.start, last, MOMENTS):
            try:
                self.values(points, np.zeros(points.shape), time)
            except SimulationError as error:
                raise InputError(f"{error}: must be finite as long as it acts") from None

    def values(self, x, v, time):
        """Its values (n, columns) at places x (n, dim) [m] of velocities v (n, dim) [m/s]."""
        if self._table is not None:
            return self._table.at(x, time - self.spec.start)
        with np.errstate(all="ignore"):
            values = np.stack([np.broadcast_to(function(*x.T, *v.T, time), len(x)) for function in self._functions],
                              axis=1)
        if not np.isfinite(values).all():
            place = x[np.argmax(~np.isfinite(values).all(axis=1))]
            raise SimulationError(f"{self.key}.value: no finite number near {np.array2string(place, precision=3)} m at"
                                  f" t = {time:.6g} s")
        return values


def _constant(value):
    def constant(*variables):
        return value

    constant.names = ()
    return constant
