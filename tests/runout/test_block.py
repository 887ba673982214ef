"""Energy line and sliding block, on slopes whose answer is known."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.runout.block import GRAVITY, block, energy_line
from snowmpm.runout.profile import profile_of

LINE = np.array([[0.0, 0.0], [1500.0, 0.0]])


def kinked(places):
    """35 degrees as far as 500 m, then level."""
    return -math.tan(math.radians(35.0)) * np.minimum(places[:, 0], 500.0)


def test_the_energy_line_meets_the_ground_where_its_angle_says():
    profile = profile_of(LINE, kinked, "here", spacing=5.0)
    found = energy_line(profile, 25.0)
    assert found.runout == pytest.approx(500.0 * math.tan(math.radians(35.0)) / math.tan(math.radians(25.0)), abs=1e-6)
    most = 500.0 * (math.tan(math.radians(35.0)) - math.tan(math.radians(25.0)))
    assert found.fastest == pytest.approx(math.sqrt(2.0 * GRAVITY * most))


def test_a_coulomb_block_without_curvature_is_an_energy_line():
    profile = profile_of(LINE, kinked, "here", spacing=7.0)
    found = block(profile, 0.45, centrifugal=False)
    line = energy_line(profile, math.degrees(math.atan(0.45)))
    assert found.runout == pytest.approx(line.runout, rel=1e-6)
    np.testing.assert_allclose(found.speed, line.speed, atol=1e-6)


def test_a_voellmy_block_reaches_its_terminal_speed():
    profile = profile_of(LINE, lambda places: -0.7 * places[:, 0], "here")
    found = block(profile, 0.2, 1500.0, 2.0)
    a = math.atan(0.7)
    assert found.speed[-1] == pytest.approx(math.sqrt(1500.0 * 2.0 * (math.sin(a) - 0.2 * math.cos(a))), rel=1e-3)
    assert found.runout is None


def smooth(places):
    """From 35 degrees to level at 1000 m, as a parabola, and on."""
    s = np.minimum(places[:, 0], 1000.0)
    return -math.tan(math.radians(35.0)) * (s - s**2 / 2000.0)


def exact(mu, xi, thickness, centrifugal):
    """Where a block on `smooth` stops, by integration over its plan length, to 1e-9."""
    def slope(s):
        return -math.tan(math.radians(35.0)) * (1.0 - min(s, 1000.0) / 1000.0)

    def rate(s, state):
        bend = math.tan(math.radians(35.0)) / 1000.0 if s < 1000.0 else 0.0
        cosine = 1.0 / math.sqrt(1.0 + slope(s) ** 2)
        kappa = bend * cosine**3 if centrifugal else 0.0
        normal = GRAVITY * cosine + kappa * 2.0 * state[0]
        drive = -GRAVITY * slope(s) * cosine - mu * normal - GRAVITY * 2.0 * state[0] / (xi * thickness)
        return [drive / cosine]

    def stops(s, state):
        return state[0]

    stops.terminal, stops.direction = True, -1
    found = solve_ivp(rate, (0.0, 5000.0), [1e-9], events=stops, rtol=1e-9, atol=1e-9, max_step=5.0)
    return float(found.t_events[0][-1])


def test_on_a_bend_without_its_weight_the_run_out_is_exact():
    found = block(profile_of(2.0 * LINE, smooth, "here", spacing=40.0), 0.3, centrifugal=False)
    assert found.runout == pytest.approx(exact(0.3, math.inf, 1.5, False), rel=1e-4)


@pytest.mark.parametrize(("mu", "xi", "centrifugal"), [(0.3, math.inf, True), (0.2, 1500.0, True)])
def test_the_run_out_on_a_bend_converges(mu, xi, centrifugal):
    answer = exact(mu, xi, 1.5, centrifugal)
    errors = [abs(block(profile_of(2.0 * LINE, smooth, "here", spacing=dx), mu, xi, 1.5, centrifugal).runout - answer)
              for dx in (40.0, 20.0, 10.0)]
    assert errors[-1] < 0.002 * answer
    assert errors[0] > 1.7 * errors[1] > 2.5 * errors[2]


def brow(places):
    """Gentle, then 45 degrees beyond a rounded brow of 100 m."""
    s = places[:, 0]
    bend = np.clip((s - 300.0) / 100.0, 0.0, 1.0)
    return -0.4 * np.minimum(s, 300.0) - 40.0 * bend - 30.0 * bend**2 - np.maximum(s - 400.0, 0.0)


def test_over_a_brow_the_ground_carries_less_but_never_pulls():
    profile = profile_of(LINE, brow, "here", spacing=5.0)
    with_it, without = block(profile, 0.3), block(profile, 0.3, centrifugal=False)
    at = int(np.searchsorted(profile.s, 420.0))
    assert with_it.speed[at] > without.speed[at]
    most = np.sqrt(2.0 * GRAVITY * profile.drop)
    assert (with_it.speed <= most + 1e-9).all()


def test_what_does_not_start():
    profile = profile_of(LINE, lambda places: -0.2 * places[:, 0], "here")
    assert energy_line(profile, 25.0).runout == 0.0 and block(profile, 0.3).runout == 0.0
