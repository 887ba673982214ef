"""The update of hypoplastic laws: order, rotation, precision and work, against an integration of the rate."""

import numpy as np
import pytest
from hypoplastic_laws import DENSE, LAWS, SAND, STRESS, by_law, followed, stretching
from hypoplastic_reference import jaumann
from parameter_sets import changed, random_rotations, stiffness_of
from scipy.linalg import expm

from snowmpm.materials import StressUpdate, pack, unpack

SYMMETRIC = 3.0 * np.array([[-0.003, 0.001, 0.0], [0.001, 0.002, 0.0005], [0.0, 0.0005, -0.001]])
SHEAR = np.array([[-0.004, 0.05, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -0.002]])


def errors_over_steps(law, L, counts):
    exact, void_ratio = jaumann(law, STRESS, L)
    errors = []
    for steps in counts:
        path = followed(law, STRESS, stretching(L, steps))
        errors.append(np.abs(unpack(path.h[0, -1]) - exact).max() / np.abs(exact).max())
        assert path.state[0, -1, 0] == pytest.approx(void_ratio, rel=1e-11)
    return np.array(errors)


@by_law
def test_substeps_are_of_third_order(law):
    # Without error control each step is one sub-step; no rotation, so nothing else is left
    errors = errors_over_steps(changed(law, tolerance=1e9), SYMMETRIC, (16, 32, 64, 128))
    orders = np.log2(errors[:-1] / errors[1:])
    assert (np.abs(orders - 3.0) < 0.2).all() and errors[-1] < 1e-6


@by_law
def test_turning_stretch_differs_from_jaumann_by_second_order(law):
    errors = errors_over_steps(changed(law, tolerance=1e-9), SHEAR, (32, 64, 128))
    orders = np.log2(errors[:-1] / errors[1:])
    assert (np.abs(orders - 2.0) < 0.25).all() and errors[-1] < 1e-5


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
@by_law
def test_error_control_keeps_its_tolerance(law, tolerance):
    errors = errors_over_steps(changed(law, tolerance=tolerance), 2.0 * SYMMETRIC, (1, 3))
    assert errors.max() < 10.0 * tolerance  # of a sub-step; ten or more of them, most of which the path forgets


@by_law
def test_rotation_is_exact(law):
    rng = np.random.default_rng(4)
    update = StressUpdate(law)
    Q = random_rotations(200, rng)
    h = np.tile(pack(STRESS), (200, 1))
    turned = update(h, update.initial_state(200), Q - np.eye(3))
    np.testing.assert_allclose(unpack(turned.h), Q @ STRESS @ Q.transpose(0, 2, 1), atol=1e-12 * 1e4)
    assert not turned.dissipation.any() or np.abs(turned.dissipation).max() < 1e-9
    # superposed on a stretch
    f = expm(SHEAR)
    plain = update(h[:1], update.initial_state(1), f[None] - np.eye(3))
    both = update(h, update.initial_state(200), Q @ f - np.eye(3))
    np.testing.assert_allclose(unpack(both.h), Q @ unpack(plain.h[0]) @ Q.transpose(0, 2, 1), atol=1e-9 * 1e4)
    np.testing.assert_allclose(both.state, np.tile(plain.state, (200, 1)), rtol=1e-12, atol=1e-15)


def test_superposed_rotation_along_a_path():
    # Validation T1.6a: compression in 100 increments with a rotation Θ on top
    expected = None
    for turn in (0.0, 1.0, 2.0 * np.pi, 20.0 * np.pi):
        F = []
        for s in np.linspace(0.0, 1.0, 101):
            c, z = np.cos(turn * s), np.sin(turn * s)
            F.append(np.array([[c, -z, 0], [z, c, 0], [0, 0, 1.0]]) @ np.diag([np.exp(-0.01 * s), 1.0, 1.0]))
        F = np.array(F)
        path = followed(SAND, -1e4 * np.diag([1.0, 0.7, 0.7]), F[1:] @ np.linalg.inv(F[:-1]) - np.eye(3))
        principal = np.linalg.eigvalsh(unpack(path.h[0, -1]))
        expected = principal if expected is None else expected
        np.testing.assert_allclose(principal, expected, rtol=1e-9)  # same sub-steps but for rounding of 100 rotations


@by_law
def test_homogeneous_in_stress_and_rate_independent(law):
    path = followed(law, STRESS, stretching(SHEAR, 10))
    update = StressUpdate(law)
    slow = update.integrate(pack(STRESS)[None], update.initial_state(1), stretching(SHEAR, 10)[None], dt=1e3)
    np.testing.assert_array_equal(path.h, slow.h)
    if law is DENSE:  # its density factor knows the pressure
        return
    apex = law.tensile_apex * np.eye(3)
    scaled = followed(law, 7.0 * (STRESS - apex) + apex, stretching(SHEAR, 10))
    apex = law.tensile_apex * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(scaled.h - apex, 7.0 * (path.h - apex), rtol=1e-10)


@by_law
def test_plane_strain_is_the_same_law(law):
    L = SHEAR * [[1, 1, 0], [1, 1, 0], [0, 0, 0]]
    stress = STRESS * [[1, 1, 0], [1, 1, 0], [0, 0, 1]]
    space = followed(law, stress, stretching(L, 5))
    plane = followed(law, stress, stretching(L, 5)[:, :2, :2], dimension=2)
    np.testing.assert_allclose(plane.h, space.h[..., :4], rtol=1e-11)
    np.testing.assert_allclose(plane.stress, space.stress[..., :4], rtol=1e-11)
    np.testing.assert_allclose(plane.state, space.state, rtol=1e-13)


@by_law
def test_float32_follows_float64(law):
    for L in (SYMMETRIC, SHEAR):
        double = followed(law, STRESS, stretching(L, 20))
        single = followed(law, STRESS, stretching(L, 20), "f32")
        # Rounding of f (1e-7) times the growth of stress with strain (1500), and other sub-steps
        np.testing.assert_allclose(single.h, double.h, atol=1e-3 * np.abs(double.h).max())
        assert (single.iterations > 0).all()


@by_law
def test_kirchhoff_stress_void_ratio_and_work(law):
    path = followed(law, STRESS, stretching(SHEAR, 200))
    volume = np.exp(np.trace(SHEAR) * np.arange(1, 201) / 200)
    np.testing.assert_allclose(1.0 + path.state[0, :, 0], (1.0 + law.void_ratio) * volume, rtol=1e-12)
    np.testing.assert_allclose(path.stress[0], path.h[0] * volume[:, None], rtol=1e-12)
    D = 0.5 * (SHEAR + SHEAR.T) / 200
    tau = np.concatenate([pack(STRESS)[None], path.stress[0]])
    power = np.einsum("nij,ij->n", unpack(tau), D)
    work = 0.5 * (power[1:] + power[:-1])
    np.testing.assert_allclose(path.dissipation[0], work, atol=2e-3 * np.abs(work).max())  # more trapezoids
    assert not law.elastic_energy(path.stress[0], path.state[0]).any()
    unloaded = followed(law, STRESS, stretching(np.diag([0.001, 0.0, 0.0]), 1))
    assert unloaded.dissipation[0, 0] < 0.0 and not law.DISSIPATIVE


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_impossible_and_excessive_steps_are_reported_and_left_out(dimension, precision):
    bad = [np.full((3, 3), np.nan), np.diag([np.inf, 0, 0]), np.diag([-2.5, 0, 0]), np.diag([-1.0, 0, 0])]
    bad += [np.diag([np.expm1(-5.0), 0, 0]), np.zeros((3, 3))]
    update = StressUpdate(SAND, dimension, precision)
    h = np.tile(pack(STRESS, dimension), (6, 1))
    result = update(h, update.initial_state(6), np.array(bad)[:, :dimension, :dimension])
    np.testing.assert_array_equal(result.iterations, [-1, -1, -1, -1, -1, 0])
    for array in (result.h, result.stress, result.state):
        np.testing.assert_array_equal(array, np.tile(array[-1:], (6, 1)))
    poisoned = update(np.full(h[:1].shape, np.nan), update.initial_state(1), np.zeros((1, dimension, dimension)))
    assert poisoned.iterations[0] == -1
    opened = update(h[:1], update.initial_state(1), np.diag([20.0] * dimension)[None])
    assert opened.iterations[0] >= 0 and not opened.h.any()


def test_contract():
    assert np.isnan(SAND.hencky_from_stress(STRESS)).all()
    np.testing.assert_array_equal(SAND.h_from_stress(STRESS), STRESS)
    for law in LAWS.values():
        assert type(law)(**law.model_dump()) == law
        fields = law.outputs(np.tile(law.initial_state(), (4, 1)))
        assert set(fields) == set(law.OUTPUTS)
        np.testing.assert_array_equal(fields["void_ratio"], law.void_ratio)
        assert len(law.initial_state()) == len(law.STATE)


@by_law
def test_wave_speed_bounds_the_stiffness_of_every_direction(law):
    rng = np.random.default_rng(11)
    n = 2000
    update = StressUpdate(law)
    principal = -1e4 * rng.uniform(0.5, 1.0, (n, 3))
    Q = random_rotations(n, rng)
    stress = Q @ (principal[:, :, None] * np.eye(3)) @ Q.transpose(0, 2, 1)
    state = update.initial_state(n)
    if law is DENSE:
        state[:, 0] = rng.uniform(0.5, 0.8, n)
    J = (1.0 + state[:, 0]) / (1.0 + law.void_ratio)
    bound = law.density / J * law.wave_speed_at(pack(stress) * J[:, None], state) ** 2
    for sign in (1e-7, -1e-7):
        after = update(pack(stress), state, np.tile(np.diag([sign, 0.0, 0.0]), (n, 1, 1)))
        stiffness = (after.h[:, 0] - pack(stress)[:, 0]) / sign
        assert (stiffness <= bound * (1.0 + 1e-3)).all()  # of a difference over 1e-7, and its curvature
        assert (stiffness > 0.0).all()
    kernel = stiffness_of(law, pack(stress) * J[:, None], state) / J
    assert (kernel >= bound * (1.0 - 1e-9)).all() and (kernel < 1.5 * bound).all()  # its largest stress is a bound
