"""Element tests against closed forms, and what holds for every test of every law."""

import numpy as np
import pytest
from element_laws import DP, DP_SOFT, ELASTIC, SAND
from frictional_laws import SOIL
from parameter_sets import SETS, W1, A, B, C, simple_shear
from scipy.optimize import brentq

from snowmpm.materials import EXPERIMENTS, LoadingError, MaterialPoint, MuI, measure


def cauchy_pressure(law, p):
    """Cauchy pressure at which an elastic sample is under the Kirchhoff pressure p: p = K x, x = −ln J."""
    return p * np.exp(p / law.bulk_modulus)


def isotropic_pressure(law, x):
    """p(x) of isotropic compression with p0 = 0 at first: x = z + sinh ξz, p = K sinh ξz."""
    z = brentq(lambda z: z + np.sinh(law.hardening * z) - x, 0.0, x, xtol=1e-16)
    return law.bulk_modulus * np.sinh(law.hardening * z)


@pytest.mark.parametrize("steps", [1, 7])
def test_isotropic(steps):
    for x, p_a, p_b, p_c in [(0.1, 140036.203, 126526.976, 25759.5585), (1.0, 1290692.35, 1276404.0, 94118.5173)]:
        for law, p in ((A, p_a), (B, p_b), (C, p_c)):
            found = measure(law, "isotropic", strain=x, steps=steps)
            assert found.path.p[-1] == pytest.approx(p, rel=5e-9)  # nine digits printed; exact for any step
            assert found.table()["p"][1][-1] == pytest.approx(p * np.exp(x), rel=5e-9)
            assert found.table()["volumetric_strain"][1][-1] == pytest.approx(-x, rel=1e-14)


@pytest.mark.parametrize("law", [A, C], ids=["A", "C"])
def test_tension_to_the_apex_and_back(law):
    # Opens to t, beyond separation at t = z0, and back to −t: stress-free until the gap is closed at t = z0, then like
    # cohesionless-born snow, T1.1 with z0 = 0
    z0 = law.initial_zeta
    opening = 3.0 * z0
    found = measure(law, "tension", strain=opening, steps=300)
    t, p = found.driven_strain, found.path.p
    assert t[100] == pytest.approx(opening) and t[-1] == pytest.approx(-opening)
    peak = np.argmin(p)
    assert found.characteristics().yield_row - peak in (0, 1)  # softens from where it yields
    assert p[peak] == pytest.approx(-law.beta * law.p0, rel=0.05)  # elastic up to the apex, met within a step
    back = np.arange(len(t)) > 100
    free = back & (t > z0 + 1e-9)
    assert free.sum() > 50 and not p[free].any() and not found.path.q[free].any()
    for i in np.flatnonzero(back & (t < z0 - 1e-9)):
        assert p[i] == pytest.approx(isotropic_pressure(law, z0 - t[i]), rel=1e-8)  # round-off of 200 strains of z0


OEDOMETER = [("A", 0.1, 125783.70, 83088.755, -200230.67), ("B", 0.02, 25529.738, 3519.7717, -28439.390)]
OEDOMETER += [("C", 0.2, 30007.492, 11503.256, -46017.973)]


@pytest.mark.parametrize(("name", "x", "p", "q", "cauchy"), OEDOMETER)
def test_oedometer(name, x, p, q, cauchy):
    def run(steps):
        found = measure(SETS[name], "oedometer", strain=x, steps=steps)
        return np.array([found.path.p[-1], found.path.q[-1], found.table()["stress_zz"][1][-1]])

    coarse, fine = run(1000), run(2000)
    # First order: extrapolation leaves the part of the step in which it yields, and eight digits are printed
    np.testing.assert_allclose(2.0 * fine - coarse, (p, q, cauchy), rtol=2e-7)  # measured 4e-8
    np.testing.assert_allclose(fine, (p, q, cauchy), rtol=2e-5)  # backward Euler's own error, measured 8e-6


CRITICAL = [
    ("A", 6000, 9333.2778, 20554.682),
    ("A", 27000, 14778.111, 32545.842),
    ("B", 600, 1199.9999, 599.99994),
    ("C", 18000, 7372.0898, 12988.446),
]


@pytest.mark.parametrize(("name", "p_start", "p", "q"), CRITICAL)
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_triaxial_at_constant_volume_ends_at_critical_state(name, p_start, p, q, precision):
    law = SETS[name]
    pressure = cauchy_pressure(law, p_start)
    found = measure(law, "triaxial_constant_volume", strain=1.0, steps=400, pressure=pressure, precision=precision)
    # Eight digits printed, of p_i as of the rest; float32 drifts by the rounding of ln J in 400 steps
    np.testing.assert_allclose((found.path.p[-1], found.path.q[-1]), (p, q), rtol=5e-8 if precision == "f64" else 3e-3)
    assert np.abs(found.table()["volumetric_strain"][1]).max() < 1e-14
    reached = found.characteristics()
    assert reached.critical and reached.steady_ratio == pytest.approx(q / p, rel=1e-7 if precision == "f64" else 3e-3)


@pytest.mark.parametrize(
    ("law", "p_start", "p", "q"), [(A, 27000, 14778.111, 32545.842), (C, 18000, 7372.090, 12988.446)]
)
def test_simple_shear_at_constant_volume_stays_steady(law, p_start, p, q):
    found = measure(law, "simple_shear_constant_volume", pressure=cauchy_pressure(law, p_start))
    assert found.driven_strain[-1] == 10.0
    steady = found.driven_strain >= 1.0
    np.testing.assert_allclose(found.path.p[steady], p, rtol=2e-7)  # eight digits printed; no oscillation, no drift
    np.testing.assert_allclose(found.path.q[steady], q, rtol=2e-7)
    # The same as the path of F in another plane
    F = simple_shear(law, p_start, np.linspace(0.0, 10.0, 1001)[1:])
    path = MaterialPoint(law).drive(F)
    np.testing.assert_allclose(found.path.kirchhoff[1:, 0, 2], path.kirchhoff[1:, 0, 1], rtol=1e-8)
    np.testing.assert_allclose(found.path.kirchhoff[1:, 2, 2], path.kirchhoff[1:, 1, 1], rtol=1e-8)


@pytest.mark.parametrize("law", [A, B, C], ids=["A", "B", "C"])
def test_simple_shear_under_normal_stress(law):
    normal = 0.3 * law.p0
    found = measure(law, "simple_shear", pressure=normal)
    table = found.table()
    np.testing.assert_allclose(table["stress_zz"][1], -normal, rtol=1e-8)
    for component in ("xx", "yy", "xy", "yz"):
        assert not table[f"strain_{component}"][1].any()  # the planes of shear keep their area
    # Critical state: q/p = M (1 + β) / ((1 − β) √(1 + 2β))
    beta = law.beta
    ratio = law.critical_slope * (1.0 + beta) / ((1.0 - beta) * np.sqrt(1.0 + 2.0 * beta))
    # What is left of the exponential approach at gamma = 10, slowest for set C, which hardens least: measured 6e-7
    reached = found.characteristics()
    assert reached.critical and reached.steady_ratio == pytest.approx(ratio, rel=2e-6)
    # The deviator turns away from the plane of shear by the elastic stretch, of order q/G, and backward Euler's step
    # adds its own 0.01: p is the normal stress to that order of q
    p, q = found.cauchy_invariants
    assert p[-1] == pytest.approx(normal, abs=q[-1] * (q[-1] / law.shear_modulus + 0.01))


def test_hypoplastic_sand_in_other_tests():
    # Oedometer: K0 = c4 / (3 c1 + c4), approached to 3e-5; constant volume: void ratio and J stay
    table = measure(SAND, "oedometer", pressure=1e4, strain=0.05).table()
    assert table["stress_xx"][1][-1] / table["stress_zz"][1][-1] == pytest.approx(SAND.lateral_pressure, rel=2e-4)
    table = measure(SAND, "simple_shear_constant_volume", pressure=1e4, strain=1.0, steps=200).table()
    np.testing.assert_allclose(table["void_ratio"][1], SAND.void_ratio, rtol=1e-10)
    found = measure(SAND, "triaxial", pressure=1e4)
    section = found.yield_section()
    p, q = found.cauchy_invariants
    row, column = np.argmin(np.abs(section.q - q[-1])), np.argmin(np.abs(section.p - p[-1]))
    near = section.final[row - 2 : row + 3, column - 2 : column + 3]
    assert section.name == "failure surface" and near.min() < 0.0 < near.max()
    with pytest.raises(LoadingError, match="pressure must be > 0"):
        measure(SAND, "triaxial")


def test_rate_of_shear_reaches_mu_of_inertial_number():
    law = MuI(**SOIL, static_friction=0.38, limit_friction=0.64, grain_diameter=1e-3, grain_density=2500.0)
    for rate in (0.1, 10.0, 100.0):
        found = measure(law, "simple_shear_constant_volume", pressure=1e3, strain=1.0, steps=1000, rate=rate)
        assert found.table()["time"][1][-1] == pytest.approx(1.0 / rate)
        p, q = found.path.p[-1], found.path.q[-1]
        inertial = rate * law.grain_diameter / np.sqrt(p / law.grain_density)
        mu = law.static_friction + (law.limit_friction - law.static_friction) / (1.0 + law.inertial_number / inertial)
        assert q / p == pytest.approx(np.sqrt(3.0) * mu, rel=1e-7)  # elastic strain rates are gone by then


LASTS = {"tension": 3.0, "accelerated_shear": 2.0}
"""Duration over that of the driven strain at the rate given."""


@pytest.mark.parametrize("name", EXPERIMENTS)
@pytest.mark.parametrize("law", [A, W1, ELASTIC, DP], ids=["A", "W1", "elastic", "DP"])
def test_every_test_of_every_kind_of_law_gives_a_whole_table(law, name):
    found = measure(law, name, pressure=1e3, steps=60, strain=0.6 if "shear" in name else None)
    table = found.table()
    units = {unit for unit, _ in table.values()}
    assert units <= {"", "-", "Pa", "s", "J/m3"}
    assert {len(values) for _, values in table.values()} == {61}
    for column, (_, values) in table.items():
        assert np.isfinite(values[1:]).all(), column
    np.testing.assert_array_equal(table["step"][1], np.arange(61))
    assert table["time"][1][-1] == pytest.approx(abs(found.driven_strain).max() * LASTS.get(name, 1.0))
    assert (np.diff(table["dissipation"][1]) >= -1e-12).all()
    held = {column.removeprefix("prescribed_") for column in table if column.startswith("prescribed_")}
    assert held == {"triaxial": {"stress_xx", "stress_yy"}, "simple_shear": {"stress_zz"},
                    "accelerated_shear": {"stress_zz"}}.get(name, set())
    for column in held:
        np.testing.assert_allclose(table[f"prescribed_{column}"][1][1:], table[column][1][1:], rtol=1e-8)


@pytest.mark.parametrize("name", ["triaxial", "oedometer", "simple_shear_constant_volume"])
@pytest.mark.parametrize("law", [A, W1, DP_SOFT], ids=["A", "W1", "DP"])
def test_the_path_ends_on_the_yield_surface_that_is_drawn(law, name):
    found = measure(law, name, pressure=1e3, steps=100, strain=0.05)
    section = found.yield_section()
    p, q = found.cauchy_invariants
    assert section.p[0] < p.min() and p.max() < section.p[-1] and q.max() < section.q[-1]
    row = np.argmin(np.abs(section.q - q[-1])), np.argmin(np.abs(section.p - p[-1]))
    # Within a cell of the grid around its end the final surface changes sign; the start lies inside the initial one
    cells = tuple(slice(max(i - 1, 0), i + 2) for i in row)
    assert section.final[cells].min() <= 0.0 <= section.final[cells].max()
    start = np.argmin(np.abs(section.p - p[0]))
    assert section.initial[0, start] < 0.0


def test_arguments_that_make_no_test_are_refused():
    for arguments, message in [
        ({"name": "brazilian"}, "no test brazilian: one of isotropic, oedometer, triaxial"),
        ({"strain": 0.0}, "strain = 0.0: must be finite and not zero"),
        ({"strain": float("nan")}, "strain = nan"),
        ({"pressure": -1.0}, "pressure = -1.0: must be >= 0"),
        ({"rate": 0.0}, "rate = 0.0: must be > 0"),
        ({"steps": 0}, "at least one step"),
    ]:
        with pytest.raises(LoadingError, match=message):
            measure(A, **{"name": "triaxial", **arguments})
