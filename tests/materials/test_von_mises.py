"""Von Mises plasticity: closed forms of radial paths, simple shear, and the rate equations in a turning frame."""

import numpy as np
import pytest
from frictional_laws import LAWS
from parameter_sets import diagonal, simple_shear
from scipy.integrate import solve_ivp
from scipy.linalg import logm

from snowmpm.materials import MaterialPoint

PERFECT, HARDENING = LAWS["von Mises"], LAWS["von Mises hardening"]


@pytest.mark.parametrize(("steps", "precision"), [(1, "f64"), (50, "f64"), (1, "f32"), (50, "f32")])
@pytest.mark.parametrize("law", [PERFECT, HARDENING], ids=["perfect", "hardening"])
def test_radial_path(law, steps, precision):
    # 3G (ε_s − κ) = σ_y + H κ
    shear, volume = 0.04, -0.002
    t = np.linspace(0.0, 1.0, steps + 1)[1:]
    path = MaterialPoint(law, precision).drive(
        diagonal((volume / 3 + shear / 2) * t, (volume / 3 + shear / 2) * t, (volume / 3 - shear) * t)
    )
    G, H = law.shear_modulus, law.hardening_modulus
    plastic = (3.0 * G * shear - law.yield_stress) / (3.0 * G + H)
    rtol = 1e-11 if precision == "f64" else 2e-5  # 50 steps, each to 6e-8 of 1 on a strain of 0.04
    assert path.state[-1, 0] == pytest.approx(plastic, rel=rtol)
    assert path.q[-1] == pytest.approx(law.yield_stress + H * plastic, rel=rtol)
    assert path.p[-1] == pytest.approx(-law.bulk_modulus * volume, rel=1e-9 if precision == "f64" else 2e-3)
    # One step does the work of its last stress; many that of ∫ (σ_y + H κ) dκ, to first order
    work = law.yield_stress * plastic + 0.5 * H * plastic**2 * (1.0 + 1.0 / steps)
    assert path.dissipation[-1] == pytest.approx(work, rel=0.01 if steps > 1 else 10 * rtol)


def test_tension_has_no_limit():
    path = MaterialPoint(PERFECT).drive(diagonal(*(np.array([0.1, 0.5]),) * 3))
    np.testing.assert_allclose(path.p, -PERFECT.bulk_modulus * np.array([0.3, 1.5]), rtol=1e-12)
    assert not path.iterations.any()


def test_simple_shear_does_not_oscillate():
    # To γ = 10: shear stress σ_y/√3 but for the elastic lag of the axes, constant once it flows
    path = MaterialPoint(PERFECT).drive(simple_shear(PERFECT, 1e4, np.linspace(0.0, 10.0, 2001)[1:]))
    late = path.kirchhoff[400:, 0, 1]
    lag = PERFECT.yield_stress / PERFECT.shear_modulus
    np.testing.assert_allclose(late, PERFECT.yield_stress / np.sqrt(3.0), rtol=lag)
    assert np.ptp(late) < 1e-6 * late.mean()
    np.testing.assert_allclose(path.p, 1e4, rtol=1e-8)  # 2000 steps of round-off of stretches of 10


def rates(law, end):
    """τ and κ from db_e/dt = l b_e + b_e lᵀ − 2 γ̇ N b_e alone: simple shear from rest to γ = `end`."""
    G, H, K = law.shear_modulus, law.hardening_modulus, law.bulk_modulus
    l = np.zeros((3, 3))
    l[0, 1] = 1.0

    def kirchhoff(b):
        eps = 0.5 * logm(b).real
        return 2.0 * G * (eps - np.trace(eps) / 3.0 * np.eye(3)) + K * np.trace(eps) * np.eye(3)

    def mises(t, y):
        tau = kirchhoff(y[:9].reshape(3, 3))
        s = tau - np.trace(tau) / 3.0 * np.eye(3)
        return np.sqrt(1.5 * (s * s).sum()) - (law.yield_stress + H * y[9])

    def elastic(t, y):
        b = y[:9].reshape(3, 3)
        return np.append((l @ b + b @ l.T).ravel(), 0.0)

    def plastic(t, y):
        b = y[:9].reshape(3, 3)
        tau = kirchhoff(b)
        s = tau - np.trace(tau) / 3.0 * np.eye(3)
        N = 1.5 * s / np.sqrt(1.5 * (s * s).sum())
        # Isotropy: dq/dt = 2G N : d for any symmetric d, as N and b_e share axes
        rate = 2.0 * G * (N * l).sum() / (3.0 * G + H)
        return np.append((l @ b + b @ l.T - rate * (N @ b + b @ N)).ravel(), rate)

    mises.terminal = True
    first = solve_ivp(elastic, (0.0, end), np.append(np.eye(3).ravel(), 0.0), rtol=1e-11, atol=1e-13, events=mises)
    then = solve_ivp(plastic, (first.t[-1], end), first.y[:, -1], rtol=1e-11, atol=1e-13, method="DOP853")
    return kirchhoff(then.y[:9, -1].reshape(3, 3)), then.y[9, -1]


def test_simple_shear_follows_the_rate_equations():
    law, end = HARDENING, 0.4
    tau, plastic = rates(law, end)
    errors = []
    for steps in (50, 100, 200, 400):
        path = MaterialPoint(law).drive(simple_shear(law, 0.0, np.linspace(0.0, end, steps + 1)[1:]))
        errors.append([abs(path.kirchhoff[-1, 0, 1] - tau[0, 1]), abs(path.state[-1, 0] - plastic) * law.shear_modulus])
    order = -np.diff(np.log(np.array(errors)), axis=0) / np.log(2.0)
    # Backward Euler: first order, and the finest within 0.2 % of the yield stress
    np.testing.assert_allclose(order[-1], 1.0, atol=0.15)
    assert max(errors[-1]) < 2e-3 * law.yield_stress
