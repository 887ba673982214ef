"""U5: two spheres rebound, slide and roll as they must; a periodic cell under pressure, sheared to critical state."""

import numpy as np
import pytest

from snowmpm.micro.grains.assembly import Assembly, loose_cell
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.drive import compress, drive
from snowmpm.micro.grains.pairs import Pairs

K = 1e5
LARGE = 1e5
"""Radius of a sphere that is as good as a plane [m]."""


def collision(damping=0.0, radii=(1.0, 0.6), speed=0.5):
    """Two spheres that fly into each other: the assembly, and how long they touched."""
    law = ContactLaw(K, 0.8 * K, friction=0.5, damping=damping)
    pair = Assembly([[0.0, 0.0, 0.0], [sum(radii) + 1e-3, 0.0, 0.0]], radii, law, density=10.0)
    pair.velocities[:, 0] = [speed, 0.0]
    touched = 0
    for _ in range(100_000):
        pair.step()
        acts = len(pair.forces()[0]) > 0
        touched += acts
        if touched and not acts:
            return pair, touched * pair.dt
    raise AssertionError("they never parted")


def test_a_rebound_takes_half_a_period():
    pair, time = collision()
    reduced = pair.mass.prod() / pair.mass.sum()
    assert time == pytest.approx(np.pi * np.sqrt(reduced / K), abs=2.0 * pair.dt)
    momentum, energy = pair.mass @ pair.velocities[:, 0], pair.kinetic_energy()
    assert momentum == pytest.approx(0.5 * pair.mass[0], rel=1e-12)
    assert energy == pytest.approx(0.5 * pair.mass[0] * 0.25, rel=1e-3)


def test_damping_takes_energy_as_an_oscillator_does():
    """Restitution of a damped half period; pulling is left out at its end, which returns a little more."""
    share = 0.1
    pair, _ = collision(damping=share)
    parted = pair.velocities[1, 0] - pair.velocities[0, 0]
    # The push ends before the overlap does, when the phase is pi - 2 asin(share)
    exact = np.exp(-share / np.sqrt(1.0 - share**2) * (np.pi - 2.0 * np.arcsin(share)))
    assert parted / 0.5 == pytest.approx(exact, rel=0.01)


def on_a_plane(rolling=0.0, friction=0.3):
    law = ContactLaw(K, 0.8 * K, friction=friction, rolling=rolling, damping=0.3)
    radius, g = 0.5, 9.81
    ball = Assembly([[0.0, 0.0, -LARGE], [0.0, 0.0, radius]], [LARGE, radius], law, density=1.0,
                    gravity=(0.0, 0.0, -g), fixed=[1, 0])
    ball.mass[0] = ball._sizes[0, 1] = 1e30
    ball.dt = 0.1 * np.sqrt(ball.mass[1] / K)
    # It lies on the ground
    ball.positions[1, 2] = radius - ball.mass[1] * g / K
    return ball, radius, g


def test_a_ball_slides_until_it_rolls():
    """Deceleration mu g; from t = 2 v0 / (7 mu g) on it rolls, at 5/7 of its speed."""
    ball, radius, g = on_a_plane()
    ball.velocities[1, 0] = 2.0
    until = 2.0 * 2.0 / (7.0 * 0.3 * g)
    while ball.time < 0.5 * until:
        ball.step()
    assert ball.velocities[1, 0] == pytest.approx(2.0 - 0.3 * g * ball.time, rel=2e-3)
    while ball.time < 1.5 * until:
        ball.step()
    assert ball.velocities[1, 0] == pytest.approx(2.0 * 5.0 / 7.0, rel=2e-3)
    assert ball.spins[1, 1] * radius == pytest.approx(ball.velocities[1, 0], rel=5e-3)


def test_rolling_resistance_stops_a_rolling_ball():
    """Deceleration 5/7 mu_r g."""
    ball, radius, g = on_a_plane(rolling=0.05)
    ball.velocities[1, 0], ball.spins[1, 1] = 1.0, 1.0 / radius
    while ball.time < 0.5:
        ball.step()
    assert ball.velocities[1, 0] == pytest.approx(1.0 - 5.0 / 7.0 * 0.05 * g * 0.5, rel=0.01)


def test_bonds_hold_until_their_strength():
    law = ContactLaw(K, K, strength=2e3, shear_strength=1e3)
    for pull, holds in ((0.9, True), (1.1, False)):
        pair = Assembly([[0.0, 0.0, 0.0], [1.99, 0.0, 0.0]], [1.0, 1.0], law, density=10.0, damping=200.0,
                        fixed=[1, 0])
        assert pair.bond() == 1
        pair._pull = np.array([pull * np.pi * 2e3 / pair.mass[1], 0.0, 0.0])
        while pair.time < 2.0:
            pair.step()
        assert (pair.positions[1, 0] < 2.1) == holds


def test_pairs_are_all_that_are_near():
    rng = np.random.default_rng(1)
    positions, radii, box = rng.uniform(-3.0, 5.0, (60, 3)), rng.uniform(0.2, 0.4, 60), np.array([3.0, 3.5, 4.0])
    found = Pairs.near(positions, radii, 0.1, box)
    way = positions[:, None] - positions[None]
    way -= box * np.round(way / box)
    gap = np.linalg.norm(way, axis=2) - radii[:, None] - radii[None]
    i, j = np.nonzero(np.triu(gap < 0.1, 1))
    assert np.array_equal(found.first, i) and np.array_equal(found.second, j)
    for grain in range(60):
        own = found.members[found.starts[grain] : found.starts[grain + 1]]
        assert all((found.first[k] if k >= 0 else found.second[-k - 1]) == grain for k in own)
    memory = rng.random((found.count, 2))
    fewer = Pairs.near(positions, radii, 0.02, box)
    kept = dict(zip(zip(found.first, found.second, strict=True), memory, strict=True))
    wanted = [kept[pair] for pair in zip(fewer.first, fewer.second, strict=True)]
    assert np.array_equal(fewer.carried(found, memory), np.array(wanted))


PRESSURE = 1e5
RADIUS = 5e-4
SOFT = 300.0 * PRESSURE * 2.0 * RADIUS


def packing(count, friction, seed=1, rolling=0.0):
    positions, radii, box = loose_cell(count, RADIUS, seed=seed)
    law = ContactLaw(SOFT, 0.5 * SOFT, friction=friction, rolling=rolling, damping=0.2)
    cell = Assembly(positions, radii, law, box=box, density=2600.0)
    cell.damping = 0.02 / cell.dt
    compress(cell, PRESSURE)
    return cell


@pytest.fixture(scope="module")
def pressed():
    return packing(200, 0.5)


@pytest.mark.slow
def test_a_cell_stands_under_pressure(pressed):
    """Isotropic to 100 kPa: normal stresses, a fabric without direction, contacts as of frictional grains."""
    stress = pressed.stress()
    assert np.diag(stress) == pytest.approx(np.full(3, -PRESSURE), rel=0.02)
    assert np.abs(stress - np.diag(np.diag(stress))).max() < 0.15 * PRESSURE
    assert 3.0 < pressed.coordination() < 6.5 and np.trace(pressed.fabric()) == pytest.approx(1.0)
    assert np.diag(pressed.fabric()) == pytest.approx(np.full(3, 1.0 / 3.0), abs=0.05)


@pytest.mark.slow
def test_work_of_the_stress_is_that_of_the_contacts(pressed):
    """Hill and Mandel: V stress : rate is the power of the contacts, to 1e-3 in slow straining."""
    cell = pressed
    cell.rates[:] = [0.0, 0.0, -0.05 * np.sqrt(PRESSURE / 2600.0) / 1e3 / RADIUS]
    cell.step(2000)  # what is left of the motion of its making
    cell.damping = 0.0  # it would take work from the contacts
    contacts = stress = 0.0
    for _ in range(2000):
        i, j, branch, force = cell.forces()
        u = cell.velocities[i] - cell.velocities[j] + cell.rates * branch
        contacts -= (force * u).sum() * cell.dt
        stress += cell.volume * (np.diag(cell.stress()) * cell.rates).sum() * cell.dt
        cell.step()
    assert stress == pytest.approx(contacts, rel=1e-3)


FREE = pytest.mark.xfail(strict=True, reason="17 to 23 degrees of spheres that roll freely")


@pytest.mark.slow
@pytest.mark.parametrize("rolling", [pytest.param(0.0, marks=FREE), 0.2])
def test_critical_state_angle(rolling):
    """Friction of 30 degrees between grains: 24 to 31 degrees of the assembly in triaxial compression."""
    cell = packing(300, float(np.tan(np.radians(30.0))), rolling=rolling)
    cell.damping = 0.0
    rate = 2e-3 * np.sqrt(PRESSURE / 2600.0) / (2.0 * RADIUS)
    seen = []

    def watch(one):
        seen.append((np.log(cell.box[2]), *np.diag(one.stress())))

    drive(cell, 0.35, rates=(None, None, -rate), stresses=(-PRESSURE, -PRESSURE, None), fastest=5.0 * rate, watch=watch)
    seen = np.array(seen)
    late = seen[len(seen) // 2 :]
    axial, lateral = -late[:, 3].mean(), -late[:, 1:3].mean()
    angle = np.degrees(np.arcsin((axial - lateral) / (axial + lateral)))
    assert lateral == pytest.approx(PRESSURE, rel=0.05) and 24.0 < angle < 31.0


def porosity(cell):
    return 1.0 - 4.0 / 3.0 * np.pi * (cell.radii**3).sum() / cell.volume


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "known"), [(0.0, 0.375), (0.8, 0.427)])
def test_porosity_is_set_by_the_friction_of_the_making(friction, known):
    """B3 of Sun et al. (2013): pressed with no friction grains pack densely, with much loosely; equal spheres at
    100 kPa have 0.375 and 0.427, +-0.02, also when they have their own friction afterwards."""
    positions, radii, box = loose_cell(300, RADIUS, spread=0.0, seed=2)
    cell = Assembly(positions, radii, ContactLaw(SOFT, 0.5 * SOFT, friction=friction, damping=0.2), box=box,
                    density=2600.0)
    cell.damping = 0.02 / cell.dt
    compress(cell, PRESSURE)
    assert porosity(cell) == pytest.approx(known, abs=0.02)
    cell.law = ContactLaw(SOFT, 0.5 * SOFT, friction=0.5, damping=0.2)
    compress(cell, PRESSURE)
    assert porosity(cell) == pytest.approx(known, abs=0.02)


@pytest.mark.slow
def test_a_few_hundred_grains_are_enough():
    """BM-3 of Sun et al. (2013): directions of contacts are even from a few hundred grains on, not with 75; the angle
    of 311 grains is that of 979, to 2 degrees."""
    uneven, angles = {}, {}
    for count in (75, 311, 979):
        cell = packing(count, 0.5, seed=4, rolling=0.2)
        uneven[count] = np.abs(np.diag(cell.fabric()) - 1.0 / 3.0).max()
        if count > 75:
            angles[count] = largest_angle(cell)
    print(uneven, angles)
    assert uneven[75] > max(uneven[311], uneven[979])
    assert max(uneven[311], uneven[979]) < 0.02
    assert angles[311] == pytest.approx(angles[979], abs=2.0)


def largest_angle(cell, strain=0.08):
    """Angle of friction [degrees] in triaxial compression, mean of the second half of it."""
    cell.damping, seen = 0.0, []
    rate = 4e-3 * np.sqrt(PRESSURE / 2600.0) / (2.0 * RADIUS)
    drive(cell, strain, rates=(None, None, -rate), stresses=(-PRESSURE, -PRESSURE, None), fastest=5.0 * rate,
          watch=lambda one: seen.append(np.diag(one.stress())))
    late = -np.array(seen)[len(seen) // 2 :]
    axial, lateral = late[:, 2].mean(), late[:, :2].mean()
    return np.degrees(np.arcsin((axial - lateral) / (axial + lateral)))
