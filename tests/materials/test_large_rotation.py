"""What rotation may not do: change the stress of a body that only turns, in any storage and any number of turns."""

import numpy as np
import pytest
from parameter_sets import W2, A, oedometer, random_rotations, simple_shear
from scipy.linalg import logm

from snowmpm.materials import MaterialPoint, StressUpdate, unpack


def turned(F, angle):
    """F with a rotation about the third axis superposed that grows to `angle` along the path."""
    theta = np.linspace(0.0, angle, len(F) + 1)[1:]
    R = np.tile(np.eye(3), (len(F), 1, 1))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(theta)
    R[:, 0, 1], R[:, 1, 0] = -np.sin(theta), np.sin(theta)
    return R @ F, R


F_OEDOMETER = oedometer(np.linspace(0.0, 0.02, 101)[1:])


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.0 * np.pi, 20.0 * np.pi])
def test_superposed_rotation_leaves_invariants(angle):
    still = MaterialPoint(A).drive(F_OEDOMETER)
    F, R = turned(F_OEDOMETER, angle)
    path = MaterialPoint(A).drive(F)
    # Reference of an independent backward Euler in 100 steps, nine digits printed
    np.testing.assert_allclose((path.p[-1], path.q[-1]), (35341.6782, 25272.0737), rtol=2e-9)
    assert path.state[-1, 0] == pytest.approx(0.017863041, abs=1e-9)
    # Against the same path unturned: round-off of 100 steps of f, 2e-16 each on a strain of 0.01
    np.testing.assert_allclose(path.p, still.p, rtol=1e-12)
    np.testing.assert_allclose(path.kirchhoff, R @ still.kirchhoff @ R.transpose(0, 2, 1), atol=1e-11 * still.p[-1])


@pytest.mark.parametrize(("order", "p"), [(1, 20518.3538), (2, 35341.6782)])
def test_first_order_increments_lose_pressure(order, p):
    # f = I + L swells a turning body: 42 % of the pressure is gone after one radian in 100 steps. To second order
    # (f = I + L + L²/2, what the solver does) a drift of theta^4/8 a step is left.
    F = np.concatenate([np.eye(3)[None], turned(F_OEDOMETER, 1.0)[0]])
    L = np.array([logm(f).real for f in F[1:] @ np.linalg.inv(F[:-1])])
    increments = L if order == 1 else L + 0.5 * L @ L
    update = StressUpdate(A)
    result = update.integrate(np.zeros((1, 6)), update.initial_state(1), increments[None])
    found = -np.trace(unpack(result.stress[0, -1])) / 3.0
    assert found == pytest.approx(p, rel=1e-3)


@pytest.mark.parametrize(("order", "stays"), [(1, False), (2, True)])
def test_a_full_turn_keeps_the_stress(order, stays):
    # 100 steps a radian through 2 pi, at constant strain after a compression to 2 %: the second order keeps the stress
    # to 0.1 %, the first one ends without any
    compression = np.array([logm(f).real for f in np.tile(np.diag([0.02 / -100.0, 0.0, 0.0]), (100, 1, 1)) + np.eye(3)])
    turn = np.zeros((628, 3, 3))
    turn[:, 0, 1], turn[:, 1, 0] = -2.0 * np.pi / 628, 2.0 * np.pi / 628
    L = np.concatenate([compression, turn])
    increments = L if order == 1 else L + 0.5 * L @ L
    update = StressUpdate(A)
    stress = unpack(update.integrate(np.zeros((1, 6)), update.initial_state(1), increments[None]).stress[0])
    before, after = stress[99], stress[-1]
    if stays:
        np.testing.assert_allclose(after, before, atol=1e-3 * np.abs(before).max())
    else:
        assert np.abs(after).max() < 0.05 * np.abs(before).max()


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("law", [A, W2], ids=["A", "W2"])
def test_stress_turns_with_the_body(law, precision):
    # tau(Q F) = Q tau(F) Qᵀ for a fixed random Q, the first step included: a rotation of any angle in one step
    path = simple_shear(law, 0.5 * law.p0, np.linspace(0.0, 0.3, 40)[1:])
    plain = MaterialPoint(law, precision).drive(path)
    for Q in random_rotations(10, np.random.default_rng(1)):
        rotated = MaterialPoint(law, precision).drive(Q @ path)
        scale = np.abs(plain.kirchhoff).max()
        # 40 steps; float64 to 1e-13 a step, float32 stores entries of h of 0.01 with 1e-9: 1e-7 of the stress a step
        tolerance = 4e-12 if precision == "f64" else 2e-4
        np.testing.assert_allclose(rotated.kirchhoff, Q @ plain.kirchhoff @ Q.T, atol=tolerance * scale)


def test_repeated_and_nearly_repeated_stretches():
    # q = 0, then two equal stretches, then a gap of 1e-9: no direction of the deviator is preferred by round-off
    for stretches in ((0.99, 0.99, 0.99), (0.99, 0.99, 0.98), (0.99, 0.99 + 1e-9, 0.98)):
        F = np.diag(stretches)
        plain = MaterialPoint(A).drive(F[None]).kirchhoff[0]
        assert np.abs(plain - np.diag(np.diagonal(plain))).max() == 0.0
        for Q in random_rotations(20, np.random.default_rng(2)):
            rotated = MaterialPoint(A).drive((Q @ F @ Q.T)[None]).kirchhoff[0]
            np.testing.assert_allclose(rotated, Q @ plain @ Q.T, atol=1e-13 * A.bulk_modulus)  # strains of 1e-13
