"""Rate of shear, inertial number and regime of grains."""

import numpy as np
import pytest

from snowmpm.particles.regimes import inertial_number, regime, steady_fraction, strain_rate


def test_the_rate_of_simple_shear_is_the_shear_rate_in_two_and_three_dimensions():
    assert strain_rate(np.array([[0.0, 3.0, 0.0, 0.0]])) == pytest.approx([3.0])
    assert strain_rate(np.array([[0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])) == pytest.approx([3.0])


def test_turning_and_swelling_alike_along_all_axes_are_no_shear():
    turning, swelling = np.array([[0.0, -2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]]), 0.7 * np.eye(3).reshape(1, 9)
    assert strain_rate(np.concatenate([turning, swelling])) == pytest.approx([0.0, 0.0], abs=1e-7)


def test_plane_strain_is_that_of_three_dimensions():
    rng = np.random.default_rng(1)
    plane = rng.standard_normal((5, 2, 2))
    solid = np.zeros((5, 3, 3))
    solid[:, :2, :2] = plane
    assert strain_rate(plane.reshape(5, 4)) == pytest.approx(strain_rate(solid.reshape(5, 9)))


def test_inertial_numbers_and_regimes():
    number = inertial_number(np.array([2.0, 2.0, 2.0, 0.0]), np.array([2500.0, 0.0, -5.0, 10.0]), np.full(4, 0.01),
                             np.full(4, 2500.0))
    assert number == pytest.approx([0.02, 0.0, 0.0, 0.0])
    assert regime(np.array([0.0, 1e-4, 0.02, 0.5])).tolist() == [0.0, 1.0, 2.0, 3.0]


def test_grains_are_looser_the_faster_they_are_sheared():
    assert steady_fraction(np.array([0.0, 0.1, 1.0, 5.0])) == pytest.approx([0.6, 0.59, 0.5, 0.5])
    assert steady_fraction(np.array([0.2]), 0.8, 0.6) == pytest.approx([0.76])
