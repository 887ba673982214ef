"""Trees, and snow that stops, in a depth-averaged flow."""

from functools import partial
from typing import Any

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.components.forest_and_deposition.deposit import CROWD, EMPTIED, EMPTY, ENERGY, MASS, MOMENTUM, Deposit
from snowmpm.components.forest_and_deposition.drag import with_drag
from snowmpm.components.forest_and_deposition.from_scene import forest_at
from snowmpm.errors import InputError
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`Stopping` of the scene of a `Model`."""
    return Stopping.of(model)


class Stopping(Adapter):
    """Trees that brake the columns of a `DepthSolver`, and snow of these that becomes ground.

    forest: plan places (n, 2) -> drag [-] and detrainment [Pa] (n, 2), or None; time: in which snow at rest becomes
    ground [s], or None where it stays snow.
    """

    name = "forest_and_deposition"
    _deposit: Any = Deposit

    @classmethod
    def of(cls, model):
        """That of the scene of a `Model`."""
        terrain = model.scene.terrain
        forest = partial(forest_at, model.scene, model.surface) if terrain.forest else None
        return cls(forest, terrain.deposition.time if terrain.deposition else None)

    def __init__(self, forest=None, time=None):
        self._forest, self._time = forest, time
        self._trees: Any = None
        self.deposit: Any = None

    def friction(self, law, numbers, grid):
        """The law with the drag of the trees, where they have some."""
        if self._forest is None:
            return law, numbers
        self._trees = self._forest(grid.places().reshape(-1, 2)).reshape(*grid.shape, 2)
        if not self._trees[..., 0].any():
            return law, numbers
        everywhere = np.broadcast_to(numbers, (grid.n_nodes, numbers.shape[1]))
        return with_drag(law), np.column_stack([everywhere, grid.flat(self._trees[..., 0])])

    def begin(self, solver):
        """Take the solver's columns and ground. Raises InputError beside periodic sides, where snow becomes ground."""
        self._solver = solver
        stops = self._trees is not None and self._trees[..., 1].any()
        if not stops and self._time is None:
            return
        if solver.grid.repeats.any():
            raise InputError.at("domain.boundary", "periodic", "does not go with snow that becomes ground where it"
                                                               " stops")
        self.deposit = self._deposit(solver.grid, self._trees[..., 1] if stops else None, self._time)
        self.moves_ground = True
        solver.particles.laid_in_plan.append(self.deposit.in_plan)

    def end_step(self, dt):
        """Lay down what stops; take out columns that hold next to nothing, once they are many."""
        if self.deposit is None:
            return
        solver, store = self._solver, self._solver.particles
        with runtime.precision(solver.precision):
            sums = self.deposit.take(solver, dt)
        store.lay(float(sums[MASS]), sums[MOMENTUM : MOMENTUM + 3], float(sums[ENERGY]))
        if sums[EMPTY] > CROWD * store.flowing:
            store.take(store.column("volume")[:, 0] > EMPTIED * solver.unit, solver.gravity, laid=True)

    def state(self):
        """What was laid down."""
        return self.deposit.state() if self.deposit else {}

    def restore(self, state):
        """Take over what `state()` gave."""
        if self.deposit:
            self.deposit.restore(state)
