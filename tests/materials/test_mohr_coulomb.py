"""Mohr-Coulomb against what Coulomb's line says, and its return map against a search over all sets of faces."""

import itertools

import numpy as np
import pytest
from frictional_laws import LAWS, SOIL, stress_of
from hypothesis import given, settings
from hypothesis import strategies as st
from parameter_sets import changed, diagonal, random_rotations, simple_shear
from pydantic import ValidationError
from scipy.optimize import nnls

from snowmpm.materials import DruckerPrager, MaterialPoint, MohrCoulomb, StressUpdate, pack, unpack

# phi = 30, c = 10 kPa, psi = 0: K_p = 3, UCS = 34 641.0 Pa
SOIL_30 = MohrCoulomb(**SOIL, friction_angle=30.0, cohesion=1e4)
SAND = LAWS["MC sand"]


def one_step(law, strain, precision="f64"):
    """Stress (n, 3, 3), and all of the result, of principal logarithmic strains (n, 3) in one step from rest."""
    strain = np.atleast_2d(np.asarray(strain, float))
    A = np.expm1(strain)[:, None, :] * np.eye(3)
    update = StressUpdate(law, 3, precision)
    result = update(np.zeros((len(A), 6)), update.initial_state(len(A)), A)
    return unpack(result.stress.astype(float)), result


def principal(stress):
    """Principal stresses, tension positive, largest first."""
    return np.linalg.eigvalsh(stress)[..., ::-1]


# --- Coulomb's numbers -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("confinement", [0.0, 2e4])
def test_triaxial_strength(confinement):
    # σ_axial = K_p σ_lateral + 2 c √K_p. The strains of that state, sheared further without change of volume
    axial = 3.0 * confinement + 2.0 * 1e4 * np.sqrt(3.0)
    if confinement == 0.0:
        assert axial == pytest.approx(34641.0, abs=0.05)
    elastic = SOIL_30.hencky_from_stress(-np.diag([axial, confinement, confinement]))
    for plastic in (0.0, 0.003, 0.5):
        stress, result = one_step(SOIL_30, np.diag(elastic) + plastic * np.array([-1.0, 0.5, 0.5]))
        # round-off of the P-wave modulus times strains of 0.5, as exp and ln pass it on
        np.testing.assert_allclose(-principal(stress)[0], [confinement, confinement, axial], atol=1e-8)
        assert plastic == 0.0 or result.iterations[0] == 1
    assert one_step(SOIL_30, 0.9999 * np.diag(elastic))[1].iterations[0] == 0


def test_triaxial_extension_strength():
    # The other edge: two equal larger pressures, σ_lateral = K_p σ_axial + 2 c √K_p
    lateral = 3.0 * 1e4 + 2.0 * 1e4 * np.sqrt(3.0)
    elastic = np.diag(SOIL_30.hencky_from_stress(-np.diag([1e4, lateral, lateral])))
    stress, _ = one_step(SOIL_30, elastic + 0.01 * np.array([1.0, -0.5, -0.5]))
    np.testing.assert_allclose(-principal(stress)[0], [1e4, lateral, lateral], atol=1e-9)


def test_apex():
    law = changed(SOIL_30, dilation_angle=10.0)
    apex = 1e4 / np.tan(np.radians(30.0))
    assert law.tensile_apex == pytest.approx(apex, rel=1e-14)
    stress, result = one_step(law, [[0.01, 0.01, 0.01], [0.02, 0.011, 0.01]])
    np.testing.assert_allclose(stress, np.tile(apex * np.eye(3), (2, 1, 1)), rtol=1e-13)
    dilation = np.array([0.03, 0.041]) - apex / law.bulk_modulus
    np.testing.assert_allclose(result.dissipation, apex * dilation, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_simple_shear_reaches_coulombs_line(dimension):
    # σ_n sin φ + c cos φ = 18 660.25 Pa at σ_n = 20 kPa; stiff, so that elastic strain turns the axes by 1e-8 only
    stiff = changed(SOIL_30, youngs_modulus=1e12)
    twin = DruckerPrager(**{**SOIL, "youngs_modulus": 1e12}, friction_angle=30.0, cohesion=1e4, cone="plane_strain")
    for law in (stiff, twin):
        F = simple_shear(law, 2e4, np.linspace(0.0, 1e-6, 60)[1:])[:, :dimension, :dimension]
        if dimension == 2:  # the isotropic start also squeezes the third axis, which a plane path cannot
            update = StressUpdate(law, 2)
            start = pack(law.h_from_stress(-2e4 * np.eye(3)), 2)[None]
            shear = np.zeros((1, 60, 2, 2))
            shear[..., 0, 1] = 1e-6 / 60
            stress = unpack(update.integrate(start, update.initial_state(1), shear).stress[0, -1])
        else:
            stress = MaterialPoint(law).drive(F).kirchhoff[-1]
        # 2e-8 of strain in numbers of order 1, 1e-16: 5e-9 of the stress
        assert stress[0, 1] == pytest.approx(18660.25403784, rel=2e-7)
        assert stress[1, 1] == pytest.approx(-2e4, rel=2e-7)


def test_intermediate_stress_does_not_matter():
    # Yield, and the strength on the way: any σ₂ between σ₁ and σ₃ gives the same largest and smallest stress
    share = np.linspace(0.0, 1.0, 11)[:, None]
    axial, lateral = 3.0 * 2e4 + 2e4 * np.sqrt(3.0), 2e4
    states = -np.stack(np.broadcast_arrays(axial, lateral + share[:, 0] * (axial - lateral), lateral), axis=-1)
    value = SOIL_30.yield_function(states[:, None] * np.eye(3), np.zeros((11, 2)))
    np.testing.assert_allclose(value, 0.0, atol=1e-10)  # round-off of 1e5
    elastic = np.array([np.diag(SOIL_30.hencky_from_stress(np.diag(s))) for s in states])
    # A shear of the face, (1, 0, −1): the plane of largest shear slides and σ₂ keeps its value
    stress, _ = one_step(SOIL_30, elastic + 0.02 * np.array([-1.0, 0.0, 1.0]))
    np.testing.assert_allclose(np.diagonal(stress, axis1=1, axis2=2), states, atol=1e-8)


def test_mean_pressure_does_not_change_without_dilation():
    F = simple_shear(changed(SAND, youngs_modulus=1e8), 1e5, np.linspace(0.0, 1.0, 200)[1:])
    path = MaterialPoint(changed(SAND, youngs_modulus=1e8)).drive(F)
    assert path.state[-1, 0] > 0.5
    np.testing.assert_allclose(path.p, 1e5, rtol=1e-10)  # 200 steps of round-off


# --- The return map against an independent search ------------------------------------------------------------------


def faces(law, angle):
    """Normals (6, 3) of the faces of the pyramid at an angle, unordered principal stresses."""
    s = np.sin(np.radians(angle))
    normals = []
    for i, j in itertools.permutations(range(3), 2):
        normal = np.zeros(3)
        normal[i], normal[j] = 1.0 + s, s - 1.0
        normals.append(normal)
    return np.array(normals)


def searched(law, trial):
    """Principal stresses that solve the complementarity problem of all six faces and the apex, by trying every set."""
    lam = law.bulk_modulus - 2.0 / 3.0 * law.shear_modulus
    C = 2.0 * law.shear_modulus * np.eye(3) + lam
    normals, flows = faces(law, law.friction_angle), faces(law, law.dilation_angle)
    strength = 2.0 * law.cohesion * np.cos(np.radians(law.friction_angle))
    tolerance = 1e-9 * (np.abs(trial).max() + strength)
    found = []
    for count in (0, 1, 2):
        for active in itertools.combinations(range(6), count):
            N, D = normals[list(active)], flows[list(active)]
            matrix = N @ C @ D.T
            if count and np.linalg.cond(matrix) > 1e10:
                continue
            gamma = np.linalg.solve(matrix, N @ trial - strength) if count else np.zeros(0)
            stress = trial - C @ D.T @ gamma
            if (gamma >= -1e-12).all() and (normals @ stress - strength).max() <= tolerance:
                found.append(stress)
    plastic = np.linalg.solve(C, trial - law.tensile_apex)
    if not np.isinf(law.tensile_apex) and nnls(np.column_stack([flows.T, np.ones(3)]), plastic)[1] < 1e-12:
        found.append(np.full(3, law.tensile_apex))
    return np.array(found)


RETURNS = {
    name: changed(SOIL_30, friction_angle=phi, dilation_angle=psi, cohesion=c)
    for name, phi, psi, c in (
        ("isochoric", 30.0, 0.0, 1e4),
        ("dilating", 37.0, 12.0, 1e4),
        ("associated", 25.0, 25.0, 1e4),
        ("cohesionless", 37.0, 10.0, 0.0),
        ("Tresca", 0.0, 0.0, 1e4),
        ("steep", 60.0, 20.0, 1e3),
    )
}


@pytest.mark.parametrize("name", RETURNS)
def test_return_solves_the_complementarity_problem(name):
    law, rng = RETURNS[name], np.random.default_rng(4)
    reach = 4e4 / law.youngs_modulus
    strain = rng.uniform(-1.0, 1.0, (500, 3)) * reach - rng.uniform(-1.0, 2.0, (500, 1)) * reach
    strain[:60, 1] = strain[:60, 0]  # repeated
    strain[60:120, 2] = strain[60:120, 0] + 1e-13  # nearly repeated
    stress, result = one_step(law, strain)
    found, trial = np.diagonal(stress, axis1=1, axis2=2), stress_of(law, strain[:, None] * np.eye(3))
    kinds = {"elastic": 0, "face": 0, "edge": 0, "apex": 0}
    for i in range(len(strain)):
        solutions = searched(law, np.diag(trial[i]))
        assert len(solutions)
        # every solution there is, and this is it: round-off of stresses of 1e5
        np.testing.assert_allclose(solutions, np.tile(found[i], (len(solutions), 1)), atol=2e-8)
        distinct = len(np.unique(np.round(found[i], 4)))
        kind = "elastic" if result.iterations[i] == 0 else {3: "face", 2: "edge", 1: "apex"}[distinct]
        kinds[kind] += 1
    assert all(count > 10 for kind, count in kinds.items() if name != "Tresca" or kind != "apex"), kinds


@settings(max_examples=300, deadline=None)
@given(
    phi=st.floats(0.0, 85.0),
    share=st.floats(0.0, 1.0),
    cohesion=st.sampled_from([0.0, 1.0, 1e4, 1e6]),
    nu=st.floats(-0.5, 0.49),
    strain=st.tuples(*(st.floats(-1.0, 1.0),) * 3),
    size=st.floats(-7.0, 0.6),
)
def test_plastic_strain_is_made_of_flows_of_the_faces_reached(phi, share, cohesion, nu, strain, size):
    phi = phi if cohesion > 0.0 else max(phi, 0.1)
    law = changed(SOIL_30, friction_angle=phi, dilation_angle=share * phi, cohesion=cohesion, poisson_ratio=nu)
    strain = 10.0**size * np.array(strain)
    stress, result = one_step(law, strain)
    found = np.diag(stress[0])
    strength = 2.0 * law.cohesion * np.cos(np.radians(phi))
    y = faces(law, phi) @ found - strength
    trial = np.diag(stress_of(law, np.diag(strain)))
    scale = np.abs(trial).max() + strength + 1e-9  # nothing is smaller: 1e-9 Pa
    assert y.max() <= 1e-12 * scale
    if result.iterations[0] == 0:
        np.testing.assert_allclose(found, trial, atol=1e-12 * scale)
        return
    flows = faces(law, law.dilation_angle)[y > -1e-11 * scale]
    if np.ptp(found) <= 1e-11 * scale:  # at the apex, if all three are equal: any dilation
        flows = np.vstack([flows, np.ones(3)])
    plastic = strain - np.diag(law.hencky_from_stress(stress[0]))
    # Round-off of the trial stress, seen through the softer of the two moduli
    slack = 1e-12 * scale * (1.0 / law.shear_modulus + 1.0 / law.bulk_modulus)
    assert nnls(flows.T, plastic)[1] <= slack


def test_associated_return_is_the_closest_point():
    # In the norm of elastic energy: no admissible stress is closer than the one returned
    law, rng = RETURNS["associated"], np.random.default_rng(5)
    strain = rng.uniform(-1.0, 1.0, (300, 3)) * 0.01
    stress, _ = one_step(law, strain)
    found, trial = principal(stress), principal(stress_of(law, strain[:, None] * np.eye(3)))
    others = trial[:, None] + rng.normal(size=(300, 400, 3)) * np.linalg.norm(trial - found, axis=1)[:, None, None]
    near = found[:, None] + rng.normal(size=(300, 400, 3)) * 10.0
    law_energy = _energy(law)
    for candidates in (others, near):
        admissible = law.yield_function(candidates[..., None] * np.eye(3), np.zeros((1, 2))) <= 0.0
        further = law_energy(candidates - trial[:, None]) - law_energy(found - trial)[:, None]
        assert admissible.sum() > 1000
        assert further[admissible].min() > -1e-12 * law_energy(trial).max()


def _energy(law):
    def energy(stress):
        mean = stress.mean(axis=-1, keepdims=True)
        shear = ((stress - mean) ** 2).sum(axis=-1) / (4.0 * law.shear_modulus)
        return shear + mean[..., 0] ** 2 / (2.0 * law.bulk_modulus)

    return energy


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_repeated_stresses_have_no_preferred_axes(precision):
    law = changed(SOIL_30, dilation_angle=8.0)
    eps = 1.2e-7 if precision == "f32" else 2.2e-16
    for strain in ((-0.01, 0.004, 0.004), (-0.01, -0.01, 0.004), (0.002, 0.002, 0.002), (-0.01, 0.004, 0.004 + 1e-9)):
        plain, _ = one_step(law, strain, precision)
        assert not (plain[0] - np.diag(np.diag(plain[0]))).any()
        for Q in random_rotations(20, np.random.default_rng(2)):
            A = Q @ np.diag(np.expm1(strain)) @ Q.T
            update = StressUpdate(law, 3, precision)
            turned = unpack(update(np.zeros((1, 6)), update.initial_state(1), A[None]).stress[0].astype(float))
            # strains of 0.01 know their axes to one rounding, times the P-wave modulus
            np.testing.assert_allclose(turned, Q @ plain[0] @ Q.T, atol=0.01 * 30 * eps * law.bulk_modulus)


def test_straight_steps_of_any_size_are_exact():
    target = np.array([-0.02, 0.004, 0.011])
    F = diagonal(*(x * np.linspace(0.0, 1.0, 401)[1:] for x in target))
    for law in (RETURNS["dilating"], RETURNS["associated"]):
        path = MaterialPoint(law).drive(F)
        single, _ = one_step(law, target)
        np.testing.assert_allclose(single[0], path.kirchhoff[-1], atol=1e-7)  # 400 steps of round-off of 1e5


# --- Separation ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_sand_pulled_apart_carries_nothing_until_closed(precision):
    t = np.concatenate(
        [np.linspace(0.0, -0.01, 6)[1:], np.linspace(-0.01, 0.05, 13)[1:], np.linspace(0.05, -0.01, 13)[1:]]
    )
    path = MaterialPoint(SAND, precision).drive(diagonal(t / 3.0, t / 3.0, t / 3.0))
    atol = 1e-9 if precision == "f64" else 20.0  # strains of 1e-2 in float32: 1e-6 of K
    np.testing.assert_allclose(path.p, np.maximum(-SAND.bulk_modulus * t, 0.0), atol=atol)
    np.testing.assert_allclose(path.state[:, 1], np.maximum(t, 0.0), atol=1e-14 if precision == "f64" else 1e-6)
    assert path.dissipation[-1] == 0.0


def test_cohesive_soil_keeps_the_apex_stress():
    t = np.array([0.02, 0.03, 0.025])
    path = MaterialPoint(SOIL_30).drive(diagonal(t / 3.0, t / 3.0, t / 3.0))
    apex = SOIL_30.tensile_apex
    np.testing.assert_allclose(path.p, [-apex, -apex, -apex + 0.005 * SOIL_30.bulk_modulus], rtol=1e-12)
    assert not path.state[:, 1].any()


@pytest.mark.parametrize(
    "values",
    [
        {"friction_angle": 90.0},
        {"friction_angle": -1.0},
        {"dilation_angle": 31.0},
        {"cohesion": -1.0},
        {"friction_angle": 0.0, "cohesion": 0.0},
    ],
)
def test_impossible_strengths_are_refused(values):
    with pytest.raises(ValidationError):
        changed(SOIL_30, **values)
