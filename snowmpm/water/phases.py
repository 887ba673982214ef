"""Water with particles of its own beside those of the grains: what all schemes of it share."""

import numpy as np

from snowmpm.water.budget import Budget
from snowmpm.water.particle_kernels import MASS, N_WATER, PRESSURE, SOLID

THETA = 3
"""Entry of the column "water" of water's particles, beside those of `water.particle_kernels`, that a scheme keeps."""


class Phases:
    """density, bulk_modulus: of water [kg/m3], [Pa]; grains: density of the grains [kg/m3]; porosity (materials,): at
    J = 1; drag: law of `water.drag`. budget: `Budget`; rain: {source: (rate [kg/m2/s], plan (k, dim - 1) [m] -> (k,)
    bool)} that fall now, of a scheme that takes rain."""

    outlets = None
    share = 1.0
    """No split of `water.pore_water`: failures are not its."""

    def __init__(self, density, bulk_modulus, grains, porosity, drag):
        self.density, self.bulk_modulus, self.grains, self.drag = density, bulk_modulus, grains, drag
        self.porosity = np.asarray(porosity, float)
        self.budget, self.rain = Budget(), {}

    @property
    def material(self):
        """Index of the material of water's particles."""
        return len(self.porosity)

    def columns(self, material, ratio, pressure):
        """Rows (n, N_WATER) that particles start with, of grains and of water; ratio (n,): J; pressure (n,) [Pa], of
        water alone."""
        wet, rows = material == self.material, np.zeros((len(material), N_WATER))
        rows[~wet, SOLID] = 1.0 - self.porosity[material[~wet]]
        rows[wet, MASS], rows[wet, PRESSURE], rows[wet, SOLID] = self.density, pressure[wet], ratio[wet] - 1.0
        rows[wet, THETA] = -pressure[wet] / self.bulk_modulus
        return rows

    def begin(self, solver):
        """Time zero of a solver."""
        self._solver, solver.particles.water_density = solver, self.density
        solver.particles.fluid = self.material
        self.budget = Budget(start=self.held())

    def held(self):
        """Water in the particles now [kg]."""
        particles = self._solver.particles
        return float(particles.column("volume")[:, 0] @ particles.column("water")[:, MASS])

    def state(self):
        """All that a bitwise continuation needs beside the particles, by name."""
        return {"budget": self.budget.state()}

    def restore(self, state, solver):
        """Take over what `state()` gave."""
        self._solver, self.budget = solver, Budget(**state["budget"])
