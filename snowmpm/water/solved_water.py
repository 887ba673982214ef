"""Water in the pores whose pressure is solved for in the steps of a method (`snowmpm.implicit`)."""

from dataclasses import dataclass

import numpy as np

from snowmpm.water.cells import MaterialCells
from snowmpm.water.particle_kernels import MASS, PRESSURE, RATIO
from snowmpm.water.pore_water import PoreWater


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


class SolvedWater(PoreWater):
    """`PoreWater` that is part of the equations of a step; coupling: `Coupling`.

    passes: of the coupling in the last step."""

    def __init__(self, fluid, permeability, outlets, coupling):
        super().__init__(fluid, permeability, outlets, share=0.0)
        self.coupling, self.passes = coupling, 0

    def act(self, solver):
        """Nothing: the step itself does it."""

    def close(self, solver, dt):
        """After a step: mass and what laws know of the water."""
        store = solver.particles
        store.mass = float(store.masses().sum())
        self._moisten(solver, store.column("water"))

    def cells(self, coordinates, frame, time):
        """`MaterialCells` of particles in cells with integer coordinates (n, dim), and the codes of their borders."""
        cells = MaterialCells(coordinates)
        return cells, self.outlets.codes(cells, frame, time)

    def take(self, matter, pores, pressure):
        """Give particles what a solved part of a step left them; -> mass that each gained (n,) [kg]."""
        kept, out = pores.kept(pressure, matter.ratio)
        rows = matter.water.copy()
        p = pressure[pores.cells.of]
        self.budget.work += float((matter.volume * p) @ (matter.ratio - rows[:, RATIO]))
        self.budget.drained += self.fluid.density * float(out.sum())
        mass = self.fluid.density * kept
        gained = mass - matter.volume * rows[:, MASS]
        rows[:, MASS], rows[:, PRESSURE], rows[:, RATIO] = mass / matter.volume, p, matter.ratio
        matter.water, matter.mass = rows, matter.mass + gained
        return gained
