"""Loads of snow on obstacles: force, moment and work over time from accumulated totals."""

import numpy as np

ROWS = 256
"""Least number of rows of the fine record between two frames, if there are as many steps; at most twice as many."""


class LoadHistory:
    """Loads of obstacles over time, from the impulse that a solver sums up.

    With J(t) the accumulated impulse, the mean force between two rows of the record is exact whatever their distance:

        F = (J(t_i) - J(t_i-1)) / (t_i - t_i-1)

    so rows may be left out. At first there is one row a step. When there are too many rows since the last frame, every
    other row is dropped, and from then on only every second step makes one.

    Totals, (n, dim + 1 or 3 + 1): impulse [N s] given by the snow, its moment about the centre of rotation [N m s] (1
    number in 2-D, 3 in 3-D), work done by the snow [J].
    """

    def __init__(self, names, dim, rows=ROWS):
        self.names, self.dim, self._rows_wanted = list(names), dim, rows
        self._parts = np.split(np.arange(dim + (1 if dim == 2 else 3) + 1), [dim, -1])
        zero = np.zeros((len(self.names), len(np.concatenate(self._parts))))
        self._stride, self._skipped = 1, 0
        self._written = (0.0, zero)  # time and totals of the last row taken
        self._now = (0.0, zero)
        self._times, self._totals = [], []
        self._mean = zero

    def watch(self, time, totals):
        """Record the totals after a step that ended at `time` [s]."""
        self._now = (float(time), np.array(totals, float))
        self._skipped += 1
        if self._skipped >= self._stride:
            self._append()
        if len(self._times) >= 2 * self._rows_wanted:
            self._times, self._totals = self._times[1::2], self._totals[1::2]
            self._stride *= 2

    def _append(self):
        self._skipped = 0
        self._times.append(self._now[0])
        self._totals.append(self._now[1])

    def take(self):
        """Rows since the last call, the last of them for now, and start anew.

        -> {name: {"time" (k,), "force" (k, dim), "moment" (k,) or (k, 3), "impulse" (k, dim), "work" (k,)}}, force and
        moment being means since the row before; no entry when no time has passed.
        """
        if self._now[0] > (self._times[-1] if self._times else self._written[0]):
            self._append()
        if not self._times:
            return {}
        times, totals = np.array(self._times), np.array(self._totals)
        rates = np.diff(np.concatenate([[self._written[1]], totals]), axis=0)
        rates /= np.diff(np.concatenate([[self._written[0]], times]))[:, None, None]
        self._mean = (totals[-1] - self._written[1]) / (times[-1] - self._written[0])
        if len(times) < self._rows_wanted // 2:
            self._stride = max(1, self._stride // 2)
        self._written = (times[-1], totals[-1])
        self._times, self._totals = [], []
        impulse, moment, work = self._parts
        return {name: {"time": times, "force": rates[:, o, impulse], "moment": self._number(rates[:, o, moment]),
                       "impulse": totals[:, o, impulse], "work": totals[:, o, work[0]]}
                for o, name in enumerate(self.names)}

    def means(self):
        """Force and moment of each obstacle, means between the last two `take`s: {"NAME_force_x": [N], ...}, flat."""
        return dict(zip(self.mean_units(), self._mean[:, :-1].ravel().tolist(), strict=True))

    def mean_units(self):
        """Unit of each of `means`, per metre of width in 2-D."""
        parts = {"force_x": "N/m", "force_z": "N/m", "moment": "N m/m"}
        if self.dim == 3:
            parts = {f"{what}_{axis}": unit for what, unit in (("force", "N"), ("moment", "N m")) for axis in "xyz"}
        return {f"{name}_{part}": unit for name in self.names for part, unit in parts.items()}

    def _number(self, moments):
        return moments[:, 0] if self.dim == 2 else moments

    def state(self):
        """All that a continuation needs, by name."""
        return {"stride": self._stride, "skipped": self._skipped, "written_time": self._written[0],
                "written": self._written[1], "time": self._now[0], "now": self._now[1],
                "times": np.array(self._times, float),
                "totals": np.array(self._totals, float).reshape(len(self._times), *self._now[1].shape)}

    def restore(self, state):
        """Restore the result of `state()`."""
        self._stride, self._skipped = state["stride"], state["skipped"]
        self._written = (state["written_time"], state["written"])
        self._now = (state["time"], state["now"])
        self._times, self._totals = state["times"].tolist(), list(state["totals"])

