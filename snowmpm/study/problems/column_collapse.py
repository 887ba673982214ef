"""A column of dry sand collapses on a rough floor in plane strain (G1): how far it runs.

Experiments of Lube et al. (2005), doi:10.1103/PhysRevE.72.041301, of half-width d0 and height h0 = a d0:
d / d0 = 1 + 1.2 a for a < 2.3. The law itself is uncertain by a tenth (seen between laboratories), and what a continuum
with the friction of the card makes of it is not known any better: an error below that says little.

Half of a column of a = 1 against its plane of symmetry, in the pressure of its weight at the start.
"""

import numpy as np

from snowmpm.materials import DruckerPrager
from snowmpm.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice

G, HALF_WIDTH, HEIGHT = 9.81, 0.2, 0.2
SAND = DruckerPrager(density=1379.0, youngs_modulus=1e6, poisson_ratio=0.3, friction_angle=37.0, cone="plane_strain")
RUN_OUT = HALF_WIDTH * (1.0 + 1.2 * HEIGHT / HALF_WIDTH)
"""d [m]."""
DURATION = 0.7
"""Of the collapse [s]: nothing moves after 3.3 sqrt(h0 / g) = 0.47 s."""


def run_out(scheme, cells, per_axis=2):
    """Farthest point of the pile from its middle [m]; cells: in the height of the column.

    Grains beyond a gap of a cell do not belong to the pile.
    """
    dx = HEIGHT / cells
    positions, volumes = lattice([0.0, 0.0], [HALF_WIDTH, HEIGHT], dx, per_axis)
    pressure = SAND.density * G * (HEIGHT - positions[:, 1])
    strain = -pressure / (3.0 * SAND.bulk_modulus)
    isotropic = np.array([1.0, 1.0, 1.0, 0.0])
    population = Population(positions, volumes, 0, elastic=np.expm1(2.0 * strain)[:, None] * isotropic,
                            stress=-pressure[:, None] * isotropic)
    solver = scheme.solver(population, [SAND], dx=dx, origin=np.zeros(2), lower=np.zeros(2),
                           upper=np.array([5.0 * HALF_WIDTH, 2.0 * HEIGHT]), gravity=np.array([0.0, -G]),
                           sides=[["symmetric", "open"], ["stick", "open"]])
    ParticleStates(solver).set(volume_ratio=np.exp(3.0 * strain))
    while solver.time < DURATION:
        solver.step(solver.stable_dt()[0])
    x = np.sort(solver.particles.positions()[:, 0])
    gaps = np.flatnonzero(np.diff(x) > dx)
    return float(x[gaps[0]] if len(gaps) else x[-1]) + 0.5 * dx / per_axis
