"""A column of dry sand collapses on a rough floor in plane strain (G1): how far it runs.

Experiments of Lube et al. (2005), doi:10.1103/PhysRevE.72.041301, of half-width d0 and height h0 = a d0:
d / d0 = 1 + 1.2 a for a < 2.3. The law itself is uncertain by a tenth (seen between laboratories), and what a continuum
with the friction of the card makes of it is not known any better: an error below that says little.

The library's column_collapse_2d, half of a column of a = 1 against its plane of symmetry, by either method, built and
put under its own weight as any scene is.
"""

import numpy as np

from snowmpm.materials import DruckerPrager

HALF_WIDTH, HEIGHT = 0.2, 0.2
SAND = DruckerPrager(density=1850.0, youngs_modulus=2.016e6, poisson_ratio=0.3, friction_angle=37.0,
                     cone="plane_strain")
"""Of the scene."""
RUN_OUT = HALF_WIDTH * (1.0 + 1.2 * HEIGHT / HALF_WIDTH)
"""d [m]."""
DURATION = 0.7
"""Of the collapse [s]: nothing moves after 3.3 sqrt(h0 / g) = 0.47 s."""
TOE = 0.05
"""Depth at the front over the height of the column: grains a layer or two thin run ahead of it."""


def run_out(scheme, cells, per_axis=2):
    """Where the pile is TOE of the column's height deep, from its middle [m]; cells: in the height of the column."""
    dx = HEIGHT / cells
    simulation = scheme.simulation("column_collapse_2d", dx, per_axis, {"end_time": DURATION})
    while simulation.time < DURATION:
        simulation.step()
    x = simulation.particles["position"][:, 0]
    depth = np.bincount(np.floor(x / dx).astype(int)) * HEIGHT * HALF_WIDTH / (len(x) * dx)
    last = np.flatnonzero(depth > TOE * HEIGHT).max()
    ahead = depth[last + 1] if last + 1 < len(depth) else 0.0
    return dx * (last + 0.5 + (depth[last] - TOE * HEIGHT) / (depth[last] - ahead))
