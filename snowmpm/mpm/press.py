"""What the snow that is awake presses on the snow that sleeps, and how that changes.

Where snow sleeps, the nodes that it shares with snow that is awake are held (`mpm.sleep`). The force of this on each
node block, its mean over a time T, is compared with that of the first such time since the same blocks sleep around it:
then all was in balance. What has come since by more than a share of the weight of a full block is a load that the
sleeping snow has not felt, and wakes it.
"""

import numpy as np


class Press:
    """Forces on held node blocks, by the key of each; sampled, since they change from step to step.

    limit [N]: change that wakes.
    """

    def __init__(self, dim, window, limit):
        """window: T [s]."""
        self._window, self.limit, self._time = window, limit, 0.0
        self._keys, self._sum = np.zeros(0, np.int64), np.zeros((0, dim))
        self._known, self._pattern, self._force = np.zeros(0, np.int64), np.zeros(0, np.uint64), np.zeros((0, dim))
        self._begun = np.zeros(0, np.uint64)

    def add(self, keys, pattern, force, dt):
        """Forces (n, dim) [N] on held node blocks, sorted keys (n,), for the time dt [s]; pattern (n,): a number of
        which blocks sleep around each. -> those (n,) whose load has changed."""
        begun, total = self._taken(keys, self._keys, [self._begun, self._sum])
        fresh = ~np.isin(keys, self._keys)
        begun[fresh] = pattern[fresh] if self._time == 0.0 else 0
        self._keys, self._begun, self._sum = keys, begun, total + dt * force
        self._time += dt
        if self._time < self._window:
            return np.zeros(len(keys), bool)
        mean, whole = self._sum / self._time, begun == pattern
        known, before = self._taken(keys, self._known, [self._pattern, self._force])
        same = whole & (known == pattern)
        changed = same & (np.linalg.norm(mean - before, axis=1) > self.limit)
        new = whole & ~same
        self._known, self._pattern = keys, np.where(new, pattern, known)
        self._force = np.where(new[:, None], mean, before)
        self._time, self._begun, self._sum = 0.0, pattern.copy(), np.zeros_like(mean)
        return changed

    @staticmethod
    def _taken(keys, known, columns):
        """Rows of columns at keys, zero where a key is not among the known ones (sorted)."""
        at = np.minimum(np.searchsorted(known, keys), max(0, len(known) - 1))
        there = known[at] == keys if len(known) else np.zeros(len(keys), bool)
        found = []
        for column in columns:
            rows = np.zeros((len(keys), *column.shape[1:]), column.dtype)
            rows[there] = column[at[there]]
            found.append(rows)
        return found

    def state(self):
        """All that a bitwise continuation needs, by name, as copies."""
        return {"time": self._time, **{name: getattr(self, "_" + name).copy() for name in (
            "keys", "begun", "sum", "known", "pattern", "force")}}

    def restore(self, state):
        """Take over a `state()`."""
        self._time = float(state["time"])
        for name in ("keys", "begun", "sum", "known", "pattern", "force"):
            setattr(self, "_" + name, np.array(state[name]))
