"""The velocity gradient of the step itself: M18a, in the plane and in space."""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import jittered, solver_of

SOFT = Elastic(density=300.0, youngs_modulus=1e-15, poisson_ratio=0.3)


@pytest.mark.parametrize("dim", [2, 3])
def test_linear_velocity_on_jittered_particles(dim):
    dx, G = 0.1, np.random.default_rng(3).normal(size=(dim, dim))
    positions, volumes = lattice([0.0] * dim, [1.2] * dim, dx, 1)
    solver = solver_of(jittered(positions, dx, 0.2), volumes, SOFT, dx=dx, velocity=lambda x: x @ G.T,
                       scheme={"viscosity": 0.0, "disorder_damping": 0.0, "gradient": "corrected"})
    solver.step(1e-6)
    L = solver.particles.column("affine").reshape(-1, dim, dim)
    assert np.abs(L - G).max() < 1e-12


def test_linear_velocity_next_to_mirrors():
    """Images make a field that keeps the particles between their mirrors linear beyond them."""
    dx = 0.1
    positions, volumes = lattice([0.0, 0.0], [1.2, 1.2], dx, 1)
    solver = solver_of(jittered(positions, dx, 0.2), volumes, SOFT, dx=dx, lower=[0.0, 0.0], upper=[5.0, 5.0],
                       velocity=lambda x: np.stack([0.3 * x[:, 0], -0.2 * x[:, 1]], axis=1),
                       sides=[["slip", "open"], ["symmetric", "open"]],
                       scheme={"viscosity": 0.0, "disorder_damping": 0.0, "gradient": "corrected"})
    solver.step(1e-6)
    L = solver.particles.column("affine").reshape(-1, 2, 2)
    assert np.abs(L - np.diag([0.3, -0.2])).max() < 1e-12
