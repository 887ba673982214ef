"""Terzaghi's column by explicit MPM with two velocities, skeleton and water, in one dimension.

One set of particles, one in each cell, rides with the skeleton, and carries the velocity of both (Jassim et al. 2013,
doi:10.1002/nag.2146; linear hat functions N). With the weights n for water and 1 - n for grains in mass and momentum,

    m_w a_w = sum V n p grad N - D (w - v),   m_s a_s = sum V (-sigma' + (1 - n) p) grad N + load + D (w - v)
    p <- p - dt K_w / n ((1 - n) div v + n div w),   sigma' <- sigma' + dt E div v

The drag is integrated exactly (`water.drag.relaxed`), so that the step is that of waves in undrained soil alone,
whatever the permeability. Small strains; p positive in compression. For study: scenes have the u-p scheme.
"""

import numpy as np

from snowmpm.study.problems.soaked_column import (
    C_V,
    E_OED,
    HEIGHT,
    K_W,
    LOAD,
    PERMEABILITY,
    POROSITY,
    VISCOSITY,
    terzaghi,
)
from snowmpm.water.drag import Darcy, relaxed

GRAINS, WATER = 1600.0 / (1.0 - POROSITY), 1000.0
"""Densities [kg/m3]."""
UNDRAINED = np.sqrt((E_OED + K_W / POROSITY) / (GRAINS * (1.0 - POROSITY) + WATER * POROSITY))
"""Bound of the speed of waves [m/s]."""


class TwoVelocityColumn:
    """cells: of the column; law: of drag."""

    def __init__(self, cells, law=None):
        self.n, self.dx = cells, HEIGHT / cells
        self.law = law or Darcy(PERMEABILITY / VISCOSITY)
        self.v, self.w, self.stress = (np.zeros(cells) for _ in range(3))
        self.p, self.time = np.full(cells, LOAD), 0.0

    @property
    def longest_step(self):
        """[s]; FLIP starts anew from the particles in each step, so that it is stable to dt w = sqrt(2), not 2."""
        return self.dx / UNDRAINED / np.sqrt(2.0)

    def _to_nodes(self, values):
        """sum over particles of N times values, N = 1/2 at both nodes of the cell."""
        found = np.zeros(self.n + 1)
        found[:-1] += 0.5 * values
        found[1:] += 0.5 * values
        return found

    def _forces(self, values):
        """sum over particles of grad N times dx times values."""
        found = np.zeros(self.n + 1)
        found[:-1] -= values
        found[1:] += values
        return found

    def step(self, dt):
        """Advance by dt [s]."""
        n, dx = POROSITY, self.dx
        m_s, m_w = (self._to_nodes(np.full(self.n, mass)) for mass in (dx * (1.0 - n) * GRAINS, dx * n * WATER))
        v, w = (self._to_nodes(own) / self._to_nodes(np.ones(self.n)) for own in (self.v, self.w))
        before_v, before_w = v, w
        pull_w, pull_v = self._forces(n * self.p), self._forces((1.0 - n) * self.p - self.stress)
        pull_v[-1] -= LOAD
        drag = self._to_nodes(dx * self.law.coefficient(n, self.w - self.v))
        v, w = relaxed(v, w, pull_v, pull_w, (m_s, m_w), drag, dt)
        v[0] = w[0] = 0.0
        self.v += 0.5 * ((v - before_v)[:-1] + (v - before_v)[1:])
        self.w += 0.5 * ((w - before_w)[:-1] + (w - before_w)[1:])
        self.p -= dt * K_W / n * ((1.0 - n) * np.diff(v) + n * np.diff(w)) / dx
        self.stress += dt * E_OED * np.diff(v) / dx
        self.time += dt

    def pressure_error(self):
        """Largest |p - p_exact| / p_0 over the cells."""
        depth = 1.0 - (np.arange(self.n) + 0.5) / self.n
        return float(np.abs(self.p / LOAD - terzaghi(depth, C_V * self.time)).max())
