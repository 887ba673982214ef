"""Values on a grid in space and time, from a table of text, linear between the grid's points."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.reading.number_table import read_number_table


class SpaceTimeTable:
    """Values of (time, position): `at(points (n, dim) [m], time [s])` -> (n, columns), beyond the grid those at its
    ends.

    until: the last time in it [s].
    """

    def __init__(self, file, base_dir, key, dim, names, unit):
        """names: of the columns of values, in this unit; those missing are 0. InputError: a wrong file, or no full
        grid."""
        axes = "xz" if dim == 2 else "xyz"
        path = existing(file, base_dir, key)
        columns, _ = read_number_table(path, {"time": "s", **dict.fromkeys(axes, "m"), **dict.fromkeys(names, unit)},
                                       f" in a {dim}-D scene")
        self._along = [name for name in ("time", *axes) if name in columns]
        self._column_of = {axis: a for a, axis in enumerate(axes)}
        if not self._along or not set(columns) & set(names):
            raise InputError(f"{path}: needs at least one of time, {', '.join(axes)}, and one of {', '.join(names)}")
        levels, indices = zip(*(np.unique(columns[name], return_inverse=True) for name in self._along), strict=True)
        shape, count = tuple(map(len, levels)), len(columns[self._along[0]])
        if count != np.prod(shape, dtype=float) or len(np.unique(np.ravel_multi_index(indices, shape))) != count:
            raise InputError(f"{path}: its {count} rows must be a full grid, each"
                             f" {' x '.join(self._along)} once: {' x '.join(map(str, shape))}")
        values = np.zeros((*shape, len(names)))
        for c, name in enumerate(names):
            if name in columns:
                values[(*indices, c)] = columns[name]
        self._levels, self._values = levels, values
        self.until = float(levels[0][-1]) if self._along[0] == "time" else 0.0

    def at(self, points, time):
        """Values (n, columns) at points (n, dim) [m] and one time [s]."""
        values = self._values
        levels, along = list(self._levels), list(self._along)
        if along[0] == "time":
            # First in time, for all points at once: what is left depends on places alone
            i, share = _place(levels[0], np.asarray([time]))
            values = values[i[0]] + share[0] * (values[min(i[0] + 1, len(levels[0]) - 1)] - values[i[0]])
            levels, along = levels[1:], along[1:]
        if not along:
            return np.broadcast_to(values, (len(points), values.shape[-1]))
        corners = [_place(level, points[:, self._column_of[name]]) for level, name in zip(levels, along, strict=True)]
        total = np.zeros((len(points), values.shape[-1]))
        for code in range(2 ** len(corners)):
            weight, index = np.ones(len(points)), []
            for a, (i, share) in enumerate(corners):
                upper = code >> a & 1
                weight = weight * (share if upper else 1.0 - share)
                index.append(np.minimum(i + upper, len(levels[a]) - 1))
            total += weight[:, None] * values[tuple(index)]
        return total


def _place(level, values):
    """Index of the level below each value, and how far it is on the way to the next, 0 to 1."""
    i = np.clip(np.searchsorted(level, values, side="right") - 1, 0, max(len(level) - 2, 0))
    width = level[np.minimum(i + 1, len(level) - 1)] - level[i]
    return i, np.clip((values - level[i]) / np.where(width > 0.0, width, 1.0), 0.0, 1.0)
