"""What a step must conserve, whatever the material does."""

import numpy as np
import pytest

from snowmpm.compiler import runtime

from .conftest import SNOW


def angular_momentum(solver):
    """Of particles with their affine part: sum m (x cross v) + m D skew(C), D = dx^2 / 4 (2-D, about the origin)."""
    x, v, mass = solver.particles.positions(), solver.particles.column("velocity"), solver.particles.masses()
    c = solver.particles.column("affine")
    spin = 0.25 * solver.dx**2 * (c[:, 2] - c[:, 1])
    return float(mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0] + spin))


@pytest.mark.parametrize("dim", [2, 3])
def test_rigid_translation_is_exact(make_solver, dim):
    v = np.array([1.0, 0.3, 0.7])[:dim]
    solver = make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.6), velocity=lambda x: v)
    start, order = solver.particles.positions(), np.argsort(solver.particles.labels()[:, 1])
    for _ in range(400):
        solver.step(1e-3)  # below the elastic limit dx / c = 1.5e-3 s
    moved = solver.particles.positions()[np.argsort(solver.particles.labels()[:, 1])] - start[order]
    np.testing.assert_allclose(moved, np.broadcast_to(0.4 * v, moved.shape), rtol=0, atol=1e-12)  # 200 sums of f64
    assert np.abs(solver.particles.column("stress")).max() < 1e-6  # Pa: a round-off strain of 1e-12 times E = 1e6 Pa
    assert solver.particles.sorts >= 2  # four cells travelled: the blocks were left more than once


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


def test_open_sides_count_what_leaves(make_solver):
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.8, 0.4], velocity=lambda x: np.array([3.0, 0.0]), reach=1.0)
    mass, momentum = solver.particles.masses().sum(), solver.particles.masses() @ solver.particles.column("velocity")
    for _ in range(120):
        solver.step(1e-3)
    with runtime.precision("f64"):
        solver.sort()
    assert 0 < solver.particles.removed["count"] < 128
    assert solver.particles.masses().sum() + solver.particles.removed["mass"] == pytest.approx(mass, rel=1e-13)
    total = solver.particles.masses() @ solver.particles.column("velocity") + solver.particles.removed["momentum"]
    np.testing.assert_allclose(total, momentum, rtol=0, atol=1e-10 * momentum[0])
    assert solver.particles.positions()[:, 0].max() < 1.0


def test_wall_takes_the_momentum_it_reports(make_solver):
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.6, 0.6], velocity=lambda x: np.array([0.0, -5.0]), gravity=9.81,
                         precision="f32", sides=[["open", "open"], ["stick", "open"]], reach=0.8)
    before = solver.particles.masses() @ solver.particles.column("velocity")
    for _ in range(400):
        solver.step(solver.stable_dt()[0])
    after = solver.particles.masses() @ solver.particles.column("velocity")
    gained = solver.weight_impulse + solver.impulse + (before - after)
    assert np.linalg.norm(gained) < 1e-5 * np.linalg.norm(solver.impulse)  # float32 sums of 400 steps
    assert solver.impulse[1] > 0.0
