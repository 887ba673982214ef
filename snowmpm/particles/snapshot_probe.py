"""Chosen particles of a store that is read by snapshots."""

import numpy as np


class SnapshotProbe:
    """Chosen particles of a `particles.contract.Particles`, in a fixed order, as they are now. there (k,): not removed
    yet."""

    def __init__(self, store, chosen):
        self._store, self._chosen = store, np.asarray(chosen)
        self.read()

    def read(self):
        """Look again."""
        self._snapshot = self._store.snapshot()
        identity = self._snapshot.labels[:, 1]
        order = np.argsort(identity)
        place = np.searchsorted(identity[order], self._chosen).clip(0, max(0, len(order) - 1))
        self._rows = order[place] if len(order) else np.zeros(len(self._chosen), int)
        self.there = identity[self._rows] == self._chosen if len(order) else np.zeros(len(self._chosen), bool)

    def column(self, name, part=slice(None)):
        """(k, size), float64, of all or a part (slice) of the chosen ones."""
        return self._snapshot.column(name)[self._rows[part]]

    def positions(self, part=slice(None)):
        """Scene coordinates [m] (k, 3), NaN for those that are gone."""
        return np.where(self.there[part, None], self._snapshot.positions()[self._rows[part]], np.nan)


