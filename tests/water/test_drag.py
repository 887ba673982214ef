"""Drag between skeleton and water (P10), and a column of two velocities."""

import numpy as np
import pytest

from snowmpm.study.problems.soaked_column import C_V
from snowmpm.study.problems.two_velocity_column import TwoVelocityColumn
from snowmpm.water.drag import Anderson, Darcy, Forchheimer, relaxed

N, G = 0.5, 9.81
LAWS = {"darcy": Darcy(1e-9 / 1.792e-3), "forchheimer": Forchheimer(1e-9 / 1.792e-3, grain_size=1e-3),
        "anderson": Anderson(weight=1650.0 * G, terminal=0.1)}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("dt", [1e-6, 1e-2, 100.0])
def test_steady_speed(law, dt):
    """Water that falls through a held skeleton: C u = n rho_w g, whatever the step."""
    v, w = np.zeros(1), np.zeros(1)
    mass = np.array([N * 1000.0])
    held = np.array([1e30])
    for _ in range(20000 if dt < 1e-3 else 200):
        drag = law.coefficient(N, w - v)
        v, w = relaxed(v, w, np.zeros(1), -mass * G, (held, mass), drag, dt)
    slip = abs(float(w[0] - v[0]))
    if dt > 1e-3:
        assert law.coefficient(N, slip) * slip == pytest.approx(N * 1000.0 * G, rel=1e-3)
    if isinstance(law, Darcy) and not isinstance(law, Forchheimer) and dt > 1e-3:
        assert N * slip == pytest.approx(1e-9 * 1000.0 * G / 1.792e-3, rel=1e-9)


@pytest.mark.parametrize(("porosity", "power", "by_hand"), [
    (0.5, 1.0, 80932.5), (0.4, 1.0, 97119.0), (0.4, 2.0, 242797.5), (0.4, 4.65, 2752867.0)])
def test_andersons_coefficient(porosity, power, by_hand):
    """C = n (1 - n) (rho_s - rho_w) g / (V_T n^m) of grains of 2650 kg/m3 that fall at 0.1 m/s: 1650 x 9.81 = 16186.5
    N/m3, over 0.1 m/s; m = 1 leaves 1 - n of it, m = 2 divides that by n, and 0.4^3.65 = 0.0352792."""
    law = Anderson(weight=1650.0 * G, terminal=0.1, power=power)
    assert law.coefficient(porosity, 0.3) == pytest.approx(by_hand, rel=1e-5)
    # So thin a cloud that grains fall as one alone: weight of the grains (1 - n) (rho_s - rho_w) g at the slip V_T
    assert law.coefficient(1.0 - 1e-9, 0.0) * 0.1 == pytest.approx(1e-9 * 1650.0 * G, rel=1e-6)


@pytest.mark.parametrize("dt", [1e-7, 1e-3, 10.0])
def test_drag_is_exact_and_conserves_momentum(dt):
    """Against the solution of the two equations by a fine Runge-Kutta method, or the end that it goes to."""
    m, drag, pull = (np.array([3.0]), np.array([2.0])), np.array([5e4]), (np.array([7.0]), np.array([-4.0]))
    v, w = relaxed(np.array([1.0]), np.array([-2.0]), *pull, m, drag, dt)
    assert 3.0 * v + 2.0 * w == pytest.approx(3.0 - 4.0 + 3.0 * dt, rel=1e-12)
    rate = 5e4 * (1.0 / 3.0 + 0.5)
    exact = -3.0 * np.exp(-rate * dt) + (-2.0 - 7.0 / 3.0) / rate * (1.0 - np.exp(-rate * dt))
    assert w - v == pytest.approx(exact, rel=1e-10)


def test_two_velocities_consolidate():
    """P1 for T > 0.2: errors below 2 % of the start pressure, by steps of 0.7 of the longest."""
    column = TwoVelocityColumn(10)
    errors = []
    for T in (0.25, 0.5):
        while column.time < T / C_V:
            column.step(0.7 * column.longest_step)
        errors.append(column.pressure_error())
    assert max(errors) < 0.02


def test_stiff_drag_sets_no_step():
    """A permeability of a hundredth: explicit drag would need 2.5e-6 s."""
    column = TwoVelocityColumn(10, Darcy(1e-5 / 9810.0))
    dt = 0.8 * column.longest_step
    assert dt > 10.0 * 1e-5 / (0.4 * 9.81) and column.law.coefficient(0.4, 0.0) * dt / 400.0 > 10.0
    for _ in range(2000):
        column.step(dt)
    assert np.isfinite(column.p).all() and np.abs(column.p).max() < 2e4 and np.abs(column.v).max() < 0.05
