"""Viscosities of pairs of particles: how fast they take out a motion of a regular lattice."""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import solver_of

STONE = Elastic(density=2700.0, youngs_modulus=1e7, poisson_ratio=0.3)
DX, H, SHARE, STEPS = 0.5, 1.5, 0.2, 40
"""Spacing [m], smoothing length over it, alpha and gamma, and steps."""


def falls(dim):
    """-sum_j V (W' / r) x^2 / (r^2 + 0.01 h^2) over the neighbours that move against their middle one, in spacings, of
    Wendland's C2 kernel with W' / r in proportion to -(1 - r / 2 h)^3, such that -sum_j V (W' / r) x^2 = 1."""
    axis = np.arange(-3.0, 4.0)
    points = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    r2 = (points**2).sum(axis=1)
    part = np.maximum(0.0, 1.0 - np.sqrt(r2) / (2.0 * H)) ** 3 * points[:, 0] ** 2
    against = points.sum(axis=1) % 2.0 == 1.0
    return (part[against] / (r2[against] + 0.01 * H**2)).sum() / part.sum()


@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("name", "pairs"), [("viscosity", 1.0), ("disorder_damping", 2.0)])
def test_a_checkerboard_decays(name, pairs, dim):
    """Neighbours that move against each other along x, on a periodic lattice without stress, whose mean stretching is
    none: Pi_ij = -alpha c mu / rho, mu = 2 h v x / (r^2 + 0.01 h^2), is linear in v, so that

        dv/dt = -l v,    l = 2 alpha c h sum_j V_j |W'_ij| / r x^2 / (r^2 + 0.01 h^2)

    by the damping of disorder (gamma for alpha), and half of that by the artificial viscosity, of pairs that approach
    alone. v falls to exp(-l t), in steps to (1 - l dt)^n. Asked to 0.2 % of l. Seen:
    4e-8."""
    size = [8 * DX] * dim
    positions, volumes = lattice([0.0] * dim, size, DX, 1)
    sign = 1.0 - 2.0 * (np.round(positions / DX - 0.5).sum(axis=1) % 2.0)
    velocities = np.zeros_like(positions)
    velocities[:, 0] = 1e-6 * sign
    scheme = {"kernel": "wendland_c2", "smoothing": H, "viscosity": 0.0, "disorder_damping": 0.0, name: SHARE}
    solver = solver_of(positions, volumes, STONE, dx=DX, velocity=lambda x: velocities, lower=[0.0] * dim, upper=size,
                       sides=[["periodic", "periodic"]] * dim, scheme=scheme)
    rate, dt = pairs * SHARE * STONE.wave_speed() * H / DX * falls(dim), 0.05 * DX / STONE.wave_speed()
    for _ in range(STEPS):
        solver.step(dt)
    velocity = solver.particles.column("velocity")
    left = np.abs(velocity[:, 0]) / 1e-6
    found = (1.0 - left ** (1.0 / STEPS)) / dt
    np.testing.assert_allclose(found, rate, rtol=2e-3)
    assert np.abs(velocity[:, 1:]).max() < 1e-12
