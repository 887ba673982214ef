"""Blocks of particles and the MPM solver around them, small and quick to build."""

import numpy as np

from snowmpm.materials import CohesiveCamClay, Elastic, pack
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import lattice

ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
SNOW = CohesiveCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, cohesion=0.3,
                       hardening=1.0, p0=2e3)


def mpm_block(dim, dx, lower, upper, *, velocity=None, law=ICE, stress=None, precision="f64", gravity=0.0, reach=10.0,
              **options):
    """`MpmSolver` of one box with two particles along each axis of a cell; velocity: of a point (dim,); stress: initial
    Kirchhoff stress (3, 3) [Pa]; gravity: downwards [m/s2]; reach: half the side of the domain [m]."""
    positions, volumes = lattice(lower, upper, dx)
    velocities = np.zeros_like(positions) if velocity is None else np.array([velocity(x) for x in positions])
    pull = np.zeros(dim)
    pull[-1] = -gravity
    population = Population(positions, volumes, 0, velocities)
    if stress is not None:
        population.stress[:], population.elastic[:] = pack(stress, dim), pack(law.h_from_stress(stress), dim)
    return MpmSolver(population, [law], dx=dx, precision=precision, origin=np.full(dim, -reach),
                     lower=np.full(dim, -reach), upper=np.full(dim, reach), gravity=pull, **options)
