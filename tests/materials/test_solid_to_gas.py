"""The law "from solid to gas": its limits, the published equations, shear at constant normal stress, its step."""

import numpy as np
import pytest
from hypoplastic_laws import DENSE, FAST, stretching
from hypoplastic_reference import published_rate
from parameter_sets import changed
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from snowmpm.materials import LoadingStage, MixedControl, SolidToGas, StressUpdate, measure, pack, unpack

PRESSURE = 1e4
STEPS = 300
START = -PRESSURE * np.diag([0.7, 0.8, 1.0])
SHEAR = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
SQUEEZE = np.array([[-0.002, 0.0, 0.0], [0.0, 0.001, 0.0], [0.0, 0.0, -0.002]])


def published(law, rate, time, sigma):
    """T_i, T_v, e after a time of the velocity gradient rate(t), by an independent integration of eqs. 9, 23, 26 and 30
    of [W], with dD/dt by differences of rate; tensors (3, 3)."""

    def slope(t, y):
        friction, collisional, e = y[:9].reshape(3, 3), y[9:18].reshape(3, 3), y[18]
        L, step = rate(t), 1e-6
        D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)
        ahead, behind = rate(t + step), rate(t - step)
        gain = 0.5 * ((ahead - behind) + (ahead - behind).T) / (2.0 * step) + D @ W - W @ D
        T = friction + collisional
        eta = -law.collision_time * np.sqrt(law.constant_share + law.square_share * (D * D).sum())
        turning = [W @ X - X @ W for X in (friction, collisional)]
        return np.concatenate([
            (published_rate(law, friction, D, e) + turning[0]).ravel(),
            (eta * (T @ gain + gain @ T) + turning[1]).ravel(),
            [(1.0 + e) * np.trace(D)],
        ])

    start = np.concatenate([sigma.ravel(), np.zeros(9), [law.void_ratio]])
    solution = solve_ivp(slope, (0.0, time), start, method="DOP853", rtol=1e-10, atol=1e-8)
    return solution.y[:9, -1].reshape(3, 3), solution.y[9:18, -1].reshape(3, 3), solution.y[18, -1]


def rate(t):
    """A velocity gradient that grows smoothly from rest to shear of 60 1/s, with squeezing in turning directions."""
    return 60.0 * np.sin(0.5 * np.pi * t / 0.02) ** 2 * (SHEAR + SQUEEZE)


def along(rate, time, n):
    """Increments f − I of the velocity gradient rate(t), by its value in the middle of n equal steps."""
    middle = (np.arange(n) + 0.5) * time / n
    return np.concatenate([stretching(rate(t), 1, time / n) for t in middle])


def parts(state):
    """Collisional stress (..., 3, 3) and stretching of states."""
    return unpack(state[..., 3:9]), unpack(state[..., 9:15])


def test_published_equations():
    """Turning stretch, growing rate. The D of a step is that of its middle, so T_v is half a step late: first order."""
    friction, collisional, e = published(FAST, rate, 0.02, START)
    assert np.abs(collisional).max() > 0.01 * np.abs(friction).max()
    errors = []
    for n in (100, 200, 400):
        update = StressUpdate(changed(FAST, tolerance=1e-9))
        path = update.integrate(pack(START)[None], update.initial_state(1), along(rate, 0.02, n)[None], 0.02 / n)
        found = parts(path.state[0, -1])[0]
        errors.append(np.abs(found - collisional).max() / np.abs(collisional).max())
        off = unpack(path.h[0, -1]) - found - friction
        assert np.abs(off).max() < 0.2 * n**-2 * 100.0 * np.abs(friction).max()  # second order, as without collisions
        assert path.state[0, -1, 0] == pytest.approx(e, rel=1e-11)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 1.0) < 0.1).all() and errors[-1] < 0.01


def test_slow_shear_is_the_law_of_friction():
    increments = stretching(0.1 * (SHEAR + SQUEEZE), 20)[None]
    slow, friction = StressUpdate(FAST), StressUpdate(DENSE)
    found = slow.integrate(pack(START)[None], slow.initial_state(1), increments, 1e6)
    wanted = friction.integrate(pack(START)[None], friction.initial_state(1), increments)
    np.testing.assert_allclose(found.h, wanted.h, rtol=1e-6, atol=1e-6 * PRESSURE)
    np.testing.assert_array_equal(found.state[..., 0], wanted.state[..., 0])


def test_spinning_alone_makes_no_stress():
    """Of a body that only spins D is zero at all times, whatever its acceleration (which eq. 27 of [W] would count)."""
    spin = 300.0 * (SHEAR - SHEAR.T)
    path = StressUpdate(FAST).integrate(
        pack(START)[None], StressUpdate(FAST).initial_state(1), stretching(spin, 50, 0.05)[None], 0.001
    )
    collisional, D = parts(path.state[0])
    assert np.abs(D).max() < 1e-9 and np.abs(collisional).max() < 1e-12 * PRESSURE
    Q = expm(spin * 0.05)
    np.testing.assert_allclose(unpack(path.h[0, -1]), Q @ START @ Q.T, atol=1e-11 * PRESSURE)


class Sheared:
    """A test of shear in xz at constant normal stress zz: shear rate [1/s], parts of the stress over that pressure."""

    def __init__(self, rows):
        state = np.array([row.state for row in rows])
        time, shear = np.cumsum([row.duration for row in rows]), np.array([row.strain[5] for row in rows])
        self.rate, self.void_ratio = np.gradient(shear, time, edge_order=2), state[:, 0]
        self.total = unpack(np.array([row.cauchy for row in rows])) / PRESSURE
        self.collisional = parts(state)[0] / PRESSURE
        self.friction = self.total - self.collisional
        self.ratio = self.friction[:, 0, 2] / -self.friction[:, 2, 2]


@pytest.fixture(scope="module")
def sheared():
    """Slow to fast: from rest to 200 1/s."""
    return Sheared(measure(FAST, "accelerated_shear", pressure=PRESSURE, rate=200.0, steps=STEPS).rows)


def test_pressure_passes_from_friction_to_collisions(sheared):
    fast = sheared.rate > 50.0
    np.testing.assert_allclose(sheared.total[:, 2, 2], -1.0, rtol=1e-9)
    assert (np.diff(-sheared.friction[:, 2, 2]) < 0.0).all() and sheared.friction[-1, 2, 2] > -0.8
    assert (np.diff(sheared.void_ratio[fast]) > 0.0).all() and sheared.void_ratio[-1] > 0.74
    assert (np.diff(sheared.total[fast, 0, 2]) > 0.0).all() and sheared.total[-1, 0, 2] > 0.95


def test_friction_unloads_along_its_critical_state(sheared):
    """Its own stress ratio is that of shear without collisions at the same void ratio, to 2 %: the path is not quite
    the same, since it unloads."""
    slow = Sheared(measure(changed(FAST, collision_time=0.0), "accelerated_shear", pressure=PRESSURE, rate=1.0,
                           steps=100).rows)  # fmt: skip
    assert not slow.collisional.any()
    fast = (sheared.rate > 100.0) & (sheared.void_ratio < slow.void_ratio.max())
    end = np.argmin(slow.void_ratio)  # it contracts first
    known = np.interp(sheared.void_ratio[fast], slow.void_ratio[end:], slow.ratio[end:])
    assert fast.sum() > 50
    np.testing.assert_allclose(sheared.ratio[fast], known, rtol=0.02)
    assert np.ptp(sheared.ratio[fast]) > 0.03  # which is more than that


def test_shear_stress_of_collisions_grows_linearly_then_as_the_square(sheared):
    tau, rate = sheared.collisional[1:, 0, 2], sheared.rate[1:]
    slow, fast = (rate > 5.0) & (rate < 25.0), (rate > 100.0) & (rate < 180.0)
    slopes = [np.polyfit(np.log(rate[part]), np.log(tau[part]), 1)[0] for part in (slow, fast)]
    assert slopes[0] == pytest.approx(1.0, abs=0.1) and slopes[1] == pytest.approx(2.0, abs=0.1)


def stages(n):
    """Speeding up to 100 1/s, slowing down to rest, and the same the other way; normal stress held."""
    time = np.linspace(0.0, 0.02, 4 * n + 1)
    shear = 100.0 * 0.005 / np.pi * (1.0 - np.cos(np.pi * time / 0.01))
    return [LoadingStage({"xz": g}, {"zz": -PRESSURE}, 1, 0.02 / (4 * n)) for g in shear[1:]]


def test_start_stop_and_reversal_without_a_jump():
    """The largest change of the sum in a step halves with the step: it is a slope, no jump."""
    changes = []
    for n in (40, 80):
        control = MixedControl(FAST)
        start = control.consolidated(PRESSURE)
        found = Sheared([start, *control.follow_stages(stages(n), start)])
        np.testing.assert_allclose(found.total[:, 2, 2], -1.0, rtol=1e-9)
        changes.append(np.abs(np.diff(found.total, axis=0)).max())
        left = [np.abs(found.collisional[k]).max() for k in (n, 2 * n)]
        assert left[1] < 0.6 * left[0], left  # what is left of it at rest, see the docstring
    assert changes[1] == pytest.approx(0.5 * changes[0], rel=0.1) and changes[1] < 0.1


def test_grains_apart_do_not_collide():
    """Under collisional stress the grains are pulled apart, and pushed together again: none while they are apart."""
    fast = followed_at(60.0 * SHEAR, 200, 0.02)
    assert fast.state[0, -1, 1] == 0.0 and np.abs(parts(fast.state[0, -1])[0]).max() > 100.0
    update = StressUpdate(FAST)
    away = np.concatenate([stretching(5.0 * np.eye(3), 20, 0.02), stretching(-5.0 * np.eye(3), 25, 0.02)])
    path = update.integrate(fast.h[:, -1], fast.state[:, -1], away[None], 0.001)
    gap = path.state[0, :, 1] > 0.0
    assert gap[2:20].all() and not gap[-1]
    assert not path.h[0, gap].any() and not parts(path.state[0, gap])[0].any()
    assert np.linalg.eigvalsh(unpack(path.h[0])).max() < 1e-6 * PRESSURE  # none pulls, along no axis


def followed_at(L, steps, time):
    """`Updated` of a velocity gradient for a time [s], from START."""
    update = StressUpdate(FAST)
    return update.integrate(pack(START)[None], update.initial_state(1), stretching(L, steps, time)[None], time / steps)


def test_published_row_jams():
    printed = (-1.70, -283.4, -283.4, 2419.3)
    with pytest.raises(ValueError, match=r"jam.*1\.066"):
        SolidToGas.from_coefficients(
            printed, density=1800.0, void_ratio=0.2, least_void_ratio=0.1, critical_void_ratio_limit=0.5,
            critical_void_ratio_drop=0.5, pressure_scale=2e6, density_effect=0.4, density_effect_scale=1e7,
            collision_time=8e-4,
        )  # fmt: skip


def test_no_cohesion():
    with pytest.raises(ValidationError, match="cohesion"):
        changed(FAST, cohesion=100.0)


@pytest.mark.parametrize("damping", [0.0, 0.1, 1.0, 10.0])
def test_step_limit_is_that_of_a_damped_oscillator(damping):
    """Wave of the shortest length, k = 2/dx, kicked by stress and, half a step late, by 2 |eta| sigma D: it decays at
    0.99 of the step for which the law's wave speed crosses a cell, and grows at 1.01 of it."""
    stress, state, dx = pack(START)[None], np.array([FAST.initial_state()]), 0.01
    speed, viscosity = FAST.wave_speed_at(stress, state)[0], FAST.viscosity(START, state[0])
    law = changed(FAST, collision_time=FAST.collision_time * damping * FAST.density * speed * dx / viscosity)
    limit = dx / law.on_grid(dx).wave_speed_at(stress, state)[0]
    omega = 2.0 * speed / dx
    for share, grows in ((0.99, False), (1.01, True)):
        dt = share * limit
        kick = np.array([[1.0 - 2.0 * damping * omega * dt, -omega * dt], [0.0, 1.0]])
        drift = np.array([[1.0, 0.0], [omega * dt, 1.0]])
        assert (np.abs(np.linalg.eigvals(drift @ kick)).max() > 1.0 + 1e-9) == grows
    assert law.wave_speed_at(stress, state)[0] == pytest.approx(speed)  # without a grid: that of friction
