"""Layers thinner than a cell (`particles.interface`) in a step of MPM: what they refuse, their impulse, their step."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.interface import lift_at, stiffest, swing
from snowmpm.particles.interface_impulse import InterfaceImpulse


class InterfaceLayer:
    """The interfaces of a solver, all together."""

    def __init__(self, solver, population, laws, serial):
        """solver: `MpmSolver` with its particles and grid; population: `Population` with interfaces; laws: one per
        material index; serial: see `compiler.parallel.runs_serially`.

        Raises InputError for a transfer without FLIP and bodies that part.
        """
        if not solver.flip:
            raise InputError('solver.transfer: must be "flip" or "aflip" beside an interface')
        if solver.grid.bodies:
            raise InputError("bodies: an interface does not go with bodies that part")
        lift = population.interface[:, lift_at(solver.dim)].max(initial=0.0) / solver.dx
        self._rate = stiffest(population, laws, solver.dim) * swing(lift, STENCILS[solver.basis].inverse_second_moment)
        self._impulse = InterfaceImpulse(solver.particles, serial)
        self.points = int(population.interface[:, : solver.dim].any(axis=1).sum())
        """How many there are at the start."""

    def impulse(self, dt):
        """Impulse (dim,) [N s] of a step of dt [s], by the stresses before it."""
        return self._impulse.of(dt)

    def shorten(self, dt, critical, elastic):
        """dt [s] with the swings of the layer under its points' own mass: frequencies add up by their squares.
        critical, elastic: the cfl at which waves grow, and that of dt."""
        return dt / np.hypot(1.0, 0.5 * self._rate * dt * critical / elastic) if self._rate > 0.0 else dt
