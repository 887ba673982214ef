"""Fixed points of linear and kinked maps, where plain iterations diverge."""

import numpy as np
import pytest

from snowmpm.components.structures.quasi_newton import ROUNDS, TOLERANCE, QuasiNewton

RANDOM = np.random.default_rng(5)


def heavy(size=12, ratio=4.0):
    """A linear map whose answer is up to `ratio` times what it is asked, the other way."""
    Q = np.linalg.qr(RANDOM.normal(size=(size, size)))[0]
    return -Q @ np.diag(np.linspace(0.1, ratio, size)) @ Q.T, RANDOM.normal(size=size)


def test_plain_iterations_diverge_and_it_does_not():
    A, b = heavy()
    exact = np.linalg.solve(np.eye(len(b)) - A, b)
    plain = np.zeros(len(b))
    for _ in range(ROUNDS):
        plain = A @ plain + b
    assert np.linalg.norm(plain) > 1e6
    x, rounds, settled = QuasiNewton(len(b)).solve(lambda x: A @ x + b, b, 0.0)
    assert settled and rounds <= len(b) + 2
    assert x == pytest.approx(exact, abs=5.0 * TOLERANCE * np.linalg.norm(b))


def test_what_was_learnt_serves_the_next_step():
    A, b = heavy()
    newton = QuasiNewton(len(b))
    first = newton.solve(lambda x: A @ x + b, b, 0.0)[1]
    x, again, settled = newton.solve(lambda x: A @ x + 2.0 * b, b, 0.0)
    assert settled and again <= 5 < first
    assert x == pytest.approx(np.linalg.solve(np.eye(len(b)) - A, 2.0 * b), rel=1e-4, abs=1e-4)
    newton.forget()
    assert newton.solve(lambda x: A @ x + b, b, 0.0)[1] == first


def test_a_push_that_ends_where_contact_does():
    """m x = m x0 - c max(0, x - v): what catches up is pushed back, what is slower is not."""
    for start, ratio in ((1.0, 5.0), (-1.0, 5.0), (1.0, 0.2)):
        x, _, settled = QuasiNewton(1).solve(lambda x, r=ratio, s=start: s - r * np.maximum(0.0, x - 0.2),
                                             np.array([start]), 1e-3)
        assert settled and x == pytest.approx((start + 0.2 * ratio) / (1.0 + ratio) if start > 0.2 else start, rel=1e-4)


def test_rounds_end_without_a_fixed_point():
    """Its answer is below what is above 0.3, and above what is not."""
    x, rounds, settled = QuasiNewton(1).solve(lambda x: np.where(x > 0.3, -1.0, 1.0), np.ones(1), 1.0)
    assert (rounds, settled) == (ROUNDS, False) and np.abs(x) < 2.0
