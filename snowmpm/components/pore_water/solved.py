"""Water in the pores whose pressure is among the unknowns of the steps of implicit MPM."""

from dataclasses import dataclass

import numpy as np

from snowmpm.components.pore_water.step import FilledPores
from snowmpm.water.cells import MaterialCells
from snowmpm.water.particle_kernels import MASS, PRESSURE, RATIO


@dataclass(frozen=True)
class Place:
    """dx [m] and origin (dim,) [m] of the cells, gravity (dim,) [m/s2]."""

    dx: float
    origin: np.ndarray
    gravity: np.ndarray


@dataclass(frozen=True)
class Coupling:
    """way: "monolithic" or "fixed_stress"; of the latter, alpha over 1 / K_dr, tolerance of |r| over its first value,
    and the most passes."""

    way: str
    alpha: float
    tolerance: float
    passes: int


class SolvedWater(FilledPores):
    """`FilledPores` that are part of the equations of a step; coupling: `Coupling`; equations: (solver, water) ->
    `implicit.step_solver.StepSolver` of both.

    passes: of the coupling in the last step."""

    def __init__(self, fluid, permeability, outlets, coupling, equations):
        super().__init__(fluid, permeability, outlets)
        self.coupling, self._equations, self.passes = coupling, equations, 0

    def begin(self, solver):
        """Take the solver, at time zero, and let it solve for the pressure too."""
        super().begin(solver)
        solver.step_solver = self._equations(solver, self)

    def end_step(self, dt):
        """After a step: mass and what laws know of the water."""
        store = self._solver.particles
        store.mass = float(store.masses().sum())
        self._moisten(self._solver, store.column("water"))

    def cells(self, coordinates, frame, time):
        """`MaterialCells` of particles in cells with integer coordinates (n, dim), and the codes of their borders."""
        cells = MaterialCells(coordinates)
        return cells, self.outlets.codes(cells, frame, time)

    def take(self, matter, pores, pressure):
        """Give particles what a solved part of a step left them, and book momentum and energy of what each gained,
        where it is now."""
        kept, out = pores.kept(pressure, matter.ratio)
        rows = matter.columns["water"].copy()
        p = pressure[pores.cells.of]
        self.budget.work += float((matter.volume * p) @ (matter.ratio - rows[:, RATIO]))
        self.budget.drained += self.fluid.density * float(out.sum())
        mass = self.fluid.density * kept
        gained = mass - matter.volume * rows[:, MASS]
        rows[:, MASS], rows[:, PRESSURE], rows[:, RATIO] = mass / matter.volume, p, matter.ratio
        matter.columns["water"], matter.mass = rows, matter.mass + gained
        self._book(matter, gained)

    def _book(self, matter, gained):
        """gained (n,) [kg]."""
        solver = self._solver
        solver.add_impulse(gained @ matter.velocity)
        x = solver.frame.origin + solver.dx * matter.cells
        energy = 0.5 * (matter.velocity**2).sum(axis=1) - x @ solver.gravity
        self.budget.carried_energy += float(gained @ energy)
        self.budget.carried_mass += float(gained.sum())
