"""μ(I) and φ(I): against an own integration of the rates, Bagnold's pressure, and one packing from loose and dense."""

import numpy as np
import pytest
from frictional_laws import LAWS
from parameter_sets import changed
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from snowmpm.materials import MaterialPoint, MuPhiI, StressUpdate, measure, pack

LAW = changed(LAWS["mu(I), phi(I)"], youngs_modulus=1e7)
PRESSURE, RATE = 1e3, 20.0


def packed(fraction):
    """The law with this solid fraction at the start."""
    return changed(LAW, density=fraction * LAW.grain_density)


def friction(inertial, fraction):
    """μ(I) + K₃ (φ - φ_eq(I)), as printed."""
    return 0.38 + 0.26 * inertial / (inertial + 0.279) + 4.09 * (fraction - 0.6 + 0.1 * inertial)


def integrated(law, strains):
    """p, q, φ after plane shear d = (1, -1, 0) strains [-] at RATE: the rates of the law, by SciPy.

    dq = 3G (dε_s - dε_s^p), dp = K β dγ^p, dφ = -φ β dγ^p, and dγ^p from q = √3 (μ(I) + β) p.
    """
    K, G, time = law.bulk_modulus, law.shear_modulus, law.grain_diameter * np.sqrt(law.grain_density)

    def rates(strain, y):
        p, q, fraction = y
        ratio, slow = q / (np.sqrt(3.0) * p), 0.0
        if ratio > friction(0.0, fraction):
            slow = brentq(lambda I: friction(I, fraction) - ratio, 0.0, 10.0, xtol=1e-14) * np.sqrt(p) / time / RATE
        beta = 4.09 * (fraction - 0.6 + 0.1 * slow * RATE * time / np.sqrt(p))
        return [K * beta * slow, 3.0 * G * (2.0 / np.sqrt(3.0) - slow / np.sqrt(3.0)), -fraction * beta * slow]

    found = solve_ivp(rates, (0.0, strains[-1]), [PRESSURE, 0.0, law.solid_fraction], "LSODA", strains, rtol=1e-9,
                      atol=[1e-6, 1e-6, 1e-12], max_step=1e-4)
    return found.y


def driven(law, steps, strain):
    """p, q, φ of the law itself on that path."""
    update, rise = StressUpdate(law), strain / steps
    stretch = np.diag([np.expm1(rise), np.expm1(-rise), 0.0])
    start = pack(law.h_from_stress(-PRESSURE * np.eye(3)))[None]
    found = update.integrate(start, update.initial_state(1), np.tile(stretch, (1, steps, 1, 1)), rise / RATE)
    stress = found.stress[0]
    p = -stress[:, :3].mean(axis=1)
    q = np.sqrt(1.5 * ((stress[:, :3] + p[:, None]) ** 2).sum(axis=1))
    return np.array([p, q, found.state[0, :, 3]])


@pytest.mark.parametrize("fraction", [0.62, 0.59, 0.57])
def test_shear_at_constant_volume_as_integrated(fraction):
    law, strain, steps = packed(fraction), 0.02, 10_000
    expected = integrated(law, np.linspace(0.0, strain, steps + 1)[1:])
    found, halved = driven(law, steps, strain), driven(law, 2 * steps, strain)[:, 1::2]
    scale = np.abs(expected).max(axis=1, keepdims=True)
    coarse, fine = (np.abs(y - expected).max(axis=1) / scale[:, 0] for y in (found, halved))
    assert (fine < 5e-3).all() and (fine[:2] < 0.6 * coarse[:2] + 1e-6).all()  # first order


@pytest.mark.parametrize("rate", [50.0, 100.0])
def test_at_constant_volume_the_pressure_is_bagnolds(rate):
    """φ cannot change, so I does: p = ρ_s (γ̇ d / I)² with φ_eq(I) = φ, and the friction is μ(I)."""
    law = packed(0.57)
    found = measure(law, "simple_shear_constant_volume", pressure=1e3, strain=3.0, steps=6000, rate=rate)
    p, q, fraction = found.path.p[-1], found.path.q[-1], found.path.state[-1, 3]
    inertial = (0.6 - fraction) / 0.1
    assert inertial == pytest.approx(0.3, rel=0.05)
    assert p == pytest.approx(law.grain_density * (rate * law.grain_diameter / inertial) ** 2, rel=0.02)
    assert q / p == pytest.approx(np.sqrt(3.0) * friction(inertial, 0.6 - 0.1 * inertial), rel=0.005)


def test_loose_and_dense_grains_reach_one_packing():
    """Sheared under a constant mean pressure: φ(I) and μ(I) at the end, the dense ones stronger on the way."""
    ends = []
    for fraction in (0.55, 0.62):
        law, h, state = packed(fraction), None, None
        update, rise, peak = StressUpdate(law), 5e-4, 0.0
        h, state, lost = pack(law.h_from_stress(-PRESSURE * np.eye(3)))[None], update.initial_state(1), 0.0
        for _ in range(6000):
            step = np.diag([rise, -rise, 0.0]) + lost / 3.0 * np.eye(3)
            made = update(h, state, np.expm1(np.diag(step))[None, :, None] * np.eye(3), rise / RATE)
            h, state, p = made.h, made.state, -made.stress[0, :3].mean()
            lost = (p - PRESSURE) / law.bulk_modulus  # a servo: the volume that brings the pressure back
            q = np.sqrt(1.5 * ((made.stress[0, :3] + p) ** 2).sum())
            peak = max(peak, q / max(p, 0.5 * PRESSURE))
        inertial = 2.0 * RATE * law.grain_diameter * np.sqrt(law.grain_density / p)
        assert p == pytest.approx(PRESSURE, rel=1e-3)
        assert state[0, 3] == pytest.approx(0.6 - 0.1 * inertial, abs=2e-4)
        assert q / p == pytest.approx(np.sqrt(3.0) * friction(inertial, 0.6 - 0.1 * inertial), rel=2e-3)
        assert (peak > 1.05 * q / p) == (fraction > 0.6)
        ends.append((state[0, 3], q / p))
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-3)


def test_separated_grains_keep_their_packing():
    t = np.concatenate([[-1e-4], np.linspace(0.0, 0.05, 6)[1:], np.linspace(0.05, -2e-4, 13)[1:]])
    path = MaterialPoint(LAW).drive(np.exp(t / 3.0)[:, None, None] * np.eye(3))
    np.testing.assert_allclose(path.p, np.maximum(-LAW.bulk_modulus * t, 0.0), atol=1e-13 * LAW.bulk_modulus)
    np.testing.assert_allclose(path.state[:, 1], np.maximum(t, 0.0), atol=1e-14)
    assert (path.state[:, 3] == path.state[0, 3]).all()


@pytest.mark.parametrize("values", [{"densest_fraction": 0.45}, {"density": 2500.0}, {"density": 1000.0},
                                    {"dilatancy": 0.0}, {"limit_friction": 0.3}])
def test_impossible_grains_are_refused(values):
    with pytest.raises(ValidationError):
        MuPhiI.model_validate({**LAW.model_dump(), **values})
