"""Which lists of neighbours a solver has, of its particles and of the dummies near them, and how long they stay right.

They reach SKIN beyond the support, and are made anew when two particles may have come closer by that: twice the largest
excursion from the mean velocity of all, which brings no two of them closer, summed over the steps since.
"""

import math
from typing import Any

import numpy as np

from snowmpm.compiler.arrays import real_array
from snowmpm.sph.candidates import Group
from snowmpm.sph.neighbours import NeighbourLists, Packs
from snowmpm.sph.shortlist import ShortLists

SKIN = 0.4
"""Cells beyond the support that lists of neighbours reach."""


class Neighbourhood:
    """packs, lists: of the particles; dummy_packs, dummy_lists: of the dummies that have particles near them.

    mean_velocity (dim,) [m/s]: of the particles when the lists were made; deviation [m/s]: largest from it, which the
    solver keeps up to date.
    """

    def __init__(self, boundary, rows, precision, width, radius):
        """boundary: `Boundary`; rows: `Rows`; radius [cells]: of the support; width: lanes of a pack."""
        self._boundary, self._width, self._reach = boundary, width, radius + SKIN
        self.lists, self.dummy_lists = (NeighbourLists(boundary.dim, precision, width) for _ in range(2))
        self._rows, self._short = rows, ShortLists(rows.layout, precision, width, radius, SKIN)
        self.packs: Any = None
        self.dummy_packs: Any = None
        self._closed_in = math.inf
        self._built: Any = None
        self._move_with(np.zeros(boundary.dim), 0.0)

    @property
    def stale(self):
        """Whether the lists must be made before the next step."""
        return self._closed_in >= SKIN

    @property
    def known(self):
        """Whether there are lists, if old ones."""
        return math.isfinite(self._closed_in)

    def forget(self):
        """New lists come next."""
        self._closed_in = math.inf

    def age(self, way):
        """A step in which two particles may have come closer by `way` [cells]."""
        self._closed_in += way
        self._short.age(way)

    @property
    def of_particles(self):
        """`Lists` that a sum over the neighbours of particles reads."""
        return self._short.of(self.packs, self._rows, self.lists)

    def begin(self, rows, blocks, particle_rows, time):
        """Lists for particles that lie in the order of their blocks.

        rows: `Rows`, whose first ones are `particle_rows` (n, columns); blocks: `BlockMap`; time [s]: where
        obstacles are at.
        """
        velocity = particle_rows[:, blocks.dim : 2 * blocks.dim].astype(np.float64)
        mean = velocity.mean(axis=0) if len(velocity) else np.zeros(blocks.dim)
        self._move_with(mean, float(np.linalg.norm(velocity - mean, axis=1).max(initial=0.0)))
        self._built, self._closed_in = (particle_rows, time), 0.0
        self._find(rows, blocks)

    def _move_with(self, mean, deviation):
        self._mean, self.mean_velocity, self.deviation = mean, real_array(mean), deviation

    def _find(self, rows, blocks):
        """Lists for the rows as they are."""
        self._short.forget()
        boundary, own = self._boundary, Group(-1, blocks)
        boundary.dummies.place(rows, self._built[1])
        self.packs = Packs(blocks.start[:-1], np.diff(blocks.start), self._width)
        self.lists.build(self.packs, rows.source, blocks.coordinates, [own, *boundary.dummies.groups],
                         boundary.mirrors, self._reach)
        if boundary.dummies.count:
            coordinates, first, counts = boundary.dummies.near(blocks, self._reach)
            self.dummy_packs = Packs(first, counts, self._width)
            self.dummy_lists.build(self.dummy_packs, rows.source, coordinates, [own], boundary.mirrors, self._reach)

    @property
    def bytes(self):
        """Memory of the lists."""
        return self.lists.bytes + self.dummy_lists.bytes + self._short.bytes

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self, particle_rows):
        """Rows as they were when the lists were made and as they are, `particle_rows`, and how far that is; nothing
        when new lists come next."""
        if not self.known:
            return {}
        rows, time = self._built
        return {"built": rows[:, : self._boundary.dim].copy(), "time": time, "rows": particle_rows, "mean": self._mean,
                "deviation": self.deviation, "closed_in": self._closed_in}

    def restore(self, state, rows, blocks):
        """Take over a `state()` that is not empty: the lists that it had, and the rows."""
        self._built = state["built"], state["time"]
        rows.write(state["rows"], state["built"])
        self._find(rows, blocks)
        rows.write(state["rows"], state["rows"][:, : self._boundary.dim])
        self._move_with(np.asarray(state["mean"], float), state["deviation"])
        self._closed_in = state["closed_in"]
