"""Mandel's problem (P2): the pressure in the middle of a block that drains to its sides rises before it falls."""

import numpy as np
import pytest

from snowmpm.study.problems import mandel

TABLE = {0.01: (1.0438, 1.0433), 0.05: (1.0989, 0.9822), 0.1: (1.0954, 0.8609), 0.2: (0.9681, 0.7074),
         0.5: (0.5928, 0.4281), 1.0: (0.2588, 0.1869)}
"""p / p_0 at the centre and half-way to the side, at T = c t / a²."""


@pytest.mark.parametrize("T", TABLE)
def test_the_series_gives_the_table(T):
    np.testing.assert_allclose(mandel.pressure([0.0, 0.5], T), TABLE[T], atol=6e-5)


def course(times, dx, water=None, **solver):
    """(T, `Simulation`) at each T of times."""
    simulation = mandel.mandel(dx, water, **solver)
    for T in times:
        while simulation.time < T / mandel.C_V - 1e-12:
            simulation.step(until=T / mandel.C_V)
        yield T, simulation


def judge(found, dx):
    """2 % of the undrained pressure in all cells of the plane of symmetry, and a centre that has risen."""
    highest = 0.0
    for T, simulation in found:
        x, p = mandel.found(simulation, dx)
        assert np.abs(p - mandel.pressure(x, T)).max() < 0.02, T
        assert simulation.audit()["water_residual"] < 1e-10
        highest = max(highest, p[0])
    assert highest > 1.08


def implicit(dt, split="monolithic"):
    return {"water": {"split": split}, "implicit": {"time": "quasi_static", "dt": dt}}


def test_the_centre_rises():
    """Five cells, to T = 0.05."""
    (T, simulation), = course((0.05,), 0.2, **implicit(4e-3))
    x, p = mandel.found(simulation, 0.2)
    assert p[0] > 1.07 and np.abs(p - mandel.pressure(x, T)).max() < 0.04
    assert simulation.audit()["water_residual"] < 1e-10


@pytest.mark.slow
def test_implicit_steps_to_the_end():
    judge(course(list(TABLE)[1:], 0.1, **implicit(2e-3)), 0.1)


@pytest.mark.slow
def test_implicit_steps_early():
    judge_early = list(course((0.01,), 0.05, **implicit(2e-4)))
    x, p = mandel.found(judge_early[0][1], 0.05)
    assert np.abs(p - mandel.pressure(x, 0.01)).max() < 0.02


@pytest.mark.slow
def test_explicit_steps():
    """`split = "semi_implicit"` of explicit MPM."""
    judge(course((0.05, 0.1, 0.2, 0.5, 1.0), 0.1), 0.1)
