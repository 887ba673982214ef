"""What a step of MPM conserves beyond what every method must (`tests/contract`)."""

import numpy as np
import pytest

from tests.support.mpm_block import SNOW


def angular_momentum(solver):
    """Of particles with their affine part: sum m (x cross v) + m D skew(C), D = dx^2 / 4 (2-D, about the origin)."""
    x, v, mass = solver.particles.positions(), solver.particles.column("velocity"), solver.particles.masses()
    c = solver.particles.column("affine")
    spin = 0.25 * solver.dx**2 * (c[:, 2] - c[:, 1])
    return float(mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0] + spin))


@pytest.mark.parametrize("dim", [2, 3])
def test_free_fall_is_symplectic_euler(make_solver, dim):
    solver = make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.3), gravity=9.81)
    start = solver.particles.positions()[:, -1].mean()
    dt, n = 1e-3, 300
    for _ in range(n):
        solver.step(dt)
    fallen = start - solver.particles.positions()[:, -1].mean()
    assert fallen == pytest.approx(0.5 * 9.81 * (n * dt) * (n + 1) * dt, rel=1e-11)  # g dt^2 n (n + 1) / 2, exactly


def test_linear_and_angular_momentum_of_a_spinning_plastic_block(make_solver):
    solver = make_solver(2, 0.05, [-0.2, -0.3], [0.2, 0.3], law=SNOW,
                         velocity=lambda x: np.array([-8.0 * x[1] + 0.5, 8.0 * x[0] + 2.0 * np.sin(9 * x[0])]))
    before, spin = solver.particles.masses() @ solver.particles.column("velocity"), angular_momentum(solver)
    for _ in range(300):
        solver.step(solver.stable_dt()[0])
    after = solver.particles.masses() @ solver.particles.column("velocity")
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-11 * np.abs(before).max())
    assert angular_momentum(solver) == pytest.approx(spin, rel=1e-10)
    assert solver.plastic_work > 0.0 and solver.unconverged == 0


def test_rotation_does_not_swell(make_solver):
    """The first-order update would give ln J = omega^2 dt t (numerics, section 1)."""
    omega = 2.0
    solver = make_solver(2, 0.05, [-0.2, -0.2], [0.2, 0.2], velocity=lambda x: omega * np.array([-x[1], x[0]]))
    dt = 5e-4
    for _ in range(2000):
        solver.step(dt)
    growth = np.log(solver.particles.column("volume_ratio")).mean()
    centrifugal = 300.0 * omega**2 * 0.2**2 / 1e6  # strain of the spinning block, O(rho omega^2 R^2 / E)
    assert abs(growth) < centrifugal
    assert centrifugal < 0.03 * omega**2 * dt * 1.0  # so the test would see 3 % of the first-order drift
