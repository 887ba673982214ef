"""Laws of ground friction: what must hold for every one, and each against its formula or an independent solution."""

import numpy as np
import pytest
from ground_stress import EXAMPLES, parts, shear
from pydantic import ValidationError
from scipy.optimize import brentq

from snowmpm.ground import Bingham, Coulomb, FrictionalViscous, MuI, SamosAt, Voellmy
from snowmpm.ground.bingham import bingham_share

RNG = np.random.default_rng(3)
SIGMA = np.concatenate([[0.0, 0.0, 2e3], 10.0 ** RNG.uniform(-3.0, 5.0, 400)])
DEPTH = np.concatenate([[1.0, 1e-3, 1.0], 10.0 ** RNG.uniform(-3.0, 1.5, 400)])
SPEED = np.concatenate([[0.0, 0.0, 0.0], 10.0 ** RNG.uniform(-7.0, 2.0, 400)])


@pytest.fixture(params=EXAMPLES, ids=str)
def law(request):
    return EXAMPLES[request.param]


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_stress_is_finite_and_never_drives(law, precision):
    dry, rate = parts(law, SIGMA, SPEED, DEPTH, precision=precision)
    assert np.isfinite(dry).all() and np.isfinite(rate).all()
    tau = dry + rate * SPEED
    # samos_at takes its fall with the speed off the dry part, whose last digit stays
    assert dry.min() >= 0.0 and (tau >= -(1e-6 if precision == "f32" else 1e-14) * dry).all()
    if not law.WEAKENS:
        assert rate.min() >= 0.0


def test_dry_part_does_not_depend_on_the_speed(law):
    still, _ = parts(law, SIGMA, 0.0, DEPTH)
    moving, _ = parts(law, SIGMA, SPEED, DEPTH)
    np.testing.assert_array_equal(still, moving)


def test_stress_is_continuous_and_grows_with_the_speed(law):
    speed = np.concatenate([[0.0], np.geomspace(1e-8, 80.0, 4000)])
    for sigma, depth in ((0.0, 0.5), (50.0, 0.02), (3e3, 1.0)):
        tau = shear(law, sigma, speed, depth)
        rises = np.diff(tau)
        assert np.abs(rises).max() <= 0.02 * tau.max() + 1e-12  # of steps of 0.6 %, tau at most with the square: 1.2 %
        if not law.WEAKENS:
            assert rises.min() >= -1e-12 * tau.max()


def test_single_precision_is_double_to_round_off(law):
    states = [a.astype(np.float32).astype(float) for a in (SIGMA, SPEED, DEPTH)]
    single, double = (shear(law, *states, precision=precision) for precision in ("f32", "f64"))
    # exp, pow and log amplify a round-off of 6e-8 by up to their argument, here below 20
    np.testing.assert_allclose(single, double, rtol=5e-6, atol=1e-9)


def test_more_weight_is_more_friction(law):
    sigma = np.geomspace(1e-3, 1e5, 500)
    dry, _ = parts(law, sigma, 0.0, 1.0)
    assert np.diff(dry).min() >= 0.0


# ---- each law -------------------------------------------------------------------------------------------------------


def test_coulomb():
    np.testing.assert_allclose(shear(Coulomb(mu=0.4), SIGMA, SPEED, DEPTH), 0.4 * SIGMA, rtol=1e-14)
    np.testing.assert_allclose(shear(Coulomb(mu=0.4, tau0=30.0), SIGMA, SPEED, DEPTH), 30.0 + 0.4 * SIGMA, rtol=1e-14)


def test_cohesion_has_the_form_of_ramms_and_its_limits():
    mu, C = 0.2, 150.0
    extra = shear(Coulomb(mu=mu, cohesion=C), SIGMA, 0.0, 1.0) - shear(Coulomb(mu=mu), SIGMA, 0.0, 1.0)
    expected = (1.0 - mu) * C - (1.0 - mu) * C * np.exp(-SIGMA / C)
    # the difference of stresses of up to 1e5 Pa has lost digits
    np.testing.assert_allclose(extra, expected, rtol=1e-12, atol=1e-10)
    huge = shear(Coulomb(mu=mu, cohesion=1e6), 10.0, 0.0, 1.0, precision="f32")
    assert huge == pytest.approx(10.0 * (1.0 - 0.8 * 5e-6), rel=3e-7)  # (1 - mu) sigma (1 - sigma/2C), no cancellation


def test_voellmy():
    law = Voellmy(mu=0.155, xi=1750.0, tau0=70.0)
    expected = 70.0 + 0.155 * SIGMA + 300.0 * 9.81 * SPEED**2 / 1750.0
    np.testing.assert_allclose(shear(law, SIGMA, SPEED, DEPTH), expected, rtol=1e-14)
    rough = Voellmy(mu=0.155, xi=1e12)
    np.testing.assert_allclose(shear(rough, 1e3, SPEED, 1.0), shear(Coulomb(mu=0.155), 1e3, SPEED, 1.0), rtol=1e-6)


def test_samos_at():
    law = SamosAt(mu=0.155, tau0=10.0)
    sigma, speed, depth = SIGMA[3:], SPEED[3:], DEPTH[3:]
    Rs = 300.0 * speed**2 / sigma
    profile = np.log(np.maximum(depth / 0.05, 1.0)) / 0.43 + 4.13
    expected = 10.0 + 0.155 * (1.0 + 0.222 / (0.222 + Rs)) * sigma + 300.0 * speed**2 / profile**2
    np.testing.assert_allclose(shear(law, sigma, speed, depth), expected, rtol=1e-12)
    assert parts(law, 1e3, 0.0, 1.0)[0] == pytest.approx(10.0 + 2.0 * 0.155 * 1e3)


def test_samos_at_weakens_no_faster_than_its_docstring_says():
    law = SamosAt(mu=0.155)
    _, rate = parts(law, SIGMA[3:, None], np.geomspace(1e-3, 50.0, 2000), 1e-3, density=200.0)
    bound = 0.5 * 0.155 * np.sqrt(200.0 * SIGMA[3:, None] / 0.222)
    assert (rate >= -bound).all() and (rate.min(axis=1) < -0.5 * bound[:, 0]).any()


def test_frictional_viscous():
    law = FrictionalViscous(mu=0.2, viscosity=5.0, exponent=2.0)
    expected = 0.2 * SIGMA + 6.25 * 5.0 * (SPEED / DEPTH) ** 2
    np.testing.assert_allclose(shear(law, SIGMA, SPEED, DEPTH), expected, rtol=1e-12)
    viscous = FrictionalViscous(mu=0.0, viscosity=5.0, exponent=1.0)
    np.testing.assert_allclose(parts(viscous, 0.0, SPEED, DEPTH)[1], 15.0 / DEPTH, rtol=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 3.0])
def test_frictional_viscous_is_the_mean_of_its_profile(exponent):
    # tau - s falls linearly from the ground to the surface: eta (dv/dz)^m = (tau - s)(1 - z/h), integrated twice
    eta, h, excess = 3.0, 0.7, 250.0
    z, step = np.linspace(0.0, h, 40001, retstep=True)
    rate = (excess * (1.0 - z / h) / eta) ** (1.0 / exponent)
    profile = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * step)])
    mean = 0.5 * (profile[1:] + profile[:-1]).sum() * step / h
    law = FrictionalViscous(mu=0.0, viscosity=eta, exponent=exponent)
    assert shear(law, 0.0, mean, h) == pytest.approx(excess, rel=1e-5)  # of the trapezoidal rule at z = h


@pytest.mark.parametrize(("a", "xi"), [(0.1, 0.828829), (1.0, 0.539189), (5.0, 0.252000), (20.0, 0.086985)])
def test_bingham_has_the_roots_of_d11(a, xi):
    assert bingham_share(a) == pytest.approx(xi, abs=1e-6)
    # of D11: depth 2 m, viscosity 30 Pa s, tau_y 100 Pa
    speed = a * 2.0 * 100.0 / (6.0 * 30.0)
    assert 100.0 / shear(Bingham(yield_stress=100.0, viscosity=30.0), 0.0, speed, 2.0) == pytest.approx(xi, abs=1e-6)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_bingham_solves_its_cubic(precision):
    a = np.geomspace(1e-5, 1e9, 300)
    # the same cubic in e = 1 - xi where xi is near 1
    precise = {"xtol": 1e-300, "rtol": 1e-15}
    excess = np.array([brentq(lambda e, a=a: e * e * (3.0 - e) - a * (1.0 - e), 0.0, 1.0, **precise) if a < 1.0 else
                       1.0 - brentq(lambda x, a=a: x**3 - (3.0 + a) * x + 2.0, 0.0, 1.0, **precise) for a in a])
    xi = np.array([1.0 - e if a < 1.0 else brentq(lambda x, a=a: x**3 - (3.0 + a) * x + 2.0, 0.0, 1.0, **precise)
                   for a, e in zip(a, excess, strict=True)])
    dry, rate = parts(Bingham(yield_stress=100.0, viscosity=1.0), 0.0, a * 100.0 / 6.0, 1.0, precision=precision)
    tolerance = 1e-12 if precision == "f64" else 3e-6  # some tens of round-offs
    np.testing.assert_allclose(rate * (a * 100.0 / 6.0), 100.0 * excess / xi, rtol=tolerance)
    np.testing.assert_allclose(bingham_share(a[a > 1.0]), xi[a > 1.0], rtol=1e-12)
    assert (dry == 100.0).all()


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_bingham_at_its_limits(precision):
    speed, depth = np.geomspace(1e-5, 50.0, 50), 0.4
    fluid = shear(Bingham(yield_stress=0.0, viscosity=20.0), 0.0, speed, depth, precision=precision)
    np.testing.assert_allclose(fluid, 3.0 * 20.0 * speed / depth, rtol=1e-6)
    rigid = shear(Bingham(yield_stress=80.0, viscosity=0.0), 0.0, speed, depth, precision=precision)
    np.testing.assert_allclose(rigid, 80.0, rtol=1e-7)
    slow = parts(Bingham(yield_stress=80.0, viscosity=20.0), 0.0, np.array([0.0, 1e-7, 1e-6]), depth,
                 precision=precision)[1]
    assert slow[0] == slow[1] == slow[2]
    a = 6.0 * 20.0 * 1e-6 / (depth * 80.0)
    assert slow[0] * 1e-6 == pytest.approx(80.0 * np.sqrt(a / 3.0), rel=5e-3)  # the next term of the series is √(a/3)


def test_mu_i_and_its_limits():
    law = MuI(mu_s=0.38, mu_2=0.64, I_0=0.3, grain_diameter=0.05, grain_density=400.0)
    sigma, speed, depth = SIGMA[3:], SPEED[3:], DEPTH[3:]
    inertial = 2.5 * speed / depth * 0.05 * np.sqrt(400.0 / sigma)
    mu = 0.38 + (0.64 - 0.38) / (1.0 + 0.3 / inertial)
    np.testing.assert_allclose(shear(law, sigma, speed, depth), mu * sigma, rtol=1e-12)
    np.testing.assert_allclose(shear(law, 1e3, np.array([0.0, 1e-9, 1e9]), 1.0), [380.0, 380.0, 640.0], rtol=1e-6)
    same = MuI(mu_s=0.4, mu_2=0.4, grain_diameter=0.05, grain_density=400.0)
    np.testing.assert_array_equal(shear(same, sigma, speed, depth), shear(Coulomb(mu=0.4), sigma, speed, depth))


def test_mu_i_holds_a_bagnold_flow_on_its_slope():
    # on a slope of tan = mu(I): I is uniform over the depth, v(z) = (2/3) I/d √(phi g cos) (h^1.5 - (h - z)^1.5)
    phi, h, d, slope, I0 = 0.6, 0.8, 0.02, np.radians(26.0), 0.279
    law = MuI(mu_s=0.38, mu_2=0.64, I_0=I0, grain_diameter=d, grain_density=1000.0)
    I = I0 / ((0.64 - 0.38) / (np.tan(slope) - 0.38) - 1.0)
    mean = 0.4 * I / d * np.sqrt(phi * 9.81 * np.cos(slope)) * h**1.5
    sigma = phi * 1000.0 * 9.81 * h * np.cos(slope)
    assert shear(law, sigma, mean, h) == pytest.approx(sigma * np.tan(slope), rel=1e-12)


# ---- what is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("make", "key"), [
    (lambda: Coulomb(mu=-0.1), "mu"), (lambda: Coulomb(mu=11.0), "mu"), (lambda: Coulomb(mu=float("nan")), "mu"),
    (lambda: Coulomb(mu="0.3"), "mu"), (lambda: Coulomb(mu=0.3, xi=1.0), "xi"), (lambda: Voellmy(mu=0.3), "xi"),
    (lambda: Voellmy(mu=0.3, xi=0.0), "xi"), (lambda: SamosAt(mu=0.2, Rs0=0.0), "Rs0"),
    (lambda: FrictionalViscous(mu=0.1, viscosity=1.0, exponent=0.5), "exponent"),
    (lambda: Coulomb(mu=0.3, tau0=-1.0), "tau0"), (lambda: Coulomb(mu=0.3, cohesion=2e6), "cohesion"),
    (lambda: MuI(mu_s=0.5, mu_2=0.4, grain_diameter=0.1, grain_density=400.0), "mu_2"),
])
def test_numbers_out_of_range_are_refused(make, key):
    with pytest.raises(ValidationError, match=key):
        make()
