"""Water that seeps: what its particles keep."""

import numpy as np

from snowmpm.water.drops import RainedPhases
from snowmpm.water.particle_kernels import PRESSURE
from snowmpm.water.phases import THETA

OWN = 4
"""Entry of the column "water": the pressure of a particle by itself. What its equations give differs from row to row,
which the kernel, and so the forces, do not see: what is told is the mean around it."""


class SeepingWaters(RainedPhases):
    """`RainedPhases` of a `solver.SeepageSolver`, which keeps how full space is in the entry THETA."""

    name = "seepage"

    def first_pressure(self, spec):
        """None: it is solved for."""
        return 0.0

    def first_rows(self, material, ratio, pressure):
        """As of `Phases`: THETA is 1 in water at the start."""
        rows = super().first_rows(material, ratio, pressure)
        rows[:, OWN] = rows[:, PRESSURE]
        rows[:, THETA] = np.where(material == self.material, 1.0, 0.0)
        return rows

    def fullness(self, water):
        """As the last step found it."""
        return water[:, THETA]

    def mobile(self, medium, solid, speed):
        """C [Pa s/m2] of the drag law (n,) by `Grains.around` and |w| (n,) [m/s]: at the edge of the medium as much as
        there is of it."""
        inside = medium > 1e-9
        porosity = 1.0 - solid / np.where(inside, medium, 1.0)
        coefficient = self.drag.coefficient(np.clip(porosity, 1e-3, 1.0), speed)
        return np.where(inside, np.minimum(medium, 1.0) * coefficient, 0.0)

    def before_step(self, dt, pushed):
        """Rain."""
        self.fall(dt)
        return pushed

    def work(self):
        """Particles."""
        return {"particle": self._solver.particles.count, "step": 1}

    @staticmethod
    def noted(rows, pressures, share, full):
        """Column "water" rows (n, k) of particles of water with their pressures [Pa], the mean one around them and
        their own, the share of the water around them and how full space is; -> their J."""
        (rows[:, PRESSURE], rows[:, OWN]), rows[:, THETA] = pressures, full
        rows[:, 2] = 1.0 / share - 1.0
        return 1.0 / share
