"""All particles of a store at one moment, copied once."""

import numpy as np


class Snapshot:
    """labels (n, 2): index of the material and number of each particle; columns and positions in the same order."""

    def __init__(self, store):
        """store: `SortedParticles`, which may change afterwards."""
        self._store, self._table = store, store.table()
        self._blocks = store.blocks  # a sort makes a new one; the table belongs to this one
        self.labels = store.labels()

    def column(self, name):
        """One column of `Layout`, float64, (n, size)."""
        return self._table[:, self._store.layout.columns(name)].astype(np.float64)

    def positions(self):
        """Scene coordinates [m], (n, dim)."""
        return self._store.positions(self.column("position"), self._blocks)
