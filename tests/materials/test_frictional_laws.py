"""What holds for every frictional law at every state: random steps, full tensors, 3-D and plane strain."""

import numpy as np
import pytest
from frictional_laws import COUNT, LAWS, random_steps, stress_of
from parameter_sets import random_rotations
from round_off import representable

from snowmpm.materials import StressUpdate, pack, unpack
from snowmpm.materials.symmetric import invariants

everything = pytest.mark.parametrize("name", LAWS)
precisions = pytest.mark.parametrize("precision", ["f32", "f64"])
GAP = 1  # column of the state, where a law has one


def separated(steps):
    return steps.state[:, GAP] > 0.0 if steps.state.shape[1] > 1 else np.zeros(COUNT, bool)


@precisions
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [1e-3, 0.05, 5.0])
@everything
def test_admissible_and_finite(name, size, dimension, precision):
    steps = random_steps(name, size, dimension, precision)
    law, result = steps.law, steps.result
    for array in (result.h, result.stress, result.state, result.dissipation):
        assert np.isfinite(array).all()
    # Left out are only steps to a strain that float32 cannot represent; they leave everything as it was
    f = np.tile(np.eye(3), (COUNT, 1, 1))
    f[:, :dimension, :dimension] += steps.A
    made = result.iterations >= 0
    assert made[representable(f, np.eye(3) + steps.h, precision, dimension)].all() and made.mean() > 0.6
    np.testing.assert_array_equal(unpack(result.h[~made].astype(float)), steps.h[~made])
    assert result.iterations.max() <= 25 and (result.iterations > 0).mean() > 0.02
    assert result.dissipation.min() >= 0.0
    stress = steps.stress()
    scale = np.abs(stress).max(axis=(1, 2)) + 1e3
    # Float32: twenty roundings of the larger of p and q
    tolerance = 1e-9 if precision == "f64" else 3e-6
    assert (law.yield_function(stress, result.state.astype(float)) / scale).max() < tolerance


@pytest.mark.parametrize("dimension", [2, 3])
@everything
def test_elastic_inside(name, dimension):
    steps = random_steps(name, 1e-3, dimension)
    stress = stress_of(steps.law, steps.trial)
    at_rest = steps.state.copy()
    if steps.law.RATE_DEPENDENT:
        at_rest[:, 2] = 0.0  # only the strength at rest bounds the elastic range
    inside = ~separated(steps) & (steps.law.yield_function(stress, at_rest) < -1e-6)
    assert inside.sum() > 50
    result = steps.result
    assert not result.iterations[inside].any() and not result.dissipation[inside].any()
    columns = slice(0, 2)
    np.testing.assert_array_equal(result.state[inside, columns], steps.state[inside, columns])
    # Round-off of logarithms of stretches of 1 %
    np.testing.assert_allclose(steps.stress()[inside], stress[inside], atol=1e-13 * steps.law.bulk_modulus)
    outside = ~separated(steps) & (steps.law.yield_function(stress, at_rest) > 1e-6)
    assert outside.sum() > 50 and (result.iterations[outside] > 0).all()


@precisions
@pytest.mark.parametrize("name", [n for n in LAWS if not LAWS[n].RATE_DEPENDENT])  # which relax as time goes on
def test_idempotent(name, precision):
    steps = random_steps(name, 0.05, precision=precision)
    first = steps.result
    again = StressUpdate(steps.law, 3, precision)(first.h, first.state, np.zeros((COUNT, 3, 3)))
    eps = np.finfo(first.h.dtype).eps
    # exp and ln leave 10 eps of a strain of 0.1, times the P-wave modulus 1.35 K
    np.testing.assert_allclose(again.stress, first.stress, atol=20 * eps * 0.1 * steps.law.bulk_modulus)
    np.testing.assert_allclose(again.state, first.state, atol=20 * eps * 0.1 + 2 * eps * np.abs(first.state).max())
    assert again.iterations.max() <= (8 if "softening" in name else 1)


@everything
def test_dissipation_is_the_work_of_the_final_stress(name):
    steps = random_steps(name, 0.05)
    work = np.einsum("nij,nij->n", steps.stress(), steps.plastic())
    kept = ~separated(steps)
    assert kept.sum() > 500
    # Against the largest product of stress and strain in the sample, where the round-off of its terms comes from
    scale = np.abs(stress_of(steps.law, steps.trial)).max() * 0.1
    np.testing.assert_allclose(steps.result.dissipation[kept], work[kept], atol=1e-12 * scale)


@everything
def test_plastic_strain_adds_up(name):
    steps = random_steps(name, 0.05)
    kept = ~separated(steps)
    _, shear = invariants(steps.plastic())
    grown = steps.result.state[:, 0] - steps.state[:, 0]
    expected = shear * 2.0 / 3.0  # invariants() of a strain gives √(3/2 e:e)
    if name in ("DP softening", "softening cone, cohesive"):  # in which opening at the apex counts too
        dilation = np.trace(steps.plastic(), axis1=1, axis2=2)
        opened = steps.result.state[:, GAP] - steps.state[:, GAP]  # what broke no bonds any more
        expected = expected - opened + np.maximum(dilation - steps.law.alpha_psi * expected, 0.0)
    np.testing.assert_allclose(grown[kept], expected[kept], atol=1e-13)  # round-off of strains of 0.1


@pytest.mark.parametrize("name", [name for name in LAWS if name.startswith(("von", "DP", "mu"))])
def test_flow_follows_the_potential(name):
    # Deviator along s; dilation alpha_psi times the shear on the cone, at least that at the apex
    steps = random_steps(name, 0.05)
    plastic, stress = steps.plastic(), steps.stress()
    p, q = invariants(stress)
    shear = invariants(plastic)[1] * 2.0 / 3.0
    dilation = np.trace(plastic, axis1=1, axis2=2)
    flows = ~separated(steps) & (steps.result.iterations > 0) & (shear > 1e-6)
    # on the cone, away from its apex: near it q has no direction left
    cone = flows & (q > 1e-3 * np.abs(stress).max())
    assert cone.sum() > 300
    slope = getattr(steps.law, "alpha_psi", 0.0)
    varies = hasattr(steps.law, "dilatancy_at")  # by rate and packing: along paths, in test_mu_phi_i.py
    if not varies:
        np.testing.assert_allclose(dilation[cone], slope * shear[cone], atol=1e-13)  # round-off of strains of 0.1
    deviator = stress + p[:, None, None] * np.eye(3)
    expected = 1.5 * (shear / np.maximum(q, 1e-300))[:, None, None] * deviator
    found = plastic - dilation[:, None, None] / 3.0 * np.eye(3)
    np.testing.assert_allclose(found[cone], expected[cone], atol=1e-11)  # the same over a q of 1e-3 of the stress
    apex = flows & (q == 0.0)
    if not name.startswith("von"):
        assert apex.sum() > 50
        assert varies or (dilation[apex] >= slope * shear[apex] - 1e-13).all()


@precisions
@everything
def test_isotropic(name, precision):
    steps = random_steps(name, 0.05, precision=precision)
    Q = random_rotations(COUNT, np.random.default_rng(9))
    Qt = Q.transpose(0, 2, 1)
    turned = StressUpdate(steps.law, 3, precision)(pack(Q @ steps.h @ Qt), steps.state, Q @ steps.A @ Qt, 1e-3)
    eps = np.finfo(steps.result.h.dtype).eps
    expected = Q @ steps.stress() @ Qt
    # Round-off of stretches between rotations of any angle: entries of order 1, as strain times the P-wave modulus
    stiffest = steps.law.bulk_modulus
    if name == "mu(I), phi(I)":  # dilation that goes on in a step makes pressure of shear
        stiffest *= steps.law.tangent_over_elastic
    np.testing.assert_allclose(unpack(turned.stress), expected, atol=60 * eps * stiffest)


@precisions
@everything
def test_plane_strain_is_the_three_dimensional_law(name, precision):
    steps = random_steps(name, 0.05, 2, precision)
    A = np.zeros((COUNT, 3, 3))
    A[:, :2, :2] = steps.A
    space = StressUpdate(steps.law, 3, precision)(pack(steps.h), steps.state, A, 1e-3)
    eps = np.finfo(space.h.dtype).eps
    # Principal axes of a plane state lie in the plane to round-off
    assert np.abs(space.stress[:, 4:]).max() < 10 * eps * steps.law.bulk_modulus
    assert np.abs(space.h[:, 4:]).max() < 10 * eps
    np.testing.assert_allclose(steps.result.stress, space.stress[:, :4], atol=60 * eps * steps.law.bulk_modulus)
    np.testing.assert_allclose(steps.result.h, space.h[:, :4], atol=60 * eps)
    np.testing.assert_allclose(steps.result.state[:, :2], space.state[:, :2], atol=60 * eps)


@everything
def test_float32_follows_float64(name):
    double = random_steps(name, 0.05)
    single = random_steps(name, 0.05, precision="f32")
    # The step turns by any angle, so terms of order 1 are rounded to 1e-7, whatever the strain
    np.testing.assert_allclose(single.stress(), double.stress(), atol=2e-6 * double.law.bulk_modulus)
    np.testing.assert_allclose(single.result.state[:, :2], double.result.state[:, :2], atol=4e-6)


@precisions
@pytest.mark.parametrize("dimension", [2, 3])
@everything
def test_impossible_steps_leave_everything_as_it_was(name, dimension, precision):
    law = LAWS[name]
    broken = [
        np.full((3, 3), np.nan),
        np.diag([0.0, np.inf, 0.0]),
        np.diag([-2.5, 0.0, 0.0]),
        np.diag([-1.0, 0.0, 0.0]),
    ]
    A = np.array(broken)[:, :dimension, :dimension]
    # On the surface, and with a gap that a step without meaning may not close
    h = pack(law.h_from_stress(np.diag([-5e3, -4e3, -4e3])), dimension)
    update = StressUpdate(law, dimension, precision)
    for state in (update.initial_state(4), update.initial_state(4) + 0.01):
        result = update(np.tile(h, (4, 1)), state, A)
        np.testing.assert_array_equal(result.iterations, -1)
        np.testing.assert_array_equal(result.h, np.tile(h, (4, 1)).astype(result.h.dtype))
        np.testing.assert_array_equal(result.state, state.astype(result.state.dtype))
        # Float32: 6e-8 of 1 on strains of 1e-4, times the P-wave modulus
        expected = np.tile(np.diag([-5e3, -4e3, -4e3]), (4, 1, 1))
        np.testing.assert_allclose(unpack(result.stress), expected, atol=2.0 if precision == "f32" else 1e-8)
        assert not result.dissipation.any()
