"""The water in full pores over an implicit step, with one pressure p a material cell (finite volumes).

    r(u, p) = P(u) (1 + p / K_w) - W + dt sum_faces Q(p) = 0,    Q = A K / (mu d) (p - p' - rho_w g . d)

P: volume of the pores, sum_p V (J - s) over the particles of a cell, s the grains' share; W: volume of the water at the
start (Nøst 2019, Iteratively coupled implicit dynamic MPM-FVM, NTNU, eqs. 6.2, 7.2, 7.14, with the sign of Darcy's law
that diffuses). Backward Euler. p is positive in compression.
"""

import numpy as np

from snowmpm.components.pore_water.step import LEAST_POROSITY
from snowmpm.water.flux import TwoPointFlux, solve
from snowmpm.water.particle_kernels import MASS, PRESSURE, SOLID


class Pores:
    """matter: `MaterialPoints` with water; cells: `MaterialCells` of it; water: `solved.SolvedWater`; dt [s].

    content (cells,): W [m3]; start (cells,): pressure at the start [Pa]."""

    def __init__(self, matter, cells, codes, water, place, dt):
        """codes: of the border faces (`outlets`); place: `solved.Place`."""
        fluid, self.cells, self._K, self.dt = water.fluid, cells, water.fluid.bulk_modulus, dt
        self._volume, held = matter.volume, matter.columns["water"]
        self._solid = held[:, SOLID]
        self.bulk = cells.sums(matter.volume * matter.ratio)
        now = self.volume(matter.ratio)
        self.content = cells.sums(matter.volume * held[:, MASS]) / fluid.density
        self.start = cells.mean(held[:, PRESSURE], self.of_particles(matter.ratio))
        centres = place.origin + place.dx * (cells.coordinates + 0.5)
        mobility = water.permeability(centres, now / self.bulk) / fluid.viscosity
        self._flux = TwoPointFlux(cells, place.dx)
        self._inner = dt * self._flux.conductances(mobility)
        self._border = np.where(water.outlets.open(codes), dt * self._flux.border_conductances(mobility), 0.0)
        self._head = fluid.density * place.dx * place.gravity[cells.axis]
        self._border_head = 0.5 * fluid.density * place.dx * place.gravity[cells.border_axis] * cells.border_sign

    def of_particles(self, ratio):
        """Volume of the pores (n,) [m3] at J (n,)."""
        return self._volume * np.maximum(ratio - self._solid, LEAST_POROSITY * ratio)

    def volume(self, ratio):
        """P (cells,) [m3]."""
        return self.cells.sums(self.of_particles(ratio))

    def flows(self, p):
        """Water [m3] that goes through inner faces in the step, from first to second, and out through border faces."""
        cells = self.cells
        return (self._inner * (p[cells.first] - p[cells.second] + self._head),
                self._border * (p[cells.border] + self._border_head))

    def residual(self, p, ratio):
        """r (cells,) [m3]."""
        return self.volume(ratio) * (1.0 + p / self._K) - self.content + self._flux.outflow(*self.flows(p))

    def matrix(self, ratio, added=0.0):
        """dr/dp (cells, cells) at fixed u, and `added` (cells,) on its diagonal [m3/Pa]."""
        return self._flux.matrix(self.volume(ratio) / self._K + added, self._inner, self._border)

    def correction(self, p, ratio, added):
        """dp of the equation of the flow alone."""
        return solve(self.matrix(ratio, added), -self.residual(p, ratio))

    def kept(self, p, ratio):
        """Water of the particles (n,) [m3] at the end, by what flowed, and what left through each border face."""
        through, out = self.flows(p)
        content = self.content - self._flux.outflow(through, out)
        pores = self.of_particles(ratio)
        return (content / self.cells.sums(pores))[self.cells.of] * pores, out
