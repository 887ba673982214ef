"""Cam-Clay laws along paths with closed-form or ODE reference answers: compression, tension, shear, critical state.

ODE references: integration of the rate equations with DOP853 at 1e-12. Backward Euler is of first order, so tables are
met by extrapolating two step sizes, and its known error at a given number of steps is checked as well.
"""

import numpy as np
import pytest
from parameter_sets import SETS, A, B, C, isotropic, oedometer, simple_shear, undrained
from scipy.optimize import brentq

from snowmpm.materials import MaterialPoint


def drive(law, F, precision="f64"):
    """Path of F in 3-D."""
    path = MaterialPoint(law, precision).drive(F)
    assert (path.iterations >= 0).all()
    return path


def extrapolated(run, steps=400):
    """Limit of vanishing steps from N and 2 N of them, the error of first order removed; run(N) -> tuple of values."""
    coarse, fine = np.array(run(steps)), np.array(run(2 * steps))
    return 2.0 * fine - coarse


ISOTROPIC = [
    (0.01, 25000.000, 0.0119997120, 14000.0362, 8333.3333),
    (0.02, 40000.4933, 0.0159995147, 26500.2478, 16666.6667),
    (0.1, 140036.203, 0.0559852306, 126526.976, 25759.5585),
    (0.5, 643449.829, 0.2546197805, 629738.171, 56097.2990),
    (1.0, 1290692.35, 0.4957227701, 1276404.00, 94118.5173),
]


@pytest.mark.parametrize("steps", [1, 7, 200])
@pytest.mark.parametrize("row", ISOTROPIC, ids=lambda row: f"x={row[0]}")
def test_isotropic_compression_is_exact_for_any_step(row, steps):
    x, p_a, z_a, p_b, p_c = row
    for law, p in ((A, p_a), (B, p_b), (C, p_c)):
        path = drive(law, isotropic(np.linspace(0.0, x, steps + 1)[1:]))
        # Backward Euler is exact here: against the closed form p = K sinh(xi z), x = z − z0 + sinh(xi z)
        K, xi, z0 = law.bulk_modulus, law.hardening, law.initial_zeta
        if K * x < law.p0:
            exact, z = K * x, z0
        else:
            z = brentq(lambda z, K=K, xi=xi, z0=z0: z - z0 + np.sinh(xi * z) - x, 0.0, x + z0, xtol=1e-16, rtol=1e-15)
            exact = K * np.sinh(xi * z)
        assert path.p[-1] == pytest.approx(exact, rel=1e-10)
        assert path.plastic_volumetric_strain[-1] == pytest.approx(z0 - z, rel=1e-10, abs=1e-13)
        assert path.p[-1] == pytest.approx(p, rel=5e-9)  # the printed reference, nine digits
    path = drive(A, isotropic(np.linspace(0.0, x, steps + 1)[1:]))
    assert path.state[-1, 0] == pytest.approx(z_a, abs=1e-10)


def test_isotropic_compression_in_float32():
    for x, p_a, _, p_b, p_c in ISOTROPIC:
        for law, p in ((A, p_a), (B, p_b), (C, p_c)):
            path = drive(law, isotropic(np.linspace(0.0, x, 101)[1:]), "f32")
            assert path.p[-1] == pytest.approx(p, rel=1e-4)  # 100 roundings of strain on a strain of p/K; measured 1e-5


def test_unloading_is_elastic():
    x = np.concatenate([[0.1], 0.1 - np.linspace(0.0, 140036.203 / A.bulk_modulus, 11)[1:]])
    path = drive(A, isotropic(x))
    np.testing.assert_allclose(path.p, path.p[0] - A.bulk_modulus * (x[0] - x), atol=1e-9 * path.p[0])
    assert not path.iterations[1:].any()
    assert abs(path.p[-1]) < 1e-3  # the stress-free strain is known to nine digits


TENSION = {
    "A": [(0.001, -2500.0), (0.005, -7499.870), (0.009, -3213.991), (0.02, 0.0)],
    "C": [(0.009, -5953.595), (0.05, -4896.636), (0.2, -1030.337)],
}


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("steps", [1, 50])
@pytest.mark.parametrize("name", ["A", "C"])
def test_tension_softens_to_nothing(name, steps, precision):
    law = SETS[name]
    for t, p in TENSION[name]:
        path = drive(law, isotropic(-np.linspace(0.0, t, steps + 1)[1:]), precision)
        # Seven digits are printed; float32: roundings of strain, 1e-9 each, times K
        assert path.p[-1] == pytest.approx(p, rel=2e-7 if precision == "f64" else 1e-4, abs=0.0 if p else 1e-12)
        if p == 0.0:
            assert path.p0[-1] == 0.0 and path.q[-1] == 0.0
            assert path.state[-1, 0] == pytest.approx(law.initial_zeta - t, abs=1e-12 if precision == "f64" else 1e-7)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_separated_snow_must_close_before_it_carries(precision):
    # Opened to t = 0.05, then closed: no stress until the dilation beyond z = 0 is taken back, at t = z0
    t = np.concatenate([np.linspace(0.0, 0.05, 21)[1:], np.linspace(0.05, -0.03, 81)[1:]])
    path = drive(A, isotropic(-t), precision)
    closed = A.initial_zeta
    opening = np.arange(len(t)) >= 20
    free = opening & (t > closed + 1e-6)
    assert free.sum() > 30 and not path.p[free].any() and not path.q[free].any()
    for i in np.flatnonzero(opening & (t < closed - 1e-6)):
        # From there on like fresh, cohesionless-born snow: T1.1 with z0 = 0
        x = closed - t[i]
        z = brentq(lambda z, x=x: z + np.sinh(A.hardening * z) - x, 0.0, x, xtol=1e-16)
        exact = A.bulk_modulus * np.sinh(A.hardening * z)
        assert path.p[i] == pytest.approx(exact, rel=1e-9 if precision == "f64" else 1e-3)  # 80 steps of 6e-8 * 0.05


OEDOMETER = [
    ("A", 0.01, 23175.819, 19949.363, 0.012729384, -36475.394, -36841.978),
    ("A", 0.02, 35350.365, 25250.077, 0.017859566, -52183.749, -53237.931),
    ("A", 0.1, 125783.70, 83088.755, 0.061686233, -181176.20, -200230.67),
    ("A", 0.5, 578819.30, 382815.27, 0.280471991, -834029.48, -1375082.1),
    ("B", 0.02, 25529.738, 3519.7717, 0.010988105, -27876.252, -28439.390),
    ("C", 0.02, 14624.789, 10191.924, 0.242427219, -21419.405, -21852.106),
    ("C", 0.2, 30007.492, 11503.256, 0.403967976, -37676.330, -46017.973),
]
OEDOMETER_YIELD = {"A": 8.4239814756e-3, "B": 2.7221476510e-4, "C": 1.4677414197e-2}


@pytest.mark.parametrize(("name", "x", "p", "q", "z", "tau", "cauchy"), OEDOMETER)
def test_oedometric_compression(name, x, p, q, z, tau, cauchy):
    law, x_yield = SETS[name], OEDOMETER_YIELD[name] * (1.0 - 1e-9)  # printed with eleven digits

    def run(n):
        # The elastic part in one exact step, so that the error of the plastic part is smooth in the step
        path = drive(law, oedometer(x_yield + (x - x_yield) * np.linspace(0.0, 1.0, n + 1)))
        assert path.iterations[0] == 0 and path.iterations[1] > 0  # yields where it should
        return path.p[-1], path.q[-1], path.state[-1, 0], path.kirchhoff[-1, 0, 0]

    found = extrapolated(run)
    # Second-order remainder: measured below 2e-5 with 400 steps (set C, where q relaxes fastest)
    np.testing.assert_allclose(found, (p, q, z, tau), rtol=4e-5)
    assert found[3] * np.exp(x) == pytest.approx(cauchy, rel=4e-5)


BACKWARD_EULER = [  # set, steps to x = 0.05, relative errors of tau_ax, p, q
    ("A", 1, 4.1547e-03, -7.685e-03, 3.084e-02),
    ("A", 10, 5.9763e-04, -1.065e-03, 4.344e-03),
    ("A", 100, 6.4632e-05, -1.145e-04, 4.683e-04),
    ("C", 1, -3.5910e-03, -4.499e-02, 1.508e-01),
    ("C", 10, -8.3472e-05, -6.843e-03, 2.512e-02),
    ("C", 100, 2.9309e-07, -6.719e-04, 2.507e-03),
]
OEDOMETER_005 = {"A": (69510.7124853, 46264.64683663)}


@pytest.mark.parametrize(("name", "steps", "tau_error", "p_error", "q_error"), BACKWARD_EULER)
def test_oedometer_has_exactly_the_error_of_backward_euler(name, steps, tau_error, p_error, q_error):
    law = SETS[name]
    path = drive(law, oedometer(np.linspace(0.0, 0.05, steps + 1)[1:]))

    def run(n):
        fine = drive(law, oedometer(np.linspace(OEDOMETER_YIELD[name], 0.05, n + 1)))
        return fine.p[-1], fine.q[-1], fine.kirchhoff[-1, 0, 0]

    limit = extrapolated(run, 2000)
    if name in OEDOMETER_005:
        np.testing.assert_allclose(limit[:2], OEDOMETER_005[name], rtol=1e-6)
    errors = np.array([path.p[-1], path.q[-1], path.kirchhoff[-1, 0, 0]]) / limit - 1.0
    # An independent backward Euler printed these; 2e-6 is what the extrapolated limit is good for
    np.testing.assert_allclose(errors, (p_error, q_error, tau_error), rtol=2e-3, atol=2e-6)
    y = law.yield_of_invariants(path.p, path.q, path.state) / law.p0_at(path.state[:, 0]) ** 2
    assert y.max() < 1e-9  # admissible at the updated p0, whatever the step


CRITICAL = [
    ("A", 6000, 9333.2778, 20554.682, 0.010666401),
    ("A", 27000, 14778.111, 32545.842, 0.016888467),
    ("B", 600, 1199.9999, 599.99994, 0.000960000),
    ("B", 2700, 1900.0002, 950.00012, 0.001520000),
    ("C", 18000, 7372.0898, 12988.446, 0.252730458),
]


@pytest.mark.parametrize(("name", "p_start", "p", "q", "z"), CRITICAL)
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_critical_state(name, p_start, p, q, z, precision):
    law = SETS[name]
    K, beta, xi = law.bulk_modulus, law.beta, law.hardening
    z_c = brentq(
        lambda s: (1.0 - beta) / 2.0 * K * np.sinh(xi * s) - p_start + K * (s - law.initial_zeta), 0.0, 2.0, xtol=1e-16
    )
    p0 = K * np.sinh(xi * z_c)
    closed = ((1.0 - beta) * p0 / 2.0, law.critical_slope * (1.0 + beta) * p0 / (2.0 * np.sqrt(1.0 + 2.0 * beta)), z_c)
    np.testing.assert_allclose(closed, (p, q, z), rtol=1e-7, atol=5e-10)  # eight digits printed, nine places of z
    path = drive(law, undrained(law, p_start, np.linspace(0.0, 1.0, 401)[1:]), precision)
    found = (path.p[-1], path.q[-1], path.state[-1, 0])
    # The approach to critical state is exponential and long over; float32 drifts by the rounding of ln J in 400 steps
    np.testing.assert_allclose(found, closed, rtol=1e-9 if precision == "f64" else 3e-3)


UNDRAINED = [
    ("A", 6000, 6.5e-3, 7855.568, 21564.401),
    ("A", 27000, 3.5601966e-3, 21362.319, 25367.157),
    ("B", 600, 1.7333333e-4, 1199.9997, 599.99998),
    ("B", 2700, 1.3e-4, 1900.0390, 949.99044),
    ("C", 18000, 5.6963146e-3, 16028.926, 9102.8309),
]


@pytest.mark.parametrize(("name", "p_start", "shear_at_yield", "p", "q"), UNDRAINED)
def test_undrained_shear(name, p_start, shear_at_yield, p, q):
    law = SETS[name]
    shear_at_yield *= 1.0 - 1e-7  # printed with eight digits

    def run(n):
        path = drive(law, undrained(law, p_start, np.linspace(shear_at_yield, 0.01, n + 1)))
        assert not path.iterations[:2].any() and path.iterations[2] > 0  # yields where it should
        return path.p[-1], path.q[-1]

    np.testing.assert_allclose(extrapolated(run, 2000), (p, q), rtol=1e-5)  # second-order remainder, measured 2e-6


def test_vertex_start_flows_at_constant_stress():
    # y_p = 0 from the start: schemes that divide by it fail here
    path = drive(B, undrained(B, 1500.0, np.linspace(0.0, 1.0, 101)[1:]))
    np.testing.assert_allclose(path.p, 1500.0, rtol=1e-9)
    np.testing.assert_allclose(path.q[2:], 750.0, rtol=1e-9)
    np.testing.assert_allclose(path.state[:, 0], B.initial_zeta, rtol=1e-9)


SHEAR = [  # law, p_start, gamma at yield, gamma, p, q, tau12, tau11 - tau22, z
    (A, 27000, 6.1664512e-3, 0.01, 25137.644, 18114.023, 10458.009, 102.8, 0.012744655),
    (A, 27000, 6.1664512e-3, 0.05, 15248.422, 32174.465, 18573.929, 546.1, 0.016700343),
    (A, 6000, 1.1258390e-2, 0.02, 8302.988, 21285.070, 12288.495, 209.4, 0.011078517),
    (C, 18000, None, 0.1, 7893.590, 12946.155, 7473.1012, 285.6, 0.252104658),
]


@pytest.mark.parametrize(("law", "p_start", "gamma_yield", "gamma", "p", "q", "tau", "normal", "z"), SHEAR)
def test_simple_shear(law, p_start, gamma_yield, gamma, p, q, tau, normal, z):
    def run(n):
        first = gamma_yield or 0.0
        path = drive(law, simple_shear(law, p_start, np.linspace(first, gamma, n + 1)[0 if gamma_yield else 1 :]))
        stress = path.kirchhoff[-1]
        return path.p[-1], path.q[-1], stress[0, 1], stress[0, 0] - stress[1, 1], path.state[-1, 0]

    found = extrapolated(run, 4000)
    np.testing.assert_allclose(found[[0, 1, 2, 4]], (p, q, tau, z), rtol=3e-5)  # where yield falls inside a step: 1e-5
    assert found[3] == pytest.approx(normal, rel=2e-3)  # printed with four digits


STEADY_SHEAR = [
    (A, 27000, 14778.111, 32545.842, 18787.860, 611.9465),
    (A, 6000, 9333.278, 20554.682, 11866.624, 244.10),
    (C, 18000, 7372.090, 12988.446, 7497.4575, 292.38),
]


@pytest.mark.parametrize(("law", "p_start", "p", "q", "tau", "normal"), STEADY_SHEAR)
def test_simple_shear_stays_steady_to_gamma_10(law, p_start, p, q, tau, normal):
    def run(n):
        path = drive(law, simple_shear(law, p_start, np.linspace(0.0, 10.0, 10 * n + 1)[1:]))
        steady = slice(1 + n, None)  # from gamma = 1; no oscillation, no drift
        np.testing.assert_allclose(path.p[steady], p, rtol=2e-7)  # printed with eight digits
        np.testing.assert_allclose(path.q[steady], q, rtol=2e-7)
        normals = path.kirchhoff[steady, 0, 0] - path.kirchhoff[steady, 1, 1]
        assert np.ptp(normals) < 1e-6 * q
        return path.kirchhoff[-1, 0, 1], normals[-1]

    found = extrapolated(run, 1000)
    assert found[0] == pytest.approx(tau, rel=1e-6)
    assert found[1] == pytest.approx(normal, rel=1e-3)


def test_normal_stress_difference_of_large_increments():
    # p and q are right in 10 steps to gamma = 1, tau11 − tau22 is of first order: an independent code printed these
    for steps, normal in ((5, 4337.9), (10, 2484.9), (20, 1550.0), (100, 799.74), (500, 649.51)):
        path = drive(A, simple_shear(A, 27000, np.linspace(0.0, 1.0, steps + 1)[1:]))
        assert path.kirchhoff[-1, 0, 0] - path.kirchhoff[-1, 1, 1] == pytest.approx(normal, rel=1e-4)
