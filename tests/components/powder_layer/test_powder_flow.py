"""The scheme of the powder layer by itself: order, a dam break, rest, balances. Gates were set before the first run."""

import numpy as np
import pytest

from snowmpm.components.powder_layer.closures import AIR_DENSITY
from tests.support.powder_clouds import EXCESS, OPEN, ROUND, WALL, G, cloud_over, fill, read, run_to

SHARE = 0.02
"""Of ice: a density of 19.6 kg/m3, fifteen times that of air."""
REDUCED = G * EXCESS * SHARE / (AIR_DENSITY + EXCESS * SHARE)
"""g' = g (rho - rho_a) / rho: the weight that is not borne by the air, over the inertia of the cloud itself."""
LENGTH, HEIGHT = 100.0, 10.0


def wave(x, time):
    """V and u of a simple wave in a layer of one density that is 100 m around, before it breaks: c = sqrt(g' V) is
    carried at the speed 3 c - 2 c_0."""
    first = np.sqrt(REDUCED * HEIGHT)

    def start(place):
        return first * (1.0 + 0.05 * np.sin(2.0 * np.pi * place / LENGTH))

    c = start(x)
    for _ in range(200):  # contracts, since the wave is far from breaking
        c = start(x - (3.0 * c - 2.0 * first) * time)
    return c**2 / REDUCED, 2.0 * (c - first)


def mean_of_cells(function, edges, points=8):
    """Means over cells of a function of x, by the points of Gauss."""
    at, weights = np.polynomial.legendre.leggauss(points)
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    return np.tensordot(function(middle[:, None] + half[:, None] * at), 0.5 * weights, axes=(1, 0))


@pytest.mark.parametrize("axis", [0, 1])
def test_order_of_a_simple_wave(axis):
    """2 +- 0.2 in L1 on 25 to 200 cells around (limiters clip the crests), and 1e-3 of the amplitude on the
    finest."""
    time, errors, numbers = 3.0, [], (25, 50, 100, 200)
    for n in numbers:
        edges = np.linspace(0.0, LENGTH, n + 1)
        cells = (n, 3) if axis == 0 else (3, n)
        cloud = cloud_over(cells, LENGTH / n, sides=(ROUND, ROUND))
        V = mean_of_cells(lambda x: wave(x, 0.0)[0], edges)
        flux = mean_of_cells(lambda x: np.prod(wave(x, 0.0), axis=0), edges)
        V, u = (np.expand_dims(one, 1 - axis) * np.ones(cells) for one in (V, flux / V))
        fill(cloud, V, SHARE, *((u, 0.0) if axis == 0 else (0.0, u)))
        run_to(cloud, time, time / n)
        found = np.moveaxis(read(cloud)[0], axis, 0)[:, 1]
        errors.append(np.abs(found - mean_of_cells(lambda x: wave(x, time)[0], edges)).mean())
    order = -np.polyfit(np.log(numbers), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.2), errors
    assert errors[-1] < 1e-3 * 0.1 * HEIGHT


def dam_break(n, time=3.0):
    """Depth of a cloud that a wall has held, its exact depth (Ritter 1892, with g'), and x, in metres from the wall."""
    dx = LENGTH / n
    cloud = cloud_over((n, 3), dx, sides=(WALL, WALL))
    x = (np.arange(n) + 0.5) * dx - 0.5 * LENGTH
    fill(cloud, np.where(x < 0.0, HEIGHT, 0.0)[:, None], SHARE)
    run_to(cloud, time, 0.05)
    c, along = np.sqrt(REDUCED * HEIGHT), x / time
    exact = np.where(along < -c, HEIGHT, np.where(along < 2.0 * c, (2.0 * c - along) ** 2 / (9.0 * REDUCED), 0.0))
    return read(cloud)[0][:, 1], exact, x, c * time


def test_dam_break_of_a_heavy_gas():
    """L1 of the depth below 1 % of h_0 c t, the place of a tenth of the depth within 2 % of c t, on 200 cells of 0.5 m.
    With rho_a in the inertia, as solvers of turbidity currents have it, the same gas would run 3.9 times as fast."""
    time = 2.2
    found, exact, x, way = dam_break(200, time)
    assert np.abs(found - exact).sum() * 0.5 < 0.01 * HEIGHT * way
    place = np.interp(-0.1 * HEIGHT, -found, x)
    assert place == pytest.approx(np.interp(-0.1 * HEIGHT, -exact, x), abs=0.02 * way)


def front_of_a_dam_break(n, share, k):
    """Speed of the front of a cloud that a wall has held, over sqrt(g' h_0), and the depth behind it over h_0; exact:
    2 F / (2 + F) and 4 / (2 + F)^2 where the front has U^2 = F^2 g' h, F^2 = rho / (2 k rho_a)."""
    dx, density = 4.0 * LENGTH / n, AIR_DENSITY + EXCESS * share
    cloud = cloud_over((n, 3), dx, sides=(WALL, WALL), front_drag=k)
    fill(cloud, np.where(np.arange(n) < n // 2, HEIGHT, 0.0)[:, None], share)
    first, F = np.sqrt(G * EXCESS * share / density * HEIGHT), np.sqrt(0.5 * density / AIR_DENSITY / k)
    places, dt = [], 0.01 * 120.0 / first
    for _ in range(100):
        cloud.move(dt, 4.0 * first / dx)
        depth = read(cloud)[0][n // 2 :, 1]
        places.append(np.interp(-0.1 * HEIGHT, -depth, dx * np.arange(n // 2)))
    speed = np.polyfit(dt * np.arange(40, 100), places[40:], 1)[0]
    behind = np.median(depth[int(0.6 * places[-1] / dx) : int(0.9 * places[-1] / dx)])
    return speed / first, behind / HEIGHT, 2.0 * F / (2.0 + F), (2.0 / (2.0 + F)) ** 2


@pytest.mark.parametrize("k", [0.25, 0.5])
@pytest.mark.parametrize("share", [1e-5, 1e-3])
def test_the_air_ahead_sets_the_speed_of_a_front(share, k):
    """Of clouds hardly heavier than air and 1.7 times as heavy: speed and depth of the front to 2 % on 400 cells, and
    the speed to 3 % on 100."""
    speed, depth, exact, behind = front_of_a_dam_break(400, share, k)
    assert speed == pytest.approx(exact, rel=0.02) and depth == pytest.approx(behind, rel=0.02)
    assert front_of_a_dam_break(100, share, k)[0] == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("profile", ["uniform", "motpsa"])
def test_air_in_air_does_not_move(profile):
    """A hump of the density of air at rest on a slope feels nothing: exactly."""
    cloud = cloud_over((20, 20), 2.0, slope=(0.5, 0.2), profile=profile, top_drag=1e-4, ground_drag=0.01)
    bump = np.exp(-((np.indices((20, 20)) - 10.0) ** 2).sum(axis=0) / 10.0)
    fill(cloud, 5.0 * bump, 0.0)
    before = cloud.state.copy()
    cloud.move(0.1, 1.0)  # by itself: as a cloud without ice, an exchange would give it back to the air
    assert np.array_equal(before, cloud.state)


@pytest.mark.parametrize("profile", ["uniform", "motpsa"])
@pytest.mark.parametrize("sides", [(ROUND, ROUND), (WALL, WALL), (OPEN, OPEN)])
def test_ice_air_and_momentum_close(profile, sides):
    """On a plane, with all that acts on the cloud alone: balances to 1e-12; around it, what faces give adds up to
    nothing."""
    rng = np.random.default_rng(1)
    cloud = cloud_over((32, 24), 2.0, slope=(0.5, 0.2), sides=sides, profile=profile, air_entrainment="parker_1987",
                       fall_speed=0.4, ground_drag=0.008, top_drag=1e-4, front_drag=0.5)
    V = np.where(rng.random((32, 24)) < 0.6, 10.0 * rng.random((32, 24)), 0.0)
    fill(cloud, V, 0.02 * rng.random((32, 24)), 20.0 * rng.random((32, 24)), 10.0 * rng.normal(size=(32, 24)))
    run_to(cloud, 2.0, 0.1)
    assert max(cloud.residuals()) < 1e-12 and cloud.sums["air"] > 0.0 and cloud.sums["laid"] > 0.0
    assert cloud.sums["added"] <= 1e-12 * cloud.air
    assert (read(cloud)[0] >= 0.0).all() and (cloud.sums["left_ice"] > 0.0) == (sides[0] == OPEN)
    if sides[0] == ROUND:
        assert np.abs(cloud.impulses["faces"]).max() < 1e-12 * np.abs(cloud.impulses["pull"]).max()


def test_along_and_across_are_alike():
    """A cloud that runs down along y does what one along x does, to round-off."""
    found = []
    for slope, turned in (((0.5, 0.0), False), ((0.0, 0.5), True)):
        cloud = cloud_over((40, 30) if not turned else (30, 40), 2.0, slope=slope, sides=(OPEN, OPEN), profile="motpsa",
                           air_entrainment="parker_1986", ground_drag=0.008, front_drag=0.5)
        V = np.zeros((40, 30))
        V[5:12, 10:20] = 5.0
        fill(cloud, V.T if turned else V, 0.02)
        run_to(cloud, 3.0, 0.1)
        found.append(read(cloud)[0].T if turned else read(cloud)[0])
    assert np.abs(found[0] - found[1]).max() < 1e-12 * found[0].max()


def test_ground_that_bends_takes_no_speed():
    """A thin stream that goes from a slope onto the flat in one cell keeps its speed along the ground to 1 %."""
    cloud = cloud_over((60, 3), 1.0, slope=(1.0, 0.0), sides=(OPEN, WALL), g=0.0)
    cloud.below.ground[34:, :, 0], cloud.below.ground[34:, :, 5] = 0.0, 1.0
    V = np.zeros((60, 3))
    V[5:20] = 1.0
    fill(cloud, V, 0.01, 10.0)
    run_to(cloud, 3.0, 0.05)
    V, _, u, _ = read(cloud)
    assert V[33:].max() > 0.3
    assert u[33:][V[33:] > 0.1] == pytest.approx(10.0 * np.sqrt(2.0), rel=0.01)


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.6, 0.0), (0.45, 0.4), (0.45, -0.4)])
def test_a_round_cloud_stays_round_on_a_slope_of_any_direction(slope):
    """Weight moves a cloud of one density as a whole, and pressure spreads it evenly along the ground: its variances
    along and across the slope, measured on the ground, grow by the same amount to 2 %, and it does not turn. How far it
    came is g' sin t^2 / 2 to 1 %, or 0.1 mm, since its tails go over into the air (asked first: 1e-9 m)."""
    n, dx, time = 60, 2.0, 2.5
    s = np.array(slope)
    cloud = cloud_over((n, n), dx, slope=slope, sides=(OPEN, OPEN))
    places = np.stack(np.meshgrid(*[(np.arange(n) + 0.5) * dx] * 2, indexing="ij"), axis=-1)
    arm = places - np.array([45.0, 50.0])
    along = (s if s.any() else np.array([1.0, 0.0])) / max(np.linalg.norm(s), 1e-30 if s.any() else 1.0)
    stretch = np.sqrt(1.0 + s @ s)

    def moments():
        V = cloud.inner[..., 0]
        mean = np.tensordot(V, places, axes=2) / V.sum()
        ell = (places - mean) @ along * stretch, (places - mean) @ np.array([-along[1], along[0]])
        return mean, np.array([[(V * a * b).sum() / V.sum() for a in ell] for b in ell])

    radius2 = (arm @ along * stretch) ** 2 + (arm @ np.array([-along[1], along[0]])) ** 2
    fill(cloud, 8.0 * np.exp(-radius2 / 200.0), SHARE)
    first, before = moments()
    run_to(cloud, time, 0.05)
    last, after = moments()
    grown = after - before
    assert grown[0, 0] == pytest.approx(grown[1, 1], rel=0.02) and abs(grown[0, 1]) < 0.01 * grown[0, 0]
    way = 0.5 * REDUCED * time**2 * s / stretch**2
    assert last - first == pytest.approx(way, abs=0.01 * np.linalg.norm(way) + 1e-4)
