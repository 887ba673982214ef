"""Snow cover in explicit MPM: particles that join where flowing snow comes near, and which of them have moved.

All particles of the scene have numbers from the start. Those of a cover that no flowing snow is near to wait outside of
the solver. Whenever the fastest particle may have gone half a cell, covers are looked at anew: particles that are
further than a cell from where they lay are part of the flow from then on, and what lies within `laid_ahead` of the flow
in plan is laid, at rest, with the stress that the scene gave it at the start. The rim of what is laid, beside cover
that waits, is held: a free band would give way to a flow that pushes it, and slump at its end.
"""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt

from snowmpm.compiler import runtime
from snowmpm.components.erodible_snow.anchor import anchor_kernel
from snowmpm.components.erodible_snow.declare import COLUMN
from snowmpm.particles.population import Population
from snowmpm.particles.store import IDENTITY
from snowmpm.quantities.motion import MOVING_SPEED
from snowmpm.stepping.component import Adapter

MOVED = 1.0
"""Cells from its place beyond which snow has left it."""
LOOK = 0.5
"""Cells that the fastest particle may go before covers are looked at anew."""
RIM = 2.0
"""Mark of the rim, which is held; 1: of the rest that lies as it was laid."""
CELLS = 4.0
"""Least number of plan cells to the way `laid_ahead`, for distances; no cell is smaller than one of the grid."""


def marked(scene, body, population):
    """The `Population` of a body, whose particles lie undisturbed where it is a cover."""
    mark = np.full((len(population.volumes), 1), float(body.laid_ahead is not None))
    return replace(population, columns={**population.columns, COLUMN: mark})


def adapter(model):
    """`ErodibleSnow` of a `Model`."""
    across = float(np.linalg.norm(model.upper - model.lower))  # no way is longer
    ahead = [body.laid_ahead and min(body.laid_ahead, across) for body in model.scene.bodies]
    return ErodibleSnow(model.population, model.body_of, ahead)


class ErodibleSnow(Adapter):
    """The covers of an `MpmSolver`.

    population: of the whole scene; body_of (n,): of each particle; ahead: of each body [m], None of no cover.
    """

    name = "erodible_snow"
    columns: ClassVar = {COLUMN: 1}
    still_column = COLUMN

    def __init__(self, population, body_of, ahead):
        self._population = population
        cover = np.array([one is not None for one in ahead])
        self._cover = np.flatnonzero(cover[body_of])
        self._ahead = np.array([one or 0.0 for one in ahead])[body_of[self._cover]]

    def begin(self, solver):
        """Leave out what no flowing snow is near to."""
        self._solver, self._way = solver, 0.0
        store = solver.particles
        self._store, self._moved = store, MOVED * solver.dx
        self._mass = self._masses(np.arange(len(self._population.volumes)))
        self._plan = _PlanCells(self._population.positions[self._cover][:, :-1], self._ahead, solver.dx)
        near = self._plan.near(self._flowing())
        gone = np.isin(store.labels()[:, IDENTITY], self._cover[~near])
        if gone.any():
            removed = {name: np.copy(value) if isinstance(value, np.ndarray) else value
                       for name, value in store.removed.items()}
            solver.remove(gone)
            store.removed = removed
        self._laid = near
        self._stop = anchor_kernel(store.layout, runtime.DTYPES[solver.precision][0], COLUMN)
        self._hold_rim()
        self.restart()

    def _masses(self, rows):
        population, density = self._population, self._store.materials.density
        return population.volumes[rows] * density[population.material[rows]]

    def _flowing(self):
        """Places in plan (k, dim - 1) [m] of the snow that flows."""
        return self._store.positions()[self._store.column(COLUMN)[:, 0] <= 0.0, :-1]

    def before_step(self, dt, pushed):
        """Look at the covers where the flow has gone on."""
        if self._solver.damping_factor == 1.0:
            self._way += self._solver.extremes.speed * dt
            if self._way > LOOK * self._solver.dx:
                self._way = 0.0
                self._look()
        return pushed

    def after_gather(self, dt):
        """Stop the rim."""
        if self._rim:
            store, given = self._store, np.zeros(self._solver.dim + 1)
            self._stop(store.reals, store.slot_offset, store.material, store.materials.numbers, given, store.count)
            store.changes += 1
            self._solver.add_impulse(given[:-1])
            self._held += given

    def _hold_rim(self):
        """Mark what lies beside cover that waits, and is part of no flow."""
        rim = np.zeros(len(self._population.volumes), bool)
        rim[self._cover] = self._plan.beside(self._laid)
        store = self._store
        table, labels, at = store.table(), store.labels()[:, IDENTITY], store.layout.columns(COLUMN)
        still = table[:, at][:, 0] > 0.0
        table[:, at] = np.where(still, np.where(rim[labels], RIM, 1.0), 0.0)[:, None]
        store.overwrite(table)
        self._rim = bool((still & rim[labels]).any())

    def _look(self):
        store = self._store
        mark = store.column(COLUMN)[:, 0] > 0.0
        if mark.any():
            way = store.positions()[mark] - self._population.positions[store.labels()[mark, IDENTITY]]
            left = np.einsum("ij,ij->i", way, way) > self._moved**2
            if left.any():
                table = store.table()
                table[np.flatnonzero(mark)[left], store.layout.columns(COLUMN)] = 0.0
                store.overwrite(table)
        if not self._laid.all():
            wanted = self._plan.near(self._flowing()) & ~self._laid
            if wanted.any():
                self._lay(wanted)

    def _lay(self, wanted):
        """Let the chosen particles of covers join."""
        rows = self._cover[wanted]
        population = _rows_of(self._population, rows)
        materials, mass = self._store.materials, self._mass[rows]
        state = materials.state_of(population, np.arange(len(rows)))
        elastic = materials.elastic_energy(population.material, population.stress, state, population.volumes)
        self._solver.receive(population, rows)
        self._laid |= wanted
        self._hold_rim()
        self._joined += float(mass.sum())
        self._energy += float(elastic - mass @ (population.positions @ self._solver.gravity))

    def restart(self):
        """Time zero is now."""
        self._joined, self._energy, self._held = 0.0, 0.0, np.zeros(self._solver.dim + 1)
        self._flow_at_start = self._flow()

    def _flow(self):
        """Mass that flows, or has left [kg]."""
        store = self._store
        flows = store.column(COLUMN)[:, 0] <= 0.0
        return float(store.masses()[flows].sum()) + store.removed["mass"]

    def entrained(self):
        """Mass of the covers that has left its place [kg]."""
        return self._flow() - self._flow_at_start

    def given(self, lift):
        """Energy of what was laid."""
        return {"cover_energy": self._energy + self._joined * lift}

    def impulses(self):
        """That of holding the rim."""
        return [self._held[:-1]]

    def damping_work(self):
        """Energy that holding the rim took."""
        return -float(self._held[-1])

    def row(self):
        """Mass of the covers that was laid since time zero, and of what has moved, that which is slow again [kg]."""
        store = self._store
        mass, v = store.masses(), store.column("velocity")
        slow = np.einsum("ij,ij->i", v, v) <= MOVING_SPEED**2
        labels = store.labels()[:, IDENTITY]
        way = store.positions() - self._population.positions[labels]
        moved = np.einsum("ij,ij->i", way, way) > self._moved**2
        return {"cover_mass": self._joined, "deposited_mass": float(mass[moved & slow].sum())}

    def units(self):
        """Units of these."""
        width = "/m" if self._solver.dim == 2 else ""
        return {"cover_energy": f"J{width}", "cover_mass": f"kg{width}", "deposited_mass": f"kg{width}"}

    def work(self):
        """Particles that are looked at."""
        return {"step": 1, "particle": self._store.count}

    @property
    def bytes(self):
        """Of the tables of covers."""
        return 24 * len(self._cover)

    def state(self):
        """What is laid, and the sums."""
        return {"laid": self._laid.copy(), "way": self._way, "joined": self._joined, "energy": self._energy,
                "held": self._held.copy(), "flow": self._flow_at_start}

    def restore(self, state):
        """Take over what `state()` gave."""
        self._laid = np.asarray(state["laid"], bool).copy()
        self._way, self._joined, self._energy = (float(state[name]) for name in ("way", "joined", "energy"))
        self._flow_at_start, self._held = float(state["flow"]), np.array(state["held"], float)
        self._rim = bool((self._store.column(COLUMN) >= RIM).any())


def _rows_of(population, rows):
    """Some rows of a `Population`."""
    found = {name: value[rows] for name, value in vars(population).items()
             if isinstance(value, np.ndarray)}
    return Population(**found, columns={name: values[rows] for name, values in population.columns.items()},
                      **{name: value for name, value in vars(population).items()
                         if value is None and name not in found})


class _PlanCells:
    """Cells of the plan of particles (n, dim - 1) [m], each with its own way `ahead` (n,) [m]: who is near to what."""

    def __init__(self, plan, ahead, dx):
        self._ahead = ahead
        self._side = max(dx, float(ahead.min()) / CELLS)
        cell = np.floor(plan / self._side).astype(np.int64)
        self._margin = int(np.ceil(ahead.max() / self._side)) + 1
        self._low = cell.min(axis=0) - self._margin
        self._shape = np.ptp(cell, axis=0) + 2 * self._margin + 1
        self._place = tuple((cell - self._low).T)

    def beside(self, laid):
        """Which particles, of those that are laid (n,), lie in a cell beside one with particles that are not."""
        waits = np.zeros(self._shape, bool)
        waits[tuple(axis[~laid] for axis in self._place)] = True
        near = binary_dilation(waits, np.ones((3,) * len(self._shape)))
        return laid & near[self._place]

    def near(self, flow):
        """Which particles have flowing snow, places in plan (k, dim - 1) [m], within their way."""
        cell = np.floor(flow / self._side).astype(np.int64) - self._low
        inside = ((cell >= 0) & (cell < self._shape)).all(axis=1)
        free = np.ones(self._shape, bool)
        free[tuple(cell[inside].T)] = False
        if free.all():
            return np.zeros(len(self._ahead), bool)
        return distance_transform_edt(free)[self._place] * self._side <= self._ahead
