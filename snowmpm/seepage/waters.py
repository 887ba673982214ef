"""Water that seeps: what a scene says of it, and the rain that falls on it."""

import numpy as np

from snowmpm.particles.population import Population
from snowmpm.water.particle_kernels import PRESSURE
from snowmpm.water.phases import THETA, Phases

GOLDEN = 0.6180339887498949
"""Part of a column by which each drop falls beside the one before."""

OWN = 4
"""Entry of the column "water": the pressure of a particle by itself. What its equations give differs from row to row,
which the kernel, and so the forces, do not see: what is told is the mean around it."""

SURFACE = 0.6
"""How full space is around water that counts as the surface of a pool, not as spray."""


class SeepingWaters(Phases):
    """`Phases` of `seepage.solver.SeepageSolver`, which keeps how full space is in the entry THETA."""

    def __init__(self, *given):
        super().__init__(*given)
        self.owed = {}
        self.fallen = None
        """where drops fell (drops, dim) [m]"""

    def columns(self, material, ratio, pressure):
        """As of `Phases`: THETA is 1 in water at the start."""
        rows = super().columns(material, ratio, pressure)
        rows[:, OWN] = rows[:, PRESSURE]
        rows[:, THETA] = np.where(material == self.material, 1.0, 0.0)
        return rows

    def mobile(self, medium, solid, speed):
        """C [Pa s/m2] of the drag law (n,) by `Grains.around` and |w| (n,) [m/s]: at the edge of the medium as much as
        there is of it."""
        inside = medium > 1e-9
        porosity = 1.0 - solid / np.where(inside, medium, 1.0)
        coefficient = self.drag.coefficient(np.clip(porosity, 1e-3, 1.0), speed)
        return np.where(inside, np.minimum(medium, 1.0) * coefficient, 0.0)

    def act(self, solver):
        """Before the forces of a step: nothing, since the pressure is found within it."""

    def close(self, solver, dt):
        """After a step: nothing."""

    # ---- rain -----------------------------------------------------------------------------------------------------

    def fall(self, solver, dt):
        """Rain of a step of dt [s]: whole particles of water, on the highest grains or the pool of each column of dx in
        plan, at rest."""
        if not self.rain:
            return
        store, dx, dim = solver.particles, solver.dx, solver.dim
        size = float(self.porosity[0]) * dx**dim
        lower, upper = (solver.frame.origin + dx * bound for bound in (solver.frame.lower, solver.frame.upper))
        counts = np.maximum(np.floor((upper - lower)[:-1] / dx + 0.5).astype(int), 1)
        places = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, dim - 1)
        plan = lower[:-1] + dx * (places + 0.5)
        gain = np.zeros(len(plan))
        for rate, inside in self.rain.values():
            gain += dt * rate / self.density * dx ** (dim - 1) * inside(plan)
        for column in np.flatnonzero(gain > 0.0):
            self.owed[int(column)] = self.owed.get(int(column), 0.0) + float(gain[column])
        ready = [column for column, volume in self.owed.items() if volume >= size]
        if not ready:
            return
        x, labels, fills = store.positions(), store.labels(), store.column("water")[:, THETA]
        holds = (labels[:, 0] != self.material) | (fills > SURFACE)
        new = []
        for column in ready:
            self.owed[column] -= size
            below = holds & (np.abs(x[:, :-1] - plan[column]) < 0.5 * dx).all(axis=1)
            top = x[below, -1].max(initial=lower[-1]) + 0.5 * dx
            beside = ((GOLDEN * (len(self.fallen) + len(new))) % 1.0 - 0.5) * dx
            new.append([*(plan[column] + beside), min(top, upper[-1] - 0.01 * dx)])
        self._take_in(solver, np.array(new), size)

    def _take_in(self, solver, places, size):
        store, n = solver.particles, len(places)
        added = Population(places, np.full(n, size), self.material)
        added.water = self.columns(added.material, np.ones(n), np.zeros(n))
        first = len(self._first) + len(self.fallen)
        store.add(added, np.arange(first, first + n))
        self._keep(np.vstack([self.fallen, places]))
        mass = self.density * size
        self.budget.added += mass * n
        self.budget.carried_mass += mass * n
        self.budget.carried_energy -= mass * float((places @ solver.gravity).sum())

    # ---- checkpoint -----------------------------------------------------------------------------------------------

    def begin(self, solver):
        """Time zero of a solver."""
        super().begin(solver)
        self.owed, self._first = {}, solver.first_places
        self._keep(np.zeros((0, solver.dim)))

    def _keep(self, fallen):
        """Drops have numbers after those of the start."""
        self.fallen, self._solver.particles.origins = fallen, np.vstack([self._first, fallen])

    def state(self):
        """All that a bitwise continuation needs beside the particles, by name."""
        columns = sorted(self.owed)
        return {**super().state(), "fallen": self.fallen, "columns": np.array(columns, np.int64),
                "owed": np.array([self.owed[column] for column in columns], float)}

    def restore(self, state, solver):
        """Take over what `state()` gave."""
        super().restore(state, solver)
        self._keep(state["fallen"])
        self.owed = dict(zip(state["columns"].tolist(), state["owed"].tolist(), strict=True))

    @staticmethod
    def noted(rows, pressures, share, full):
        """Column "water" rows (n, k) of particles of water with their pressures [Pa], the mean one around them and
        their own, the share of the water around them and how full space is; -> their J."""
        (rows[:, PRESSURE], rows[:, OWN]), rows[:, THETA] = pressures, full
        rows[:, 2] = 1.0 / share - 1.0
        return 1.0 / share
