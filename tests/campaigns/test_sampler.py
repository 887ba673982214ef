"""The sampler of the calibration on a case with a known posterior, without runs."""

import numpy as np
import pytest

from snowmpm.campaigns.calibration import Sampler


def searched(distance, d=1, particles=400, seed=3, generations=12):
    sampler = Sampler(d, particles, seed)
    for _ in range(generations):
        u = sampler.propose()
        sampler.take(u, distance(u))
    return sampler


def test_posterior_of_a_uniform_error_is_uniform():
    """|u - 0.4| <= eps with a uniform prior: every share within eps of 0.4 is as likely, whatever the way there."""
    found = searched(lambda u: np.abs(u[:, 0] - 0.4), generations=4)
    eps = found.distances.max()
    weights = found.weights / found.weights.sum()
    mean = weights @ found.u[:, 0]
    deviation = np.sqrt(weights @ (found.u[:, 0] - mean) ** 2)
    assert mean == pytest.approx(0.4, abs=0.15 * eps)
    assert deviation == pytest.approx(eps / np.sqrt(3.0), rel=0.1)


def test_weights_undo_where_samples_were_drawn():
    """Near the edge of the prior the posterior is cut, not mirrored: uniform over 0 to eps."""
    found = searched(lambda u: u[:, 0], generations=4)
    eps = found.distances.max()
    assert found.weights @ found.u[:, 0] / found.weights.sum() == pytest.approx(0.5 * eps, rel=0.08)


def test_two_parameters_of_which_only_the_sum_is_seen():
    found = searched(lambda u: np.abs(u.sum(axis=1) - 1.0), d=2, generations=5)
    assert np.corrcoef(found.u.T)[0, 1] < -0.9
    assert np.ptp(found.u[:, 0]) > 0.8


def test_failed_runs_never_stay_and_seeds_repeat():
    def distance(u):
        return np.where(u[:, 0] > 0.5, np.inf, np.abs(u[:, 0] - 0.45))

    one, again = searched(distance, particles=40), searched(distance, particles=40)
    assert (one.u <= 0.5).all() and np.array_equal(one.u, again.u) and np.array_equal(one.weights, again.weights)
