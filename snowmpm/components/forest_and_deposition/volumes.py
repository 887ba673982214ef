"""Trees, and snow that stops, in a flow by finite volumes."""

import math

import numpy as np

from snowmpm.components.forest_and_deposition.deposit import over_plan
from snowmpm.components.forest_and_deposition.depth import Stopping
from snowmpm.depth.kernel_api import LEAST_DEPTH

EMPTIED = 1e-6
"""Depth [m] of snow at rest that becomes ground as a whole."""


def adapter(model):
    """`StoppingInCells` of the scene of a `Model`."""
    return StoppingInCells.of(model)


class CellDeposit:
    """Snow laid down by the laws of `deposit`, cell by cell. laid (nx, ny): volume over each cell [m3]."""

    def __init__(self, grid, detrainment=None, time=None):
        """detrainment: K (nx, ny) [Pa], or None; time: T [s], None where snow at rest stays snow."""
        self._grid, self._detrainment, self._time = grid, detrainment, time
        self.laid = np.zeros(grid.shape)

    def take(self, solver, dt):
        """Lay down what stops in a step of a `VolumeSolver`; -> mass [kg], momentum (3,), energy [J]."""
        store, g = solver.particles, -float(solver.gravity[2])
        state, ground, level = map(store.inner, (store.state_array, store.ground, store.heights))
        wet = np.nonzero(state[..., 0])
        H, plan = state[(*wet, 0)].astype(float), state[wet][:, 1:].astype(float)
        cos, climb = ground[(*wet, 5)].astype(float), (plan * ground[wet][:, :2]).sum(axis=1)
        speed = np.sqrt((plan**2).sum(axis=1) + climb**2)
        gone = np.zeros(len(H))
        if self._time is not None:
            share = -math.expm1(-dt / self._time) if self._time > 0.0 else 1.0
            gone = np.where(speed == 0.0, np.where(H < EMPTIED, H, share * H), 0.0)
        if self._detrainment is not None:
            thickness = np.maximum(LEAST_DEPTH, H * cos)
            stopped = dt * self._detrainment[wet] * H / (store.density * thickness * np.maximum(speed, 1e-30))
            gone = np.where(speed > 0.0, np.minimum(stopped, H), gone)
        state[(*wet, 0)] = H - gone
        gone = H - state[(*wet, 0)]  # as it is rounded
        self.laid[wet] += gone * self._grid.dx**2
        mass, left = gone * self._grid.dx**2 * store.density, H - gone
        lifted = H * level[wet] - left * (level[wet] + gone) + 0.5 * cos**2 * (H**2 - left**2)
        level[wet] += gone
        energy = 0.5 * mass @ speed**2 + g * store.density * self._grid.dx**2 * lifted.sum()
        return float(mass.sum()), mass @ np.column_stack([plan, climb]), float(energy)

    def in_plan(self, lower, cell, shape):
        """Volume [m3] over plan cells (columns along x, rows along y); None while there is none."""
        return over_plan(self._grid, self.laid, lower, cell, shape) if self.laid.any() else None

    def state(self):
        """What changes, by name."""
        return {"laid": self.laid.copy()}

    def restore(self, state):
        """Take over a `state()`."""
        self.laid[:] = state["laid"]


class StoppingInCells(Stopping):
    """Trees that brake the snow of a `VolumeSolver`, and snow of it that becomes ground."""

    _deposit = CellDeposit

    def end_step(self, dt):
        """Lay down what stops."""
        if self.deposit is not None:
            self._solver.particles.lay(*self.deposit.take(self._solver, dt))
