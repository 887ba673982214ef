"""Rain as whole particles of water, for water with particles of its own."""

import numpy as np

from snowmpm.particles.population import Population
from snowmpm.water.phases import Phases

GOLDEN = 0.6180339887498949
"""Part of a column by which each drop falls beside the one before."""

SURFACE = 0.6
"""How full space is around water that counts as the surface of a pool, not as spray."""


class RainedPhases(Phases):
    """`Phases` on which rain falls. owed: {column: volume [m3] that has not made a drop yet}; fallen: where drops fell
    (drops, dim) [m]; spacing [m]: of the grains, and width of a column."""

    DROP_FIELD = 0
    """Velocity field of the water on a grid."""

    owed: dict
    fallen = None

    def fullness(self, water):
        """How full space is around water with these rows (n, N_WATER) of the column "water"."""
        raise NotImplementedError

    def begin(self, solver):
        """Time zero of a solver."""
        super().begin(solver)
        store = solver.particles
        labels = store.labels()
        grains = labels[:, 0] != self.material
        self.spacing = float(np.median(store.column("volume")[grains, 0])) ** (1.0 / solver.dim)
        self.owed = {}
        if self.fallen is None:  # places of the start, also where it settles before time zero
            self._first = np.empty((store.count, solver.dim))
            self._first[labels[:, 1]] = store.positions()
            self._keep(np.zeros((0, solver.dim)))

    def fall(self, dt):
        """Rain of a step of dt [s]: whole particles of water, on the highest grains or the pool of each column in plan,
        at rest."""
        if not self.rain:
            return
        solver = self._solver
        store, width, dim = solver.particles, self.spacing, solver.dim
        size = float(self.porosity[0]) * width**dim
        lower, upper = (solver.frame.origin + solver.dx * bound for bound in (solver.frame.lower, solver.frame.upper))
        counts = np.maximum(np.floor((upper - lower)[:-1] / width + 0.5).astype(int), 1)
        places = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, dim - 1)
        plan = lower[:-1] + width * (places + 0.5)
        gain = np.zeros(len(plan))
        for rate, inside in self.rain.values():
            gain += dt * rate / self.density * width ** (dim - 1) * inside(plan)
        for column in np.flatnonzero(gain > 0.0):
            self.owed[int(column)] = self.owed.get(int(column), 0.0) + float(gain[column])
        ready = [column for column, volume in self.owed.items() if volume >= size]
        if not ready:
            return
        x, labels = store.positions(), store.labels()
        holds = (labels[:, 0] != self.material) | (self.fullness(store.column("water")) > SURFACE)
        new = []
        for column in ready:
            self.owed[column] -= size
            below = holds & (np.abs(x[:, :-1] - plan[column]) < 0.5 * width).all(axis=1)
            top = x[below, -1].max(initial=lower[-1]) + 0.5 * width
            beside = ((GOLDEN * (len(self.fallen) + len(new))) % 1.0 - 0.5) * width
            new.append([*(plan[column] + beside), min(top, upper[-1] - 0.01 * width)])
        self._take_in(solver, np.array(new), size)

    def _take_in(self, solver, places, size):
        n = len(places)
        added = Population(places, np.full(n, size), self.material, field=self.DROP_FIELD)
        added.columns["water"] = self.first_rows(added.material, np.ones(n), np.zeros(n))
        first = len(self._first) + len(self.fallen)
        solver.receive(added, np.arange(first, first + n))
        self._keep(np.vstack([self.fallen, places]))
        mass = self.density * size
        self.budget.added += mass * n
        self.budget.carried_mass += mass * n
        self.budget.carried_energy -= mass * float((places @ solver.gravity).sum())

    def _keep(self, fallen):
        """Drops have numbers after those of the start."""
        self.fallen, self._solver.particles.origins = fallen, np.vstack([self._first, fallen])

    # ---- checkpoint -----------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs beside the particles, by name."""
        columns = sorted(self.owed)
        return {**super().state(), "fallen": self.fallen, "columns": np.array(columns, np.int64),
                "owed": np.array([self.owed[column] for column in columns], float)}

    def restore(self, state):
        """Take over what `state()` gave."""
        super().restore(state)
        self._keep(state["fallen"])
        self.owed = dict(zip(state["columns"].tolist(), state["owed"].tolist(), strict=True))
