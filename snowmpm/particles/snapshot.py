"""All particles of a store at one moment, copied once."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats

if TYPE_CHECKING:
    from snowmpm.particles.sorted_particles import SortedParticles


class Snapshot:
    """labels (n, 2): index of the material and number of each particle; columns and positions in the same order."""

    labels: NDArray[np.integer[Any]]

    def __init__(self, store: "SortedParticles") -> None:
        """store: `SortedParticles`, which may change afterwards."""
        self._store, self._table = store, store.table()
        self._blocks = store.blocks  # a sort makes a new one; the table belongs to this one
        self.labels = store.labels()

    def column(self, name: str) -> Floats:
        """One column of `Layout`, float64, (n, size)."""
        return self._table[:, self._store.layout.columns(name)].astype(np.float64)

    def positions(self) -> Floats:
        """Scene coordinates [m], (n, dim)."""
        return self._store.positions(self.column("position"), self._blocks)

    def plan(self) -> Floats:
        """The same in plan, (n, dim - 1)."""
        return self.positions()[:, :-1]

    def depth(self) -> Floats:
        """Thickness of the snow at each particle (n,) [m]: zero, only columns (`depth.snapshot`) have one."""
        return np.zeros(len(self._table))
