"""Element tests against closed forms, and paths from files."""

from itertools import pairwise

import numpy as np
import pytest
from frictional_laws import SOIL
from parameter_sets import SETS, W1, A, B, C, changed, simple_shear
from scipy.optimize import brentq

from snowmpm.materials import (
    EXPERIMENTS,
    DruckerPrager,
    Elastic,
    Hypoplastic,
    LoadingError,
    MaterialPoint,
    MohrCoulomb,
    MuI,
    VonMises,
    measure,
    measure_path,
    read_loading,
)

ELASTIC = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)


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


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("lateral", [600.0, 1200.0, 2000.0])
def test_drained_triaxial_of_modified_cam_clay(lateral, precision):
    found = measure(B, "triaxial", pressure=lateral, strain=0.5, precision=precision)
    table, accurate = found.table(), precision == "f64"
    for component in ("xx", "yy"):
        np.testing.assert_allclose(table[f"stress_{component}"][1], -lateral, rtol=1e-8 if accurate else 2e-4)
    p, q = found.cauchy_invariants
    M = B.critical_slope
    # σ3 constant and q = σ1 − σ3: dq/dp = 3 all along, and the path ends where it meets q = M p
    np.testing.assert_allclose(q, 3.0 * (p - lateral), atol=(1e-7 if accurate else 1e-3) * lateral)
    end = 3.0 * lateral / (3.0 - M)
    # f64: what is left of the exponential approach; f32: the stress held and the rounding of strain
    assert p[-1] == pytest.approx(end, rel=1e-7 if accurate else 1e-3)
    assert q[-1] == pytest.approx(M * end, rel=1e-7 if accurate else 1e-3)
    reached = found.characteristics()
    assert reached.critical and reached.steady_ratio == pytest.approx(M, rel=1e-7 if accurate else 1e-3)
    # and p0 is twice p there, in Kirchhoff stresses
    assert found.path.p0[-1] == pytest.approx(2.0 * found.path.p[-1], rel=1e-6 if accurate else 2e-3)


@pytest.mark.parametrize("return_map", ["frozen", "substepped"])
def test_drained_triaxial_with_other_return_maps(return_map):
    # A frozen p0 makes the tangent that of a perfectly plastic law, sub-steps make it rougher: control copes with both
    found = measure(changed(B, return_map=return_map), "triaxial", pressure=1200.0, strain=0.5, steps=400)
    np.testing.assert_allclose(found.table()["stress_xx"][1], -1200.0, rtol=1e-8)
    p, q = found.cauchy_invariants
    end = 3.0 * 1200.0 / (3.0 - B.critical_slope)
    # p0 stands still at critical state, so every scheme ends at the same one: measured below 2e-11
    np.testing.assert_allclose((p[-1], q[-1]), (end, B.critical_slope * end), rtol=1e-9)


def test_drained_triaxial_extension():
    found = measure(A, "triaxial", pressure=8e3, strain=-0.1)
    p, q = found.cauchy_invariants
    # σ1 falls: q = σ3 − σ1, p = σ3 − q/3
    np.testing.assert_allclose(p, 8e3 - q / 3.0, rtol=1e-8)
    assert q[-1] > 1e4 and found.table()["strain_zz"][1][-1] == 0.1


def test_elastic_drained_triaxial():
    # Hencky elasticity from the consolidated state: Δτ_lat = 0 up to the change of J, so compare at small strain
    found = measure(ELASTIC, "triaxial", strain=1e-5, steps=10, pressure=1e3)
    table = found.table()
    axial, lateral = table["strain_zz"][1][-1], table["strain_xx"][1][-1]
    stress = table["stress_zz"][1][-1] - table["stress_zz"][1][0]
    # Stresses of 1e3 Pa turn J into 3e-4 of E and of nu
    assert stress / axial == pytest.approx(ELASTIC.youngs_modulus, rel=5e-4)
    assert -lateral / axial == pytest.approx(ELASTIC.poisson_ratio, rel=1e-3)
    assert found.characteristics().yield_row is None and found.yield_section() is None
    assert not np.any(table["dissipation"][1])


DP = DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4)
DP_SOFT = DruckerPrager(**SOIL, friction_angle=15.0, dilation_angle=5.0, cohesion=1e3)  # yields in the oedometer too
DP_SAND = DruckerPrager(**SOIL, friction_angle=37.0)


@pytest.mark.parametrize("law", [DP, DP_SAND], ids=["cohesive", "sand"])
def test_drained_triaxial_strength_of_drucker_prager(law):
    lateral = 5e4
    found = measure(law, "triaxial", pressure=lateral, strain=0.05)
    # q = α p + k in Kirchhoff stresses, τ = J σ, on the path q = 3 (p − J σ3): p = (3 J σ3 + k) / (3 − α)
    J = np.linalg.det(found.path.deformation[-1])
    p = (3.0 * J * lateral + law.k) / (3.0 - law.alpha)
    assert found.path.p[-1] == pytest.approx(p, rel=1e-8)  # what the lateral stress is held to
    assert found.path.q[-1] == pytest.approx(law.alpha * p + law.k, rel=1e-8)
    np.testing.assert_allclose(found.table()["stress_xx"][1], -lateral, rtol=1e-9)
    # Dilation per plastic shear: at failure the elastic strain only follows J, so dε_v/dε_s = α_ψ of the strains
    strain = np.array([row.strain[:3] for row in found.rows])
    volume = strain.sum(axis=1)
    deviator = strain - volume[:, None] / 3.0
    shear = np.sqrt(2.0 / 3.0) * np.linalg.norm(deviator[-1] - deviator[-2])
    assert (volume[-1] - volume[-2]) / shear == pytest.approx(law.alpha_psi, abs=2e-2 * law.alpha_psi + 1e-7)


def test_drained_triaxial_strength_of_mohr_coulomb_and_von_mises():
    # Two equal principal stresses: an edge of the Mohr-Coulomb pyramid, σ1 = K_p σ3 + 2 c √K_p
    law = MohrCoulomb(**SOIL, friction_angle=30.0, cohesion=1e4)
    found = measure(law, "triaxial", pressure=2e4, strain=0.03, steps=100)
    J = np.linalg.det(found.path.deformation[-1])
    strength = 3.0 * J * 2e4 + 2.0 * 1e4 * np.sqrt(3.0)
    assert -found.path.kirchhoff[-1, 2, 2] == pytest.approx(strength, rel=1e-8)
    np.testing.assert_allclose(found.table()["stress_yy"][1], -2e4, rtol=1e-9)
    found = measure(VonMises(**SOIL, yield_stress=2e4), "triaxial", pressure=2e4, strain=0.03, steps=100)
    assert found.path.q[-1] == pytest.approx(2e4, rel=1e-9)


SAND = Hypoplastic(density=1500.0, youngs_modulus=2e7, poisson_ratio=0.2, friction_angle=35.0)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_drained_triaxial_of_hypoplastic_sand_gives_its_parameters_back(precision):
    # The law's parameters are those of this very test; a rate law starts under its pressure
    lateral = SAND.reference_pressure
    found = measure(SAND, "triaxial", pressure=lateral, strain=0.1, precision=precision)
    table, rough = found.table(), precision == "f32"
    np.testing.assert_allclose(table["stress_xx"][1], -lateral, rtol=2e-4 if rough else 1e-9)
    sine = np.sin(np.radians(SAND.friction_angle))
    ratio = 6.0 * sine / (3.0 - sine)
    # What is left of the exponential approach to failure at 10 %: measured 2e-6
    assert found.characteristics().steady_ratio == pytest.approx(ratio, rel=1e-5)
    assert found.characteristics().yield_row is None
    start = measure(SAND, "triaxial", pressure=lateral, strain=1e-6, steps=2).table()
    modulus = (start["stress_zz"][1][-1] + lateral) / start["strain_zz"][1][-1]
    # Slope and ratio change over the strain of 1e-6: measured 1e-5 and 8e-5
    assert modulus == pytest.approx(SAND.youngs_modulus, rel=5e-5)
    ratio = -start["strain_xx"][1][-1] / start["strain_zz"][1][-1]
    assert ratio == pytest.approx(SAND.poisson_ratio, rel=4e-4)


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


def test_failure_with_dilation_is_no_critical_state():
    found = [measure(law, "triaxial", pressure=5e4, strain=0.05).characteristics() for law in (DP, DP_SAND, SAND)]
    assert all(one.steady_ratio is not None for one in found[:2])
    assert [one.critical for one in found] == [False, True, False]  # the last is on its way still


def test_rate_of_shear_reaches_mu_of_inertial_number():
    law = MuI(**SOIL, static_friction=0.38, limit_friction=0.64, grain_diameter=1e-3, grain_density=2500.0)
    for rate in (0.1, 10.0, 100.0):
        found = measure(law, "simple_shear_constant_volume", pressure=1e3, strain=1.0, steps=1000, rate=rate)
        assert found.table()["time"][1][-1] == pytest.approx(1.0 / rate)
        p, q = found.path.p[-1], found.path.q[-1]
        inertial = rate * law.grain_diameter / np.sqrt(p / law.grain_density)
        mu = law.static_friction + (law.limit_friction - law.static_friction) / (1.0 + law.inertial_number / inertial)
        assert q / p == pytest.approx(np.sqrt(3.0) * mu, rel=1e-7)  # elastic strain rates are gone by then


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
    assert table["time"][1][-1] == pytest.approx(abs(found.driven_strain).max() * (3.0 if name == "tension" else 1.0))
    assert (np.diff(table["dissipation"][1]) >= -1e-12).all()
    held = {column.removeprefix("prescribed_") for column in table if column.startswith("prescribed_")}
    assert held == {"triaxial": {"stress_xx", "stress_yy"}, "simple_shear": {"stress_zz"}}.get(name, set())
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


def write(tmp_path, text):
    file = tmp_path / "path.csv"
    file.write_text(text)
    return file


def test_a_file_of_strains_and_stresses(tmp_path):
    # Drained triaxial: load, unload to the isotropic stress, reload
    text = "# made by hand\nstrain_zz [-], stress_zz, stress_xx [Pa], stress_yy [Pa], duration\n"
    text += "-0.05,,-8e3,-8e3,2\n\n,-8e3,-8e3,-8e3,1\n-0.1,,-8e3,-8e3,1\n"
    found = measure_path(A, read_loading(write(tmp_path, text)), pressure=8e3, steps=50)
    table = found.table()
    assert len(found.rows) == 151 and table["time"][1][-1] == pytest.approx(4.0)
    reference = measure(A, "triaxial", pressure=8e3, strain=0.05, steps=50)
    np.testing.assert_allclose(table["q"][1][:51], reference.table()["q"][1], rtol=1e-9, atol=1e-6)
    assert table["q"][1][100] == pytest.approx(0.0, abs=1e-4)
    assert not table["iterations"][1][52:101].any() and table["iterations"][1][-1] > 0
    assert table["strain_zz"][1][150] == -0.1
    assert np.isnan(table["prescribed_stress_zz"][1][[0, 50, 101]]).all()


def test_a_file_of_deformation_gradients(tmp_path):
    text = "F_xx,F_xz,F_zz,duration\n0.98,0,0.99,1\n0.98,0.2,0.97,3\n"
    loading = read_loading(write(tmp_path, text))
    found = measure_path(A, loading, steps=10)
    middle = np.array([np.diag([0.98, 1.0, 0.99]), [[0.98, 0, 0.2], [0, 1.0, 0], [0, 0, 0.97]]])
    ends = np.concatenate([np.eye(3)[None], middle])
    share = np.arange(1, 11)[:, None, None] / 10.0
    F = np.concatenate([a + share * (b - a) for a, b in pairwise(ends)])
    path = MaterialPoint(A).drive(F)
    np.testing.assert_allclose(found.path.kirchhoff[1:], path.kirchhoff, rtol=1e-10, atol=1e-8)
    table = found.table()
    np.testing.assert_allclose(table["F_xz"][1][[10, 15, 20]], [0.0, 0.1, 0.2], atol=1e-15)
    assert table["time"][1][-1] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("strain_zz\n-0.1\nmuch\n", "line 3, column strain_zz = much: must be a finite number"),
        ("strain_zz\n-0.1\nnan\n", "line 3, column strain_zz = nan"),
        ("strain_zz,stress_xx\n-0.1\n", "line 2: 1 values for 2 columns"),
        ("strain_zz,stress_xx\n-0.1,\n", "line 2, column stress_xx is empty"),
        ("strain_zz,stress_zz\n-0.1,-1e3\n", "line 2, column stress_zz and its strain: exactly one"),
        ("strain_zz,stress_zz\n,\n", "line 2, column stress_zz and its strain: exactly one"),
        ("strain_zy\n0.1\n", "column 'strain_zy' is not known; did you mean strain_"),
        ("temperature\n0.1\n", "column 'temperature' is not known"),
        ("stress_xx [kPa]\n0.1\n", r"column stress_xx: the unit must be \[Pa\], not \[kPa\]"),
        ("strain_zz,strain_zz\n0.1,0.1\n", "column strain_zz comes twice"),
        ("F_xx,strain_zz\n1,0\n", "columns F_"),
        ("duration\n1\n", "no column says what to do"),
        ("strain_zz,duration\n0.1,0\n", "line 2, column duration = 0: must be a number > 0"),
        ("strain_zz,duration\n0.1,\n", "line 2, column duration: empty"),
        ("F_xx,F_zz\n1,1\n-1,1\n", "line 3: det F = -1: must be > 0"),
        ("strain_zz\n", "needs a line of column names and at least one row"),
        ("", "needs a line of column names and at least one row"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    file = write(tmp_path, text)
    with pytest.raises(LoadingError, match=message) as error:
        read_loading(file)
    assert str(error.value).startswith(str(file))


def test_files_that_are_no_text_are_refused(tmp_path):
    file = tmp_path / "path.csv"
    file.write_bytes(b"\xff\xfe\x00strain_zz")
    with pytest.raises(LoadingError, match="not a text file"):
        read_loading(file)
    with pytest.raises(OSError):
        read_loading(tmp_path / "none.csv")


def test_a_turn_by_half_a_circle_needs_rows_between(tmp_path):
    loading = read_loading(write(tmp_path, "F_xx,F_zz\n1,1\n-1,-1\n"))
    with pytest.raises(LoadingError, match="det F <= 0 on the way to row 2"):
        measure_path(A, loading, steps=2)


def test_a_stress_out_of_reach_names_the_step(tmp_path):
    # Critical state: σ1 = σ3 + M 3 σ3 / (3 − M) = 4800 Pa, three steps of 600 Pa into the second row, met in the limit
    loading = read_loading(write(tmp_path, "stress_zz,stress_xx,stress_yy\n-3e3,-3e3,-3e3\n-9e3,-3e3,-3e3\n"))
    with pytest.raises(LoadingError, match="step 13: stress xx = -3000 Pa"):
        measure_path(B, loading, steps=10)
