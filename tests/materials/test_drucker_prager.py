"""Drucker-Prager: closed forms, the reference integrator for softening, apex, separation, and cone matching in use."""

import numpy as np
import pytest
from frictional_laws import LAWS, SOIL
from parameter_sets import changed, diagonal, oedometer, simple_shear
from pydantic import ValidationError
from round_off import representable
from scipy.integrate import solve_ivp

from snowmpm.materials import DruckerPrager, MaterialPoint, StressUpdate, pack, unpack
from snowmpm.materials.cone import CONES, cone_friction_angle

SAND, DILATING, COHESIVE, SOFTENING = (LAWS[f"DP {name}"] for name in ("sand", "dilating", "cohesive", "softening"))


def isotropic_volume(t):
    """F with ln J = t in equal parts."""
    return diagonal(*(np.asarray(t, float) / 3.0,) * 3)


# --- Closed forms --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("steps", "precision"), [(1, "f64"), (100, "f64"), (1, "f32")])
def test_oedometer_k0(steps, precision):
    # p = K x, q = min(2 G x, alpha p): K0 = (1 − α/3)/(1 + 2α/3) once it yields; α = .586711 gives .578252
    alpha, x = 0.586711, 0.04
    angle = cone_friction_angle(alpha, "triaxial_compression")
    law = changed(SAND, friction_angle=float(angle))
    assert law.alpha == pytest.approx(alpha, rel=1e-14)
    path = MaterialPoint(law, precision).drive(oedometer(np.linspace(0.0, x, steps + 1)[1:]))
    axial, lateral = path.kirchhoff[-1, 0, 0], path.kirchhoff[-1, 1, 1]
    rtol = 1e-12 if precision == "f64" else 1e-5  # strains of 0.04 to 6e-8 and 100 of it in ln
    assert lateral / axial == pytest.approx((1.0 - alpha / 3.0) / (1.0 + 2.0 * alpha / 3.0), rel=rtol)
    assert lateral / axial == pytest.approx(0.578252, abs=5e-7 if precision == "f64" else 1e-5)
    assert path.p[-1] == pytest.approx(law.bulk_modulus * x, rel=rtol)


def test_oedometer_stays_elastic_below_a_slope():
    # α > 3 (1 − 2ν)/(1 + ν) = .923077 never yields: K0 = ν/(1 − ν)
    for alpha, yields in ((0.9230, True), (0.9231, False)):
        law = changed(SAND, friction_angle=float(cone_friction_angle(alpha, "triaxial_compression")))
        path = MaterialPoint(law).drive(oedometer(np.linspace(0.0, 0.04, 5)[1:]))
        assert path.iterations.any() == yields
        if not yields:
            assert path.kirchhoff[-1, 1, 1] / path.kirchhoff[-1, 0, 0] == pytest.approx(0.3 / 0.7, rel=1e-12)


@pytest.mark.parametrize("cone", CONES)
def test_mean_pressure_does_not_change_without_dilation(cone):
    law = changed(SAND, youngs_modulus=1e8, cone=cone)
    path = MaterialPoint(law).drive(simple_shear(law, 1e5, np.linspace(0.0, 5.0, 300)[1:]))
    assert path.state[-1, 0] > 2.0
    np.testing.assert_allclose(path.p, 1e5, rtol=1e-9)  # 300 steps of round-off of stretches of 5
    assert path.q[-1] == pytest.approx(law.alpha * 1e5, rel=1e-9)
    # τ12 = q/√3 (1 − O(q/μ)): the axes lag by elastic shear
    assert path.kirchhoff[-1, 0, 1] == pytest.approx(law.alpha * 1e5 / np.sqrt(3.0), rel=path.q[-1] / law.shear_modulus)


def test_dilation_presses_confined_sand():
    # Constant-volume shear with ψ: p = p_i + K α_ψ ε_s, q = α p and 3G (ε_s,total − ε_s) = q
    law, p_start, shear = DILATING, 2e4, np.linspace(0.0, 0.02, 30)[1:]
    volume = -p_start / law.bulk_modulus / 3.0
    path = MaterialPoint(law).drive(diagonal(volume + shear / 2.0, volume + shear / 2.0, volume - shear))
    stiffness = 3.0 * law.shear_modulus + law.bulk_modulus * law.alpha * law.alpha_psi
    plastic = np.maximum(3.0 * law.shear_modulus * shear - law.alpha * p_start, 0.0) / stiffness
    np.testing.assert_allclose(path.state[:, 0], plastic, atol=1e-14)
    np.testing.assert_allclose(path.p, p_start + law.bulk_modulus * law.alpha_psi * plastic, rtol=1e-11)
    np.testing.assert_allclose(path.plastic_volumetric_strain, law.alpha_psi * plastic, atol=1e-14)


@pytest.mark.parametrize("psi", [0.0, 12.0, 30.0])
def test_plane_strain_cone_fails_at_coulombs_angle(psi):
    # Biaxial loading in plane strain at the dilation rate of ψ, so that stresses can become steady
    law = changed(DILATING, friction_angle=30.0, dilation_angle=psi, cohesion=5e3)
    s = np.sin(np.radians(psi))
    start = law.h_from_stress(-5e4 * np.eye(3))
    e = 0.4 / 4000
    A = np.diag(np.expm1([-e, e * (1.0 + s) / (1.0 - s)]))
    update = StressUpdate(law, 2)
    stress = unpack(update.integrate(pack(start, 2)[None], update.initial_state(1), np.tile(A, (1, 4000, 1, 1))).stress)
    plane = np.sort(np.diagonal(stress[0, -1]))[[0, -1]]
    mean, radius = -plane.mean(), (plane[1] - plane[0]) / 2.0
    # The third stress has settled after plastic strains of many times the elastic ones
    assert radius / (mean + 5e3 / np.tan(np.radians(30.0))) == pytest.approx(np.sin(np.radians(30.0)), rel=1e-6)


# --- Softening -----------------------------------------------------------------------------------------------------


def softened(law, x, shear):
    """p, q, κ from the rate equations alone, along a straight path of volume loss x and triaxial shear, from rest."""
    K, G, alpha, psi = law.bulk_modulus, law.shear_modulus, law.alpha, law.alpha_psi
    c0, cr, strain = law.cohesion, law.residual_cohesion, law.softening_strain
    per_cohesion = alpha / np.tan(np.radians(law.friction_angle))

    def k(kappa):
        return per_cohesion * (cr + (c0 - cr) * np.exp(-kappa / strain))

    onset = k(0.0) / (3.0 * G * shear - alpha * K * x)
    assert 0.0 < onset < 1.0

    def rate(t, y):
        slope = -per_cohesion * (c0 - cr) / strain * np.exp(-y[0] / strain)
        flow = (3.0 * G * shear - alpha * K * x) / (3.0 * G + K * alpha * psi + slope)
        return [flow]

    kappa = solve_ivp(rate, (onset, 1.0), [0.0], method="DOP853", rtol=1e-12, atol=1e-15).y[0, -1]
    return K * x + K * psi * kappa, 3.0 * G * (shear - kappa), kappa


@pytest.mark.parametrize("residual", [0.0, 3e3])
def test_softening_follows_the_rate_equations(residual):
    law = changed(SOFTENING, residual_cohesion=residual)
    x, shear = 0.004, 0.03
    p, q, kappa = softened(law, x, shear)
    side = -x / 3.0 + shear / 2.0
    for steps in (1, 7):
        t = np.linspace(0.0, 1.0, steps + 1)[1:]
        path = MaterialPoint(law).drive(diagonal(*(t * end for end in (side, side, -x / 3.0 - shear))))
        # Exact for a straight path in any number of steps, but for the last millionth of cohesion, which is cut
        np.testing.assert_allclose((path.p[-1], path.q[-1], path.state[-1, 0]), (p, q, kappa), rtol=1e-6)
        assert path.dissipation[-1] > 0.0


def test_softening_in_tension_breaks_all_bonds():
    # Opening x after the peak: p = −T s(x), elastic part p/K; then a gap
    law = changed(SOFTENING, dilation_angle=0.0)
    apex = law.tensile_apex
    opening = np.array([0.0, 0.002, 0.01, 0.05])
    strength = apex * np.exp(-opening / law.softening_strain)
    total = opening - (-strength) / law.bulk_modulus
    path = MaterialPoint(law).drive(isotropic_volume(total))
    np.testing.assert_allclose(path.p, -strength, rtol=1e-3, atol=2e-6 * apex)
    np.testing.assert_allclose(path.state[1:, 0], opening[1:], rtol=1e-5)
    assert not path.state[:, 1].any()
    loss = law.softening_strain * np.log(1e6)
    far = MaterialPoint(law).drive(isotropic_volume(np.array([0.3, 0.3 - 0.1])))
    np.testing.assert_allclose(far.state[:, 1], [0.3 - loss, 0.2 - loss], rtol=1e-12)
    assert not far.kirchhoff.any() and far.state[0, 0] == pytest.approx(loss, rel=1e-12)
    np.testing.assert_allclose(law.outputs(far.state)["damage"], 1.0)
    # From here on it is sand: severed by a cut it is the same material
    assert law.severed_state() == pytest.approx((loss, 0.0))
    update = StressUpdate(law)
    cut = update(np.zeros((1, 6)), [law.severed_state()], np.eye(3)[None] * 1e-3)
    assert not cut.stress.any() and cut.state[0, 1] == pytest.approx(3.0 * np.log1p(1e-3), rel=1e-12)


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("strain", [1e-6, 1e-4, 1e-2, 1.0])
def test_softening_converges_however_steep(strain, precision):
    law = changed(SOFTENING, softening_strain=strain, cohesion=5e4)
    rng = np.random.default_rng(6)
    n = 20_000
    size = np.exp(rng.uniform(np.log(1e-7), np.log(5.0), (n, 1)))
    stretch = size * rng.uniform(-1.0, 1.0, (n, 3))
    update = StressUpdate(law, 3, precision)
    state = np.column_stack([strain * rng.exponential(2.0, n) * rng.integers(0, 2, n), np.zeros(n)])
    result = update(np.zeros((n, 6)), state, np.expm1(stretch)[:, None] * np.eye(3))
    stress = unpack(result.stress.astype(float))
    assert (result.iterations > 1).sum() > 1000
    made = result.iterations >= 0
    f = np.exp(stretch)[:, None] * np.eye(3)
    assert made[representable(f, np.tile(np.eye(3), (n, 1, 1)), precision)].all() and made.mean() > 0.9
    assert result.iterations.max() <= 25
    violation = law.yield_function(stress, result.state.astype(float))
    if precision == "f64":
        assert (violation / (np.abs(stress).max(axis=(1, 2)) + law.k)).max() < 1e-9
    else:
        # κ is stored to 6e-8 of itself, which the strength multiplies by κ/κ_c, at most 14 before it is gone
        assert (violation / (np.abs(stress).max(axis=(1, 2)) + law.k)).max() < 1e-5


# --- Apex and separation -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cone", CONES)
def test_apex_is_kept_with_cohesion(cone):
    law = changed(COHESIVE, cone=cone)
    t = np.array([0.01, 0.05, 0.045, 0.05])
    path = MaterialPoint(law).drive(isotropic_volume(t))
    apex = 1e4 / np.tan(np.radians(30.0))
    np.testing.assert_allclose(path.p, [-apex, -apex, -apex + 0.005 * law.bulk_modulus, -apex], rtol=1e-11)
    # The work of the apex stress in the plastic opening, none of it given back
    np.testing.assert_allclose(path.dissipation[[0, 1, 3]], apex * (t - apex / law.bulk_modulus)[[0, 1, 1]], rtol=1e-11)
    assert not path.state[:, 1].any()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", [SAND, DILATING], ids=["sand", "dilating"])
def test_healing_after_tension(law, dimension):
    # Compressed to p_i, pulled apart to ln J = .05, pushed back: stress-free until the old volume of no stress
    t = np.concatenate([[-0.01, 0.0], np.linspace(0.0, 0.05, 7)[1:], np.linspace(0.05, -0.02, 15)[1:]])
    if dimension == 2:
        F = diagonal(t / 2.0, t / 2.0, 0.0)[:, :2, :2]
    else:
        F = isotropic_volume(t)
    path = MaterialPoint(law, dimension=dimension).drive(F)
    # Volume is what decides: p = K (−t) wherever grains touch. Plane compression yields dilation only if ψ > 0
    if law is SAND or dimension == 3:
        np.testing.assert_allclose(path.p, np.maximum(-law.bulk_modulus * t, 0.0), atol=1e-8)
        np.testing.assert_allclose(path.state[:, 1], np.maximum(t, 0.0), atol=1e-14)
    separated = t > 1e-12
    assert not path.kirchhoff[separated].any() and not np.diff(path.dissipation)[separated[1:]].any()


def test_closing_through_the_gap_in_one_step_is_exact():
    # From a gap of .03 along a constant direction, shear included: one step or a thousand
    law, direction = SAND, np.array([-0.06, 0.01, 0.005])
    update = StressUpdate(law)
    state = np.array([[0.0, 0.03]])
    once = update(np.zeros((1, 6)), state, np.diag(np.expm1(direction))[None])
    many = update.integrate(np.zeros((1, 6)), state, np.tile(np.diag(np.expm1(direction / 1000.0)), (1, 1000, 1, 1)))
    # One of the thousand holds the closing; it is as exact as the single one
    np.testing.assert_allclose(once.stress[0], many.stress[0, -1], atol=1e-7)
    assert once.state[0, 1] == 0.0
    assert -once.stress[0, :3].sum() / 3.0 == pytest.approx(law.bulk_modulus * (0.045 - 0.03), rel=1e-12)


def test_volume_does_not_grow_in_cycles_of_separation():
    # What programs without a gap variable do: each cycle of tension and shear presses harder
    law = DILATING
    cycle = np.array([[0.02, 0.02, 0.02], [0.03, 0.0, 0.02], [0.0, 0.0, 0.0], [-0.003, -0.003, -0.003]])
    F = diagonal(*np.tile(cycle, (20, 1)).T)
    p = MaterialPoint(law).drive(F).p[3::4]
    # The first squeeze compresses by .009; the later ones find grains at the same volume
    np.testing.assert_allclose(p, 0.009 * law.bulk_modulus, rtol=1e-9)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_separated_sand_weighs_nothing_in_any_motion(precision):
    rng = np.random.default_rng(8)
    update = StressUpdate(SAND, 3, precision)
    A = 1e-3 * rng.normal(size=(50, 200, 3, 3))
    result = update.integrate(np.zeros((50, 6)), np.tile([0.0, 2.0], (50, 1)), A)
    assert not result.stress.any() and not result.h.any() and not result.iterations.any()
    volume = np.log(np.linalg.det(A + np.eye(3))).sum(axis=1)
    atol = 1e-12 if precision == "f64" else 1e-4  # 200 additions to a number of order 1
    np.testing.assert_allclose(result.state[:, -1, 1], 2.0 + volume, atol=atol)


@pytest.mark.parametrize(
    "values",
    [
        {"friction_angle": 90.0},
        {"dilation_angle": 38.0},
        {"dilation_angle": -1.0},
        {"cone": "hexagon"},
        {"friction_angle": 0.0},
        {"residual_cohesion": 1.0},
        {"softening_strain": 0.0},
        {"friction_angle": 0.0, "cohesion": 1e3, "softening_strain": 0.1},
    ],
)
def test_impossible_strengths_are_refused(values):
    with pytest.raises(ValidationError):
        changed(SAND, **values)


def test_frictionless_cone_is_von_mises():
    law = DruckerPrager(**SOIL, friction_angle=0.0, cohesion=1e4)
    assert law.alpha == 0.0 and law.k == pytest.approx(2e4, rel=1e-6) and law.tensile_apex == np.inf
    t = np.array([-0.1, 0.0, 0.2, 1.0])
    path = MaterialPoint(law).drive(diagonal(t, t + 0.01, t - 0.01))
    np.testing.assert_allclose(path.q, law.k, rtol=1e-11)
    np.testing.assert_allclose(path.p, -3.0 * law.bulk_modulus * t, atol=1e-6)
