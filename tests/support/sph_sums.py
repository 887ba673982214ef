"""Sums of SPH over particles in and around a unit square or cube."""

import numpy as np

from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import jittered, solver_of

SCHEME = {"kernel": "cubic_spline", "smoothing": 1.3}


def stage(n, jitter, dim=2, scheme=SCHEME, rows=0):
    """Sorted solver of n^dim particles in the unit square and `rows` more around it; -> it, positions, inner (n,)."""
    dx = 1.0 / n
    positions, volumes = lattice([-rows * dx] * dim, [1.0 + rows * dx] * dim, dx, 1)
    solver = solver_of(jittered(positions, dx, jitter), volumes, dx=dx, scheme=scheme)
    solver.sort()
    x = solver.particles.positions()
    return solver, x, ((x > 0.0) & (x < 1.0)).all(axis=1)


def rms(error):
    return float(np.sqrt((error**2).mean()))
