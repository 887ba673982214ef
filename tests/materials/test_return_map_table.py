"""One step of the return map from given trial states: reference table, corners of the ellipse, limits.

Reference values: backward Euler solved by nested bracketing, independent of the project's return map.
"""

import numpy as np
import pytest
from parameter_sets import SETS, W1, W2, A, B, C, changed
from return_maps import returned, violation
from scipy.optimize import brentq

TABLE = [
    ("A", 60000, 0, 45000.8549, 0, 0.017999370052),
    ("A", 1.5e6, 0, 770859.748, 0, 0.303655812988),
    ("A", -24000, 0, -2571.12721, 0, 0.003428162904),
    ("A", -6e5, 0, 0, 0, -0.228000287981),
    ("A", 10500, 3e5, 10500, 23124.1554, 0.011999712019),
    ("A", -1500, 9e4, 6086.23108, 17150.0187, 0.008965219588),
    ("A", 24000, 9e4, 16535.1556, 28592.0509, 0.014985649768),
    ("A", 15000, 3e8, 11666.9443, 25693.4983, 0.013332934312),
    ("A", 3e7, 3e7, 22113852.8, 18065237.0, 3.166458577),
    ("A", -30000, 30000, 0, 0, -2.87981e-7),
    ("B", -1500, 0, 0, 0, 0.000599999712),
    ("B", 2400, 9000, 1966.68543, 849.175905, 0.001373325541),
    ("C", -20000, 20000, -3812.65488, 5829.91585, 0.220552151821),
    ("C", 2e7, 2e7, 2858552.97, 1216749.41, 20.8097134),
]


@pytest.mark.parametrize(("name", "p_trial", "q_trial", "p", "q", "z"), TABLE)
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_reference_table(name, p_trial, q_trial, p, q, z, precision):
    law = SETS[name]
    p_new, q_new, state, iterations, yielded = returned(law, p_trial, q_trial, precision=precision)
    # Nine digits are printed; float32 knows z to 1e-7 and p to that times the trial stress
    digits = 5e-9 if precision == "f64" else 2e-6
    lost = 0.0 if precision == "f64" else 2e-7 * (abs(p_trial) + q_trial)
    assert p_new[0] == pytest.approx(p, rel=digits, abs=1e-9 * law.p0 + lost)
    assert q_new[0] == pytest.approx(q, rel=digits, abs=1e-9 * law.p0 + lost)
    assert state[0, 0] == pytest.approx(z, rel=digits, abs=1e-12 + lost / law.bulk_modulus)
    assert yielded[0] and 0 <= iterations[0] <= 25
    assert violation(law, p_new, q_new, state)[0] < (1e-9 if precision == "f64" else 1e-5)


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("law", [A, B, C, W1], ids=["A", "B", "C", "W1"])
def test_inside_is_elastic_without_iterations(law, precision):
    # On every ray from the centre, up to the surface less the yield tolerance
    angle = np.linspace(0.0, np.pi, 181)
    reach = 1.0 - (1e-5 if precision == "f32" else 1e-10)
    p = law.p0 * ((1.0 - law.beta) + reach * (1.0 + law.beta) * np.cos(angle)) / 2.0
    q = reach * law.critical_slope * law.p0 * (1.0 + law.beta) * np.sin(angle) / (2.0 * np.sqrt(1.0 + 2.0 * law.beta))
    p_new, q_new, state, iterations, yielded = returned(law, p, q, precision=precision)
    assert not yielded.any() and not iterations.any()
    np.testing.assert_array_equal(p_new, p.astype(np.float32) if precision == "f32" else p)
    np.testing.assert_array_equal(q_new, q)
    np.testing.assert_allclose(state - law.initial_state(), 0.0, atol=1e-7 if precision == "f32" else 0.0)


def test_tips_return_along_the_axis():
    # q = 0: p must be the tip of the new ellipse, p = p0 in compression, p = -beta p0 in tension
    for law in (A, B, C):
        p, q, state, _, _ = returned(law, np.array([1.001, 1.5, 40.0]) * law.p0, 0.0)
        np.testing.assert_allclose(p, law.p0_at(state[:, 0]), rtol=1e-12)
        assert not q.any()
    for law in (A, C):
        p, q, state, _, _ = returned(law, np.array([-0.301, -0.5]) * law.p0, 0.0)
        np.testing.assert_allclose(p, -law.beta * law.p0_at(state[:, 0]), rtol=1e-12)
        assert not q.any()


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("law", [A, B, C], ids="ABC")
def test_vertex_flows_at_constant_volume(law, precision):
    # y_p = 0: schemes that divide by it fail. Neighbours on both sides must join smoothly.
    vertex = (1.0 - law.beta) / 2.0 * law.p0_at(law.initial_state()[0])
    p, q, state, iterations, _ = returned(law, vertex, np.array([1.01, 2.0, 1e4]) * law.p0, precision=precision)
    tolerance = 1e-6 if precision == "f32" else 1e-12
    np.testing.assert_allclose(p, vertex, rtol=tolerance)
    top = law.critical_slope * (1.0 + law.beta) * law.p0 / (2.0 * np.sqrt(1.0 + 2.0 * law.beta))
    np.testing.assert_allclose(q, top, rtol=tolerance)
    np.testing.assert_allclose(state[:, 0], law.initial_state()[0], rtol=tolerance)
    assert (iterations > 0).all()
    near = vertex + law.p0 * np.array([-1e-6, 1e-6])
    p, q, _, iterations, _ = returned(law, near, 3.0 * law.p0, precision=precision)
    np.testing.assert_allclose(p, vertex, atol=2e-6 * law.p0)
    np.testing.assert_allclose(q, top, rtol=2e-6)
    assert (iterations > 0).all()


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_shrinking_to_a_point(precision):
    # p0 -> 0: just before, at and after the trial state that dilates down to z = 0
    K = A.bulk_modulus
    z0 = A.initial_state()[0]
    for remaining in (1e-3, 1e-6, 1e-9, 0.0, -1e-9, -1e-3):
        p, q, state, iterations, _ = returned(A, -K * (z0 - remaining * z0), 0.5 * A.p0, precision=precision)
        assert np.isfinite([p, q]).all() and iterations[0] >= 0
        assert abs(p[0]) <= 1.1 * abs(remaining) * A.p0 + (2e-3 if precision == "f32" else 0.0)
        if remaining < (-1e-6 if precision == "f32" else 0.0):  # float32 cannot tell 1e-9 from 0 here
            assert p[0] == q[0] == 0.0
            assert state[0, 0] == pytest.approx(remaining * z0, abs=1e-9 if precision == "f32" else 1e-15)
    # And from tiny sizes outwards
    for z in (1e-12, 1e-30):
        p, q, state, iterations, _ = returned(A, 1e3, 1e3, state=[z], precision=precision)
        assert iterations[0] > 0 and violation(A, p, q, state)[0] < 1e-9 and p[0] > 0.0


def test_no_initial_strength():
    law = changed(A, p0=0.0)
    p, q, state, iterations, _ = returned(law, np.array([0.0, 1e4, -1e4, 0.0]), np.array([0.0, 1e4, 1e4, 1e4]))
    assert (p[[0, 2, 3]] == 0.0).all() and (q[[0, 2, 3]] == 0.0).all()
    assert p[1] > 0.0 and state[1, 0] > 0.0  # compacts and gains strength
    assert (iterations >= 0).all()
    assert (violation(law, p, q, state) < 1e-9).all()


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_perfect_plasticity(precision):
    # xi = 0: p0 stays; the exact return is the closest point in the metric of the flow rule, checked by its equations
    law = changed(A, hardening=0.0)
    p_trial, q_trial = np.array([6e4, -5e4, 2e4, 1e6, 1e4]), np.array([0.0, 0.0, 9e4, 3e6, 5e4])
    p, q, state, iterations, yielded = returned(law, p_trial, q_trial, precision=precision)
    assert yielded.all() and (iterations > 0).all()
    y = law.yield_of_invariants(p, q, state) / law.p0**2
    np.testing.assert_allclose(y, 0.0, atol=1e-5 if precision == "f32" else 1e-12)
    assert p[0] == pytest.approx(law.p0) and p[1] == pytest.approx(-law.beta * law.p0)
    multiplier = (p_trial - p) / (law.bulk_modulus * law.critical_slope**2 * (2.0 * p - (1.0 - law.beta) * law.p0))
    expected = q_trial / (1.0 + 6.0 * law.shear_modulus * multiplier * (1.0 + 2.0 * law.beta))
    np.testing.assert_allclose(q, expected, rtol=1e-3 if precision == "f32" else 1e-10)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_sinh_out_of_range(precision):
    # exp overflows in float32 at 88, in float64 at 709: from far trial states, and from a state already there
    law = changed(A, hardening=200.0)
    p_trial, q_trial = np.array([3e7, 3e7, 1e4]), np.array([0.0, 3e7, 3e7])
    p, q, _, iterations, _ = returned(law, p_trial, q_trial, precision=precision)
    assert np.isfinite([p, q]).all() and (iterations > 0).all() and (iterations <= 25).all()
    p, q, _, iterations, yielded = returned(law, 1e7, 1e7, state=[10.0], precision=precision)
    assert not yielded.any() and iterations[0] == 0 and p[0] == 1e7


def test_very_soft_hardening_in_float32():
    # Li V, xi = 0.002: z0 = 0.6 against plastic strains of 1e-4; p0 must follow all the same
    law = changed(A, youngs_modulus=3e6, critical_slope=0.7, cohesion=0.2, hardening=0.002, p0=3e3)
    p_trial = law.p0 * np.linspace(1.01, 1.5, 50)
    exact = returned(law, p_trial, 500.0)
    single = returned(law, p_trial, 500.0, precision="f32")
    np.testing.assert_allclose(single[0], exact[0], rtol=3e-6)
    np.testing.assert_allclose(single[2], exact[2], rtol=2e-7)


def test_uniqueness_lost_still_gives_an_answer():
    # xi beta cosh > 1: strain-controlled softening has several branches; only admissible and softening is asked
    law = changed(A, hardening=10.0)
    q_trial, p_trial = (a.ravel() for a in np.meshgrid(np.geomspace(1.0, 1e6, 60), np.linspace(-1e6, 0.0, 201)))
    p, q, state, iterations, yielded = returned(law, p_trial, q_trial)
    assert np.isfinite([p, q]).all() and (iterations >= 0).all() and (iterations <= 25).all()
    assert violation(law, p, q, state).max() < 1e-9
    dry = p_trial < 0.0
    assert (law.p0_at(state[dry, 0]) <= law.p0 * (1.0 + 1e-12)).all()
    work = p * (p_trial - p) / law.bulk_modulus + q * (q_trial - q) / (3.0 * law.shear_modulus)
    assert work.min() > -1e-9 * law.p0**2 / law.bulk_modulus
    assert yielded.mean() > 0.5


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_far_trial_whose_corrected_step_vanishes(precision):
    # Newton's step and its correction cancel at the trial state: that is no convergence (found among 10^6 trials)
    law = changed(A, critical_slope=0.5, cohesion=1.0, hardening=0.1)
    p, q, state, _, _ = returned(law, -7.791e4, 4781.0, state=[0.199726], precision=precision)
    assert violation(law, p, q, state)[0] < 1e-5
    assert p[0] == pytest.approx(-46802.9, rel=1e-4) and q[0] == pytest.approx(396.944, rel=1e-2)  # float64, tight


@pytest.mark.parametrize("law", [W1, W2], ids=["W1", "W2"])
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_weak_layer_collapses_within_a_step(law, precision):
    # Isotropic, closed form: x = z + sinh(xi (z0 - alpha z)) before collapse, x = z + sinh(xi (z - z0/alpha)) after
    z0, collapse = law.initial_zeta, law.initial_zeta / law.softening
    K, xi, alpha = law.bulk_modulus, law.hardening, law.softening
    for x in np.array([0.3, 0.9, 0.999, 1.001, 1.5, 20.0]) * collapse:
        if x < law.p0 / K:
            continue
        if x < collapse:
            z = brentq(lambda z, x=x: z + np.sinh(xi * (z0 - alpha * z)) - x, 0.0, collapse, xtol=1e-15)
        else:
            z = brentq(lambda z, x=x: z + np.sinh(xi * (z - collapse)) - x, collapse, x, xtol=1e-15)
        p, q, state, iterations, _ = returned(law, K * x, 0.0, precision=precision)
        assert p[0] == pytest.approx(K * (x - z), rel=1e-9 if precision == "f64" else 1e-4, abs=3e-7 * K * x)
        assert q[0] == 0.0 and iterations[0] > 0
        assert state[0, 1] == (x > collapse)
        expected = z0 - alpha * z if x < collapse else z - collapse
        assert state[0, 0] == pytest.approx(expected, rel=1e-9 if precision == "f64" else 1e-4, abs=2e-7 * x)


def test_weak_layer_torn_in_tension_has_collapsed():
    for p_trial, torn in ((-0.5 * W1.p0, False), (-2.0 * W1.bulk_modulus * W1.initial_zeta / W1.softening, True)):
        p, q, state, _, _ = returned(W1, p_trial, 100.0)
        assert bool(state[0, 1]) is torn
        assert bool(p[0] == 0.0 and q[0] == 0.0) is torn
        assert violation(W1, p, q, state)[0] < 1e-9
    # Opened by 1 % in volume: closes first, then hardens without cohesion
    p, _, state, _, _ = returned(W1, W1.bulk_modulus * np.array([0.005, 0.02]), 0.0, state=[-0.01, 1.0])
    assert p[0] == 0.0 and state[0, 0] == pytest.approx(-0.005)
    assert p[1] == pytest.approx(W1.p0_at(state[1, 0])) and 0.0 < state[1, 0] < 0.01
