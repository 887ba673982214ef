"""Hypoplastic laws against print: coefficients, closed forms, published paths and steady states."""

import functools

import numpy as np
import pytest
from hypoplastic_laws import BASIC, DENSE, DENSITY, OEDOMETER, ROWS, SAND, SLOPE, calibrated, followed, stretching
from parameter_sets import changed
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from snowmpm.materials import StressUpdate, pack, unpack
from snowmpm.materials.critical_state_hypoplastic import CriticalStateHypoplastic
from snowmpm.materials.hypoplastic import RateLaw
from snowmpm.materials.hypoplastic_calibration import lateral_rate, stress_ratio, triaxial_failure, triaxial_rate


@pytest.mark.parametrize("row", ROWS)
def test_calibration_prints_the_published_table(row):
    _, printed, exact = ROWS[row]
    found = calibrated(row).coefficients
    np.testing.assert_allclose(found, printed, atol=0.05 + 1e-9)  # one digit is printed
    np.testing.assert_allclose(found, exact, atol=5.1e-4)  # three digits are given


@pytest.mark.parametrize("law", [SAND, OEDOMETER, SLOPE, DENSE])
def test_coefficients_and_test_are_equivalent(law):
    others = {**DENSITY} if law is DENSE else {}
    again = type(law).from_coefficients(law.coefficients, density=law.density, **others)
    for key in ("youngs_modulus", "poisson_ratio", "friction_angle"):
        assert getattr(again, key) == pytest.approx(getattr(law, key), rel=1e-9, abs=1e-9)
    assert again.dilation_angle == pytest.approx(law.dilation_angle, abs=1e-6)  # of a difference
    np.testing.assert_allclose(again.coefficients, law.coefficients, rtol=1e-7)


def test_only_stiffness_over_pressure_enters_the_law():
    scaled = changed(SAND, youngs_modulus=SAND.youngs_modulus / 20.0, reference_pressure=5e3)
    np.testing.assert_allclose(scaled.coefficients, SAND.coefficients, rtol=1e-12)
    assert scaled.wave_speed() == pytest.approx(SAND.wave_speed() / np.sqrt(20.0), rel=1e-12)


def test_basic_form_is_calibrated_alike():
    np.testing.assert_allclose(DENSE.coefficients, (-66.667, -615.48, -615.48, 654.34), atol=5e-3)  # digits given


@pytest.mark.parametrize(
    ("factor", "angle"), [(1.2, 22.9), (1.1, 26.1), (1.0, 30.0), (0.95, 32.4), (0.9, 35.2), (0.8, 42.9), (0.7, 56.0)]
)
def test_peak_angle_follows_the_density_factor(factor, angle):
    scaled = np.array(DENSE.coefficients) * [1.0, 1.0, factor, factor]
    ratio = triaxial_failure(DENSE.terms, scaled, stress_ratio(80.0))
    assert np.degrees(np.arcsin((ratio - 1.0) / (ratio + 1.0))) == pytest.approx(angle, abs=0.051)  # one digit given


def test_sets_that_jam_are_refused():
    # Table 1 of Wu, Wang, Alipour (2020): triaxial compression stops at R = 1.066 instead of 1.7
    printed = (-1.70, -283.4, -283.4, 2419.3)
    assert triaxial_failure(DENSE.terms, printed, 5.0) == pytest.approx(1.066, abs=5e-4)
    with pytest.raises(ValueError, match=r"jam.*1\.066"):
        CriticalStateHypoplastic.from_coefficients(printed, density=1800.0, **DENSITY)
    with pytest.raises(ValidationError, match="friction_angle 15 is not what this law reaches"):
        changed(DENSE, youngs_modulus=510e3, friction_angle=15.0)
    for angle in (15.0, 20.0, 40.0, 45.0):
        assert changed(SAND, friction_angle=angle).friction_angle == angle
    with pytest.raises(ValidationError, match="least_void_ratio"):
        changed(DENSE, least_void_ratio=0.6)


@pytest.mark.parametrize("steps", [1, 7, 100])
def test_oedometer(steps):
    strain = np.array([0.005, 0.01, 0.02])
    for eps, ratio, K in zip(strain, (5.714, 31.83, 1002.0), (0.620, 0.541, 0.514), strict=True):
        path = followed(OEDOMETER, -1e4 * np.eye(3), stretching(np.diag([-eps, 0.0, 0.0]), steps))
        sigma = path.h[0, -1]
        assert sigma[0] / -1e4 == pytest.approx(ratio, rel=1e-3)  # rounded to four digits, grows like exp(345 ε)
        assert sigma[1] / sigma[0] == pytest.approx(K, abs=1e-3)
        assert path.iterations.min() > 0 and path.iterations.sum() <= 60 + steps


def test_lateral_pressure_at_rest():
    for law, printed in ((OEDOMETER, 0.5109), (SAND, 0.5061), (SLOPE, 0.5052)):
        path = followed(law, -1.0 * np.eye(3), stretching(np.diag([0.0, -0.04, 0.0]), 20))
        sigma = path.h[0, -1]
        assert law.lateral_pressure == pytest.approx(printed, abs=5e-5)
        assert sigma[0] / sigma[1] == pytest.approx(law.lateral_pressure, abs=5e-5)  # some tolerances of a sub-step
        assert RateLaw.lateral_pressure.func(law) == pytest.approx(law.lateral_pressure, rel=1e-12)


def test_tangent_of_the_oedometer():
    K0 = OEDOMETER.lateral_pressure
    start = -1e5 * np.diag([1.0, K0, K0])
    small = 1e-7
    for sign, expected in ((-1.0, 345.4), (1.0, 830.0)):
        after = followed(OEDOMETER, start, stretching(np.diag([sign * small, 0.0, 0.0]), 1)).h[0, 0, 0]
        assert (after + 1e5) / (sign * small) / 1e5 == pytest.approx(expected, rel=1e-3)  # digits given
    state = np.array([OEDOMETER.initial_state()])
    speed = OEDOMETER.wave_speed_at(pack(start)[None], state)[0]
    assert speed == pytest.approx(np.sqrt(830.0 * 1e5 / OEDOMETER.density), rel=1e-3)
    assert OEDOMETER.wave_speed() == pytest.approx(speed, rel=1e-12)


def test_oedometer_unloading():
    path = followed(OEDOMETER, -1e4 * np.eye(3), stretching(np.diag([-0.02, 0.0, 0.0]), 20))
    peak, state = path.h[0, -1], path.state[0, -1]
    back = followed(OEDOMETER, unpack(peak), stretching(np.diag([0.00202, 0.0, 0.0]), 20), state=state).h[0, -1]
    assert back[0] / peak[0] == pytest.approx(0.2, abs=0.002)  # of a strain given to three digits: 0.5 % of 800 × 0.002
    assert back[1] / back[0] == pytest.approx(0.788, abs=0.002)


@pytest.mark.parametrize(
    ("law", "ratios", "volume", "plateau"),
    [
        (SAND, (1.870, 2.431, 2.881, 3.002), (-0.22, -0.32, -0.37, -0.34), 3.0027),
        (BASIC, (1.844, 2.396, 2.866, 2.999), (-0.37, -0.55, -0.68, -0.72), 3.0),
    ],
)
def test_drained_triaxial_compression(law, ratios, volume, plateau):
    # The strains that keep σ₃ come from the rate equation; along them the update must find σ₃ kept and R as published
    def slope(eps, y):
        nu = lateral_rate(law.terms, law.coefficients, y[0])
        axial = triaxial_rate(law.terms, law.coefficients, y[0], nu)[..., 0]
        return [axial, nu]

    eps = np.linspace(0.0, 0.05, 501)
    R, lateral = solve_ivp(slope, (0.0, 0.05), [1.0, 0.0], t_eval=eps, rtol=1e-11, atol=1e-12).y
    steps = np.diff(np.stack([-eps, lateral, lateral], axis=1), axis=0)
    path = followed(law, -1e5 * np.eye(3), np.expm1(steps)[:, :, None] * np.eye(3))
    # A drift of 1e-5 a sub-step at most, and stress differences of the path forget it at failure
    np.testing.assert_allclose(path.h[0, :, 1], -1e5, rtol=1e-4)
    np.testing.assert_allclose(path.h[0, :, 0] / path.h[0, :, 1], R[1:], rtol=1e-4)
    # The published numbers were read one of 3000 samples late
    marks = np.array([0.005, 0.01, 0.02, 0.05 - 0.05 / 3000]) + 0.05 / 3000
    np.testing.assert_allclose(np.interp(marks, eps, R), ratios, atol=6e-4)  # three digits
    np.testing.assert_allclose(100.0 * np.interp(marks, eps, 2.0 * lateral - eps), volume, atol=0.0051)  # two
    assert triaxial_failure(law.terms, law.coefficients, 4.0) == pytest.approx(plateau, abs=5e-5)


def test_failure_cone_is_circular():
    angle = np.linspace(0.0, np.pi / 3.0, 13)
    M = 6.0 * np.sin(np.radians(SAND.friction_angle)) / (3.0 - np.sin(np.radians(SAND.friction_angle)))
    assert abs(M - 1.2010) < 2e-4  # of rounded coefficients
    # s1 at Lode angle θ: q/p = M for principal deviators (2/3) q cos(θ + 2πk/3)
    deviators = np.cos(angle[:, None] + np.array([0.0, -2.0, 2.0]) * np.pi / 3.0) * 2.0 / 3.0
    state = np.tile(SAND.initial_state(), (len(angle), 1))
    for factor, sign in ((0.999, -1.0), (1.001, 1.0)):
        stress = -1e4 * (1.0 + factor * M * deviators)[:, :, None] * np.eye(3)
        assert (np.sign(SAND.failure_function(stress, state)) == sign).all()
    stress = -1e4 * (1.0 + M * deviators)[:, :, None] * np.eye(3)
    np.testing.assert_allclose(SAND.failure_function(stress, state), 0.0, atol=1e-9)
    # the basic form is weaker in extension
    for q_over_p, theta in ((1.200, 0.0), (1.130, np.pi / 3.0)):
        deviator = 2.0 / 3.0 * q_over_p * np.cos(theta + np.array([0.0, -2.0, 2.0]) * np.pi / 3.0)
        value = BASIC.failure_function(-1e4 * np.diag(1.0 + deviator), np.array(BASIC.initial_state()))
        assert abs(value) < 2e-3  # a ratio rounded to three digits


@functools.cache
def sheared(name, shear, steps):
    """Simple shear at constant normal stress: stresses over it and the last rate of dilation."""
    law = {"collapse": SAND, "slope": SLOPE, "basic": BASIC}[name]
    update = StressUpdate(law)
    h, state = pack(-1e5 * np.diag([0.6, 1.0, 0.6]))[None], update.initial_state(1)
    gamma, growth = shear / steps, 0.0
    for _ in range(steps):
        # The dilation that keeps the normal stress, by the secant method from the last one
        tried, missed = [], []
        for attempt in range(12):
            L = np.zeros((3, 3))
            L[0, 1], L[1, 1] = gamma, growth
            result = update(h, state, expm(L)[None] - np.eye(3))
            tried.append(growth)
            missed.append(result.h[0, 1] / -1e5 - 1.0)
            if abs(missed[-1]) < 1e-9:
                break
            if attempt == 0:
                growth += 0.01 * gamma
            else:
                growth -= missed[-1] * (tried[-1] - tried[-2]) / (missed[-1] - missed[-2])
        h, state = result.h, result.state
    assert abs(missed[-1]) < 1e-8
    return h[0] / -1e5, growth / gamma


@pytest.mark.parametrize(
    ("name", "tau", "s11", "s33", "dilation"),
    [
        ("collapse", 0.696, 1.003, 1.008, 0.0102),
        ("slope", 0.690, None, None, -0.0002),
        ("basic", 0.654, 0.971, 0.948, -0.0158),
    ],
)
def test_steady_simple_shear(name, tau, s11, s33, dilation):
    stress, growth = sheared(name, 0.3, 300)
    assert abs(stress[3]) == pytest.approx(tau, abs=6e-4)  # three digits are given
    assert growth == pytest.approx(dilation, abs=1.1e-4)
    if s11 is not None:
        assert stress[0] == pytest.approx(s11, abs=6e-4) and stress[2] == pytest.approx(s33, abs=6e-4)
