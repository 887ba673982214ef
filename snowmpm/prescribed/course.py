"""Gravity over time."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.reading.number_table import read_number_table

GAUSS = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)
"""Points of Gauss's rule on (0, 1): exact for cubics in time, and so for ramps and between the rows of tables."""


class Course:
    """A vector (dim,) over time: `at(time)`, and `mean(start, end)` over a step, whose impulse is then exact.

    strongest (dim,): largest size of each component; until: when it changes for the last time [s].
    """

    def __init__(self, at, strongest, until):
        self.at, self.strongest = at, np.asarray(strongest, float)
        self.until = until

    def mean(self, start, end):
        """Mean over the time from start to end [s]."""
        return 0.5 * sum(self.at(start + share * (end - start)) for share in GAUSS)

    @classmethod
    def of(cls, spec, dim, base_dir):
        """Course of a scene's gravity table (`snowmpm.scenes.gravity.Gravity`); InputError: a wrong file."""
        if spec.file is not None:
            return cls._tabulated(spec, dim, base_dir)
        if spec.ramp is not None:
            full = as_vector(spec.value, dim)

            def grown(time):
                u = min(max((time - spec.start) / spec.ramp, 0.0), 1.0)
                return u * u * (3.0 - 2.0 * u) * full

            return cls(grown, np.abs(full), spec.start + spec.ramp)
        times = np.asarray(spec.times)
        values = np.array([as_vector(value, dim) for value in spec.values or [spec.value] * len(times)])
        tilts = np.radians(spec.tilts or np.zeros(len(times)))

        def tilted(time):
            own = time - spec.start
            g, tilt = np.array([np.interp(own, times, column) for column in values.T]), np.interp(own, times, tilts)
            x, z = g[0], g[-1]
            g[0], g[-1] = x * np.cos(tilt) - z * np.sin(tilt), x * np.sin(tilt) + z * np.cos(tilt)
            return g

        strongest = np.abs(values).max(axis=0)
        if tilts.any():
            strongest[[0, -1]] = np.hypot(values[:, 0], values[:, -1]).max()
        return cls(tilted, strongest, spec.start + times[-1])

    @classmethod
    def _tabulated(cls, spec, dim, base_dir):
        axes = "xz" if dim == 2 else "xyz"
        path = existing(spec.file, base_dir, "gravity.file")
        columns, lines = read_number_table(path, {"time": "s", **dict.fromkeys(axes, "m/s2")})
        if "time" not in columns or len(columns) < 2:
            raise InputError(f"{path}: needs a column time and at least one of {', '.join(axes)}")
        times, full = columns["time"], as_vector(spec.value, dim)
        back = np.flatnonzero(np.diff(times) <= 0.0)
        if len(back):
            raise InputError(f"{path}: line {lines[back[0] + 1]}: time must grow from row to row")
        values = np.stack([columns.get(axis, np.full(len(times), full[a])) for a, axis in enumerate(axes)], axis=1)
        return cls(lambda time: np.array([np.interp(time - spec.start, times, column) for column in values.T]),
                   np.abs(values).max(axis=0), spec.start + times[-1])


def as_vector(value, dim):
    """(dim,) of a vector, or of a number downward."""
    return np.asarray(value, float) if isinstance(value, tuple | list) else np.array([0.0] * (dim - 1) + [-value])
