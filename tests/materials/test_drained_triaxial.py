"""Drained triaxial tests: the path at constant lateral stress, and the strength of every law at its end."""

import numpy as np
import pytest
from element_laws import DP, DP_SAND, ELASTIC, SAND
from frictional_laws import SOIL
from parameter_sets import A, B, changed

from snowmpm.materials import MohrCoulomb, VonMises, measure


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


@pytest.mark.parametrize("return_map", ["frozen", pytest.param("substepped", marks=pytest.mark.slow)])
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


def test_failure_with_dilation_is_no_critical_state():
    found = [measure(law, "triaxial", pressure=5e4, strain=0.05).characteristics() for law in (DP, DP_SAND, SAND)]
    assert all(one.steady_ratio is not None for one in found[:2])
    assert [one.critical for one in found] == [False, True, False]  # the last is on its way still
