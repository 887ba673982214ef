"""D6: a block with Voellmy friction on a plane, by the semi-implicit step that `FrictionLaw` describes."""

import numpy as np
import pytest
from ground_stress import EXAMPLES, parts

from snowmpm.ground import Coulomb, Voellmy

DENSITY = 300.0

# mu, xi [m/s2], h [m], slope [degrees]; v_inf, T, v(5 s), s(10 s), s(20 s)
CASES = [(0.155, 1750.0, 1.0, 35.0, 27.956462, 6.380972, 18.304677, 163.515438, 435.816827),
         (0.25, 2000.0, 1.5, 30.0, 29.163006, 10.486244, 12.939315, 121.996391, 377.957848)]


def slide(law, depth, slope, dt, steps, speed=0.0):
    """Speed [m/s] after each step, and the way by the trapezoidal rule [m]."""
    g_along, g_across = 9.81 * np.sin(np.radians(slope)), 9.81 * np.cos(np.radians(slope))
    weight, sigma = DENSITY * depth, DENSITY * depth * g_across
    speeds, way = [speed], [0.0]
    for _ in range(steps):
        dry, rate = (float(part) for part in parts(law, sigma, speed, depth, density=DENSITY))
        after = max(0.0, abs(speed + dt * g_along) - dt * dry / weight) / (1.0 + dt * rate / weight)
        way.append(way[-1] + 0.5 * dt * (speed + after))
        speed = after
        speeds.append(speed)
    return np.array(speeds), np.array(way)


@pytest.mark.parametrize("case", CASES)
def test_voellmy_block_is_of_second_order(case):
    mu, xi, depth, slope, _, _, v5, s10, _ = case
    law, errors = Voellmy(mu=mu, xi=xi), []
    for count in (20, 40, 80):
        speed, way = slide(law, depth, slope, 10.0 / count, count)
        errors.append([abs(speed[count // 2] - v5) / v5, abs(way[-1] - s10) / s10])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert orders == pytest.approx(2.0, abs=0.05)
    assert max(errors[-1]) < 2e-4


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("dt", [0.1, 5.0])
def test_steady_speed_is_exact_for_any_step(case, dt):
    mu, xi, depth, slope, v_inf, T, *_ = case
    speed, _ = slide(Voellmy(mu=mu, xi=xi), depth, slope, dt, int(30.0 * T / dt) + 60)
    excess = np.sin(np.radians(slope)) - mu * np.cos(np.radians(slope))
    assert speed[-1] == pytest.approx(np.sqrt(xi * depth * excess), rel=1e-12)
    assert speed[-1] == pytest.approx(v_inf, abs=1e-6)


def test_way_of_twenty_seconds():
    for mu, xi, depth, slope, *_, s20 in CASES:
        _, way = slide(Voellmy(mu=mu, xi=xi), depth, slope, 0.05, 400)
        assert way[-1] == pytest.approx(s20, rel=2e-5)  # 3e-6 is seen


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_flow_stops_stays_and_never_turns(name):
    law = EXAMPLES[name]
    speed, _ = slide(law, 0.5, 5.0, 0.05, 1200, speed=20.0)
    assert (speed >= 0.0).all()
    # 5 degrees are below every friction angle here, and 128 Pa of bingham's 200 drive it
    stopped = np.flatnonzero(speed == 0.0)
    assert len(stopped) and (speed[stopped[0]:] == 0.0).all()


def test_a_block_at_rest_stays_up_to_its_friction_angle():
    law = Coulomb(mu=np.tan(np.radians(25.0)))
    assert slide(law, 1.0, 24.999, 0.1, 50)[0][-1] == 0.0
    assert slide(law, 1.0, 25.001, 0.1, 50)[0][-1] > 0.0
