"""Free flight: parabolas to the rounding of the sums, and a cohesionless cloud that stays as it is (M3)."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.materials import DruckerPrager, Elastic, ModifiedCamClay
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import AFLIP, APIC, CUBIC, QUADRATIC, free_solver

DX, DT, STEPS = 0.1, 1e-3, 500
GRAVITY = np.array([0.7, -0.4, -9.81])
START = np.array([6.0, 1.5, 4.0])
LAWS = {
    "elastic": Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3),
    "sand": DruckerPrager(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3, friction_angle=30.0, cohesion=0.0),
    "loose snow": ModifiedCamClay(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2,
                                  hardening=1.0, p0=0.0),
}


def fall(t, dt, gravity):
    """Way of a body under gravity after t in symplectic Euler steps, g t (t + dt) / 2."""
    return 0.5 * gravity * t * (t + dt)


CASES = [(scheme, "sand") for scheme in QUADRATIC + CUBIC] + [(APIC, "elastic"), (APIC, "loose snow")]
QUICK = (APIC, AFLIP, replace(APIC, kernel="cubic"))
"""Schemes of the quick tests."""


@pytest.mark.parametrize(("scheme", "law"), [
    pytest.param(scheme, law, id=f"{scheme}-{law}", marks=[pytest.mark.slow] * (scheme not in QUICK))
    for scheme, law in CASES])
def test_a_cloud_flies_a_parabola_and_does_not_spread(scheme, law):
    """Points at random: a fifth of the cells have none, some have many."""
    positions = np.random.default_rng(5).uniform(-0.5, 0.5, (160, 2))
    gravity, velocity = GRAVITY[[0, 2]], START[[0, 2]]
    solver = free_solver(positions, np.full(160, 0.25 * DX**2), LAWS[law], scheme, DX, gravity=gravity, reach=6.0,
                         velocities=np.tile(velocity, (160, 1)))
    states = ParticleStates(solver)
    for _ in range(STEPS):
        solver.step(DT)
    t = STEPS * DT
    flown = states.positions() - states.reference
    expected = velocity * t + fall(t, DT, gravity)
    # 500 sums in f64 of places up to 8 cells, 0.8 m * 1e-16 each, and of speeds up to 6 m/s, 0.5 s * 6e-16 each
    np.testing.assert_allclose(flown, np.broadcast_to(expected, flown.shape), rtol=0, atol=2e-12)
    assert np.abs(solver.particles.column("stress")).max() < 1e-5  # Pa of 1e6: strains of round-off
    assert solver.particles.sorts >= 2


@pytest.mark.parametrize("scheme", [APIC, AFLIP], ids=str)
def test_a_cube_flies_a_parabola_in_space(scheme):
    positions = np.random.default_rng(6).uniform(-0.2, 0.2, (256, 3))
    solver = free_solver(positions, np.full(256, 0.125 * DX**3), LAWS["sand"], scheme, DX, gravity=GRAVITY, reach=6.0,
                         velocities=np.tile(START, (256, 1)))
    states = ParticleStates(solver)
    for _ in range(STEPS):
        solver.step(DT)
    t = STEPS * DT
    flown = states.positions() - states.reference
    expected = START * t + fall(t, DT, GRAVITY)
    np.testing.assert_allclose(flown, np.broadcast_to(expected, flown.shape), rtol=0, atol=2e-12)
    assert np.abs(states.column("velocity") - START - t * GRAVITY).max() < 1e-11


@pytest.mark.parametrize("dt", [4e-3, 2e-3, 1e-3])
def test_the_error_in_time_is_of_first_order(dt):
    """y(t) = y0 - g t (t + dt) / 2: started at rest at t = 0 and not half a step before, it is off by g t dt / 2."""
    solver = free_solver(np.zeros((1, 2)), np.array([0.25 * DX**2]), LAWS["sand"], APIC, DX,
                         gravity=np.array([0.0, -9.81]), reach=6.0)
    for _ in range(round(0.4 / dt)):
        solver.step(dt)
    error = solver.particles.positions()[0, 1] + 0.5 * 9.81 * 0.4**2
    assert error == pytest.approx(-0.5 * 9.81 * 0.4 * dt, rel=1e-9)
