"""The elastic tensor of a sample: layers in closed form, bounds, work, and what floats."""

import numpy as np
import pytest

from snowmpm.micro.elasticity import elastic_tensor
from snowmpm.micro.sample import Sample
from snowmpm.micro.study import UNITS, examine

SOFT, FIRM = (1e9, 0.2), (9e9, 0.3)


def moduli(young, poisson):
    """Bulk and shear modulus."""
    return young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


def test_layers_have_the_moduli_of_backus():
    """Layers of two materials, exactly (Backus 1962, doi:10.1029/JZ067i011p04427)."""
    image = np.ones((3, 2, 8), int)
    image[:, :, 5:] = 2
    found = elastic_tensor(image, [(0.0, 0.0), FIRM, SOFT], 1e-10)
    shares, mu = np.array([5.0, 3.0]) / 8.0, np.array([moduli(*one)[1] for one in (FIRM, SOFT)])
    lame = np.array([moduli(*one)[0] for one in (FIRM, SOFT)]) - 2.0 / 3.0 * mu
    p = lame + 2.0 * mu
    c33 = 1.0 / (shares @ (1.0 / p))
    c13 = (shares @ (lame / p)) * c33
    c11 = shares @ (p - lame**2 / p) + (shares @ (lame / p)) ** 2 * c33
    c66 = shares @ mu
    expected = np.diag([c11, c11, c33, *[1.0 / (shares @ (1.0 / mu))] * 2, c66])
    expected[0, 1] = expected[1, 0] = c11 - 2.0 * c66
    expected[:2, 2] = expected[2, :2] = c13
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-8 * c11)


@pytest.fixture(scope="module")
def mixed():
    image = np.kron(np.random.default_rng(4).integers(1, 3, (5, 5, 5)), np.ones((3, 3, 3), int))
    return image, elastic_tensor(image, [(0.0, 0.0), FIRM, SOFT], 1e-6)


def test_a_mixture_lies_between_the_bounds_of_hashin_and_shtrikman(mixed):
    """doi:10.1016/0022-5096(63)90060-7; three bricks across each piece."""
    image, found = mixed
    share = float((image == 1).mean())
    (K1, G1), (K2, G2) = moduli(*FIRM), moduli(*SOFT)

    def bound(K_a, G_a, K_b, G_b, b):
        a = 1.0 - b
        K = K_a + b / (1.0 / (K_b - K_a) + 3.0 * a / (3.0 * K_a + 4.0 * G_a))
        return K, G_a + b / (1.0 / (G_b - G_a) + 6.0 * a * (K_a + 2.0 * G_a) / (5.0 * G_a * (3.0 * K_a + 4.0 * G_a)))

    assert np.ptp(found.confined) < 0.1 * found.confined.max()  # hardly a direction
    upper, lower = bound(K1, G1, K2, G2, 1.0 - share), bound(K2, G2, K1, G1, share)
    measured = moduli(*found.isotropic)
    for low, value, high in zip(lower, measured, upper, strict=True):
        assert low < value < high


def test_work_of_the_means_is_the_mean_work(mixed):
    """Hill and Mandel, and a symmetric, positive tensor."""
    _, found = mixed
    np.testing.assert_allclose(found.work, found.stiffness, atol=1e-6 * found.stiffness.max())
    np.testing.assert_allclose(found.stiffness, found.stiffness.T, atol=1e-5 * found.stiffness.max())
    assert np.linalg.eigvalsh(found.stiffness).min() > 0.0 and found.remaining.max() < 1e-6


def test_what_floats_carries_nothing_and_a_column_all_of_its_share():
    ice = np.zeros((6, 6, 6), bool)
    ice[1:3, 1:3, :] = True
    ice[4, 4, 4] = True
    found = elastic_tensor(ice, (1e9, 0.3), 1e-9)
    assert found.confined == pytest.approx([0.0, 0.0, 1e9 * 4.0 / 36.0], abs=1e2, rel=1e-6)
    assert not elastic_tensor(np.zeros((4, 4, 4), bool)).stiffness.any()


def test_the_record_of_a_sample_holds_the_stiffness():
    ice = np.zeros((8, 8, 8), bool)
    ice[2:6, 2:6, :] = ice[2:6, :, 2:6] = ice[:, 2:6, 2:6] = True
    record, _ = examine(Sample(ice, 1e-4), axes=(0,), stiffness=True)
    confined = np.array(record["confined_modulus"])
    assert confined == pytest.approx(np.full(3, confined[0])) and 0.25 * 9.5e9 < confined[0] < 0.5 * 14.1e9
    assert record["stiffness_imbalance"] < 1e-4 and UNITS["stiffness"] == "Pa"
