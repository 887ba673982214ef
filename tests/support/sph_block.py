"""Blocks of particles and the solver around them, as the tests of SPH use them."""

import numpy as np

from snowmpm.materials import Elastic, pack
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.sph.solver import SphSolver

ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)


def jittered(positions, dx, amount, seed=0):
    """Each moved by at most amount * dx along every axis."""
    return positions + np.random.default_rng(seed).uniform(-amount * dx, amount * dx, positions.shape)


def solver_of(positions, volumes, law=ICE, *, dx, velocity=None, stress=None, precision="f64", gravity=None, lower=None,
              upper=None, scheme=None, **options):
    """`SphSolver` of one body; velocity: of points (n, dim); stress: initial Kirchhoff stress (3, 3) or (n, 3, 3) [Pa];
    scheme: keys of [solver.sph]."""
    dim = positions.shape[1]
    population = Population(positions, volumes, 0, velocity(positions) if velocity else None)
    if stress is not None:
        population.stress[:], population.elastic[:] = pack(stress, dim), pack(law.h_from_stress(stress), dim)
    size = np.ptp(positions, axis=0).max() + 10 * dx
    lower = positions.min(axis=0) - size if lower is None else np.asarray(lower, float)
    upper = positions.max(axis=0) + size if upper is None else np.asarray(upper, float)
    return SphSolver(population, [law], dx=dx, precision=precision, origin=lower, lower=lower, upper=upper,
                     gravity=np.zeros(dim) if gravity is None else np.asarray(gravity, float),
                     scheme=Sph(**(scheme or {})), **options)


def nearest(solver):
    """Distance of each particle to its nearest neighbour [dx]."""
    from scipy.spatial import cKDTree

    positions = solver.particles.positions()
    period = np.where(solver.particles._period > 0, (solver.frame.upper - solver.frame.lower) * solver.dx, 0.0)
    return cKDTree((positions - solver.frame.origin) % np.where(period > 0, period, np.inf),
                   boxsize=period if period.any() else None).query(
        (positions - solver.frame.origin) % np.where(period > 0, period, np.inf), k=2)[0][:, 1] / solver.dx
