"""Blocks of particles and the solver around them, small and quick to build."""

import numpy as np
import pytest

from snowmpm.materials import CohesiveCamClay, Elastic, pack
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population

ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
SNOW = CohesiveCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, cohesion=0.3,
                       hardening=1.0, p0=2e3)


def lattice(lower, upper, dx, per_axis=2):
    """Regular particles of a box: positions (n, dim) and volumes (n,)."""
    axes = [np.arange(lo + 0.5 * dx / per_axis, hi, dx / per_axis) for lo, hi in zip(lower, upper, strict=True)]
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    return positions, np.full(len(positions), (dx / per_axis) ** len(axes))


@pytest.fixture(scope="session")
def make_solver():
    """make_solver(dim, dx, lower, upper, velocity=f(x), law=..., stress=(3, 3) [Pa], **solver options) -> MpmSolver of
    one box."""

    def make(dim, dx, lower, upper, *, velocity=None, law=ICE, stress=None, precision="f64", gravity=0.0, reach=10.0,
             **options):
        positions, volumes = lattice(lower, upper, dx)
        velocities = np.zeros_like(positions) if velocity is None else np.array([velocity(x) for x in positions])
        pull = np.zeros(dim)
        pull[-1] = -gravity
        population = Population(positions, volumes, 0, velocities)
        if stress is not None:
            population.stress[:], population.elastic[:] = pack(stress, dim), pack(law.h_from_stress(stress), dim)
        return MpmSolver(population, [law], dx=dx, precision=precision,
                         origin=np.full(dim, -reach), lower=np.full(dim, -reach), upper=np.full(dim, reach),
                         gravity=pull, **options)

    return make
