"""Water with particles of its own beside those of the grains: what all schemes of it share."""

import numpy as np

from snowmpm.water.adapter import WaterAdapter
from snowmpm.water.budget import Budget
from snowmpm.water.particle_kernels import MASS, N_WATER, PRESSURE, SOLID

THETA = 3
"""Entry of the column "water" of water's particles, beside those of `water.particle_kernels`, that a scheme keeps."""


class Phases(WaterAdapter):
    """density, bulk_modulus: of water [kg/m3], [Pa]; grains: density of the grains [kg/m3]; porosity (materials,): at
    J = 1; drag: law of `water.drag`."""

    def __init__(self, density, bulk_modulus, grains, porosity, drag):
        super().__init__()
        self.density, self.bulk_modulus, self.grains, self.drag = density, bulk_modulus, grains, drag
        self.porosity = np.asarray(porosity, float)

    @property
    def material(self):
        """Index of the material of water's particles."""
        return len(self.porosity)

    def first_pressure(self, spec):
        """At the start [Pa], of the table `[water]` where it gives no level."""
        return spec.pressure

    def first_rows(self, material, ratio, pressure):
        """Rows (n, N_WATER) that particles start with, of grains and of water; ratio (n,): J; pressure (n,) [Pa], of
        water alone."""
        wet, rows = material == self.material, np.zeros((len(material), N_WATER))
        rows[~wet, SOLID] = 1.0 - self.porosity[material[~wet]]
        rows[wet, MASS], rows[wet, PRESSURE], rows[wet, SOLID] = self.density, pressure[wet], ratio[wet] - 1.0
        rows[wet, THETA] = -pressure[wet] / self.bulk_modulus
        return rows

    def begin(self, solver):
        """Take the solver, at time zero."""
        super().begin(solver)
        self.budget = Budget(start=self.held())

    def restart(self):
        """Time zero is now."""
        self.begin(self._solver)
