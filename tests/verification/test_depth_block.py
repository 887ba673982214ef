"""Columns that slide like a block: Voellmy friction on a plane (D6), the energy line of a smooth path (D7).

Voellmy on a plane: v = v_inf tanh(t / T), way v_inf T ln cosh(t / T), with
v_inf = sqrt(xi h (sin - mu cos)), T = v_inf / (g (sin - mu cos)).
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.ground import Coulomb, Voellmy
from tests.support.depth_flows import OPEN, UNDAMPED, USUAL, WALL, G, Ground, flow, lattice, order, run_to, slope

VOELLMY = [
    (0.155, 1750.0, 1.0, 35.0, {5.0: (18.304677, None), 10.0: (None, 163.515438), 20.0: (None, 435.816827)}),
    (0.25, 2000.0, 1.5, 30.0, {5.0: (12.939315, None), 10.0: (None, 121.996391), 20.0: (None, 377.957848)}),
]
"""mu, xi [m/s2], depth [m], slope [degrees]; speed [m/s] and way [m] by time [s]"""


def sheet(mu, xi, depth, angle, length, dx=5.0, cfl=None):
    """Sheet of a length [m] in plan on a plane, in a channel of three cells; 4 columns a cell along, 2 across."""
    cosine = np.cos(np.radians(angle))
    plan, area = lattice((-0.5 * length, 0.0), (0.5 * length, 3.0 * dx), (dx / 4, dx / 2))
    ground = Ground(slope(angle), (-0.5 * length - 40.0, 0.0), (0.5 * length + 480.0, 3.0 * dx),
                    Voellmy(mu=mu, xi=xi), (OPEN, WALL))
    return flow(plan, area * depth / cosine, ground, dx, options=replace(USUAL, cfl=cfl))


def middle(solver, start, angle):
    """Speed [m/s] and way along the plane [m] of the columns that began in the middle."""
    chosen = np.abs(start[:, 0]) < 5.0
    way = (solver.particles.positions() - start)[chosen, 0] / np.cos(np.radians(angle))
    return np.linalg.norm(solver.particles.column("velocity")[chosen], axis=1).mean(), way.mean()


@pytest.mark.parametrize("case", VOELLMY, ids=["mu 0.155", "mu 0.25"])
def test_voellmy_on_a_plane(case):
    """The middle of a sheet of 300 m, which no wave from its ends reaches, to 0.5 %. Seen: 0.07 % and
    less."""
    mu, xi, depth, angle, expected = case
    solver = sheet(mu, xi, depth, angle, 300.0)
    start = solver.particles.positions()
    for time, (speed, way) in expected.items():
        v, s = middle(run_to(solver, time), start, angle)
        assert v == pytest.approx(speed, rel=0.005) if speed else s == pytest.approx(way, rel=0.005)


def test_voellmy_order_in_time():
    """The way after 10 s by the length of the step, in which the drag stands at the speed before."""
    mu, xi, depth, angle, expected = VOELLMY[0]
    errors = []
    for dt in (0.2, 0.1, 0.05):
        solver = sheet(mu, xi, depth, angle, 300.0, dx=10.0)
        start = solver.particles.positions()
        errors.append(abs(middle(run_to(solver, 10.0, dt), start, angle)[1] - expected[10.0][1]))
    assert order(errors).min() > 1.9


FOOT, STEEPNESS, MU = 500.0, 0.0007, 0.3
"""Path z = STEEPNESS (FOOT - x)^2 [m], level beyond FOOT; friction."""


def path(plan):
    return STEEPNESS * np.maximum(0.0, FOOT - plan[:, 0]) ** 2


def turned_strip(angle, dx=5.0):
    """Columns 1 um deep, without friction, on the path turned by `angle` [degrees] in plan; their places along and
    across it begin between 10 and 60 m and within 10 m of its middle. The solver, and the axes (2, 2) of the path."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.array([[cosine, sine], [-sine, cosine]])
    plan, area = lattice((10.0, -10.0), (60.0, 10.0), dx / 3)
    corners = np.array([[-20.0, -20.0], [-20.0, 20.0], [620.0, -20.0], [620.0, 20.0]]) @ axes
    ground = Ground(lambda plan: path(plan @ axes.T), tuple(corners.min(axis=0)), tuple(corners.max(axis=0)))
    return flow(plan @ axes, 1e-6 * area, ground, dx, options=replace(UNDAMPED, cfl=0.25)), axes


def strip(friction=MU, dx=5.0, **options):
    """Columns 1 um deep, whose pressure does nothing, between 10 and 60 m."""
    plan, area = lattice((10.0, 0.0), (60.0, 3.0 * dx), dx / 3)
    ground = Ground(path, (-20.0, 0.0), (1200.0, 3.0 * dx), Coulomb(mu=friction), (OPEN, WALL))
    return flow(plan, 1e-6 * area, ground, dx, options=replace(UNDAMPED, **options))


def head(solver):
    """Means of z, v^2 / 2 g and x [m]."""
    place, velocity = solver.particles.positions(), solver.particles.column("velocity")
    return place[:, 2].mean(), 0.5 * (velocity**2).sum(axis=1).mean() / G, place[:, 0].mean()


def off_the_line(solver, friction=MU):
    """Largest height of z + v^2 / 2 g + mu x over that of the start, on the way, and where all have stopped [m]."""
    z0, _, x0 = head(solver)
    heights = []
    for time in (5.0, 10.0, 15.0, 20.0, *((25.0, 60.0) if friction else ())):
        z, kinetic, x = head(run_to(solver, time))
        heights.append(abs(z + kinetic + friction * (x - x0) - z0))
    return max(heights[:5]), heights[-1]


def test_energy_without_friction():
    """Seen: 1.2 mm of 165 m, falling with the square of the step."""
    errors = [off_the_line(strip(0.0, cfl=cfl), 0.0)[0] for cfl in (0.5, 0.25)]
    assert errors[0] < 0.002 and order(errors)[0] > 1.8


def test_energy_on_a_path_across_the_grid():
    """Turned by 30 degrees against the grid the path is twisted, d2b/dx dy = 3/8 of its whole curvature: in

        w.B w = b_xx u^2 + 2 b_xy u v + b_yy v^2

    the middle term is 3/8 of it all. Energy and way are those of the path along the grid. Seen until 10 s, short of the
    foot, where the curvature jumps: z + v^2 / 2 g kept to 0.33 mm of 111 m fallen, ways of 218 to 231 m the same to
    1 um. With 2.04 for that 2 the energy is off by 107 mm."""
    found = []
    for angle in (0.0, 30.0):
        solver, axes = turned_strip(angle)
        start, (z0, _, _) = solver.particles.positions()[:, :2] @ axes.T, head(solver)
        run_to(solver, 10.0)
        z, kinetic, _ = head(solver)
        way = solver.particles.positions()[:, :2] @ axes.T - start
        assert z + kinetic == pytest.approx(z0, abs=0.003)
        np.testing.assert_allclose(way[:, 1], 0.0, atol=0.003)
        found.append(way[:, 0])
    np.testing.assert_allclose(found[1], found[0], atol=0.003)


@pytest.mark.parametrize("cfl", [None, 0.25])
def test_energy_line(cfl):
    """Heights to 0.02 m; and so the run-out, mu times which the line falls."""
    solver = strip(centrifugal=False, cfl=cfl)
    assert max(off_the_line(solver)) < 0.02
    z, kinetic, _ = head(solver)
    assert kinetic == 0.0 and z == pytest.approx(0.0, abs=0.02)


def block(x, time):
    """Place in plan and speed, after `time` [s], of a block let go at x, friction mu (g cos + kappa v^2)."""
    def rates(_, y):
        fall = 2.0 * STEEPNESS * max(0.0, FOOT - y[0])
        cosine = 1.0 / np.sqrt(1.0 + fall**2)
        curvature = 2.0 * STEEPNESS * cosine**3 if y[0] < FOOT else 0.0
        return [y[1] * cosine, G * fall * cosine - MU * (G * cosine + curvature * y[1] ** 2)]

    def stopped(_, y):
        return y[1]

    stopped.terminal, stopped.direction = True, -1
    path = solve_ivp(rates, (0.0, time), [x, 1e-9], rtol=1e-9, atol=1e-9, max_step=0.05, events=stopped)
    return path.y[0, -1], path.y[1, -1]


@pytest.mark.parametrize(("cfl", "error"), [(None, 0.002), (0.125, 0.0005)])
def test_block_with_centrifugal_friction(cfl, error):
    """Way and speed after 10 s, and run-out, 474 m; without the term it is 505 m, with 1.02 of it 0.13 % shorter. Seen:
    0.03, 0.06 and 0.12 % by usual steps, 0.01, 0.012 and 0.017 % by short ones."""
    solver = strip(centrifugal=True, cfl=cfl)
    start = solver.particles.positions()[:, 0]
    run_to(solver, 10.0)
    now, speed = solver.particles.positions()[:, 0], np.linalg.norm(solver.particles.column("velocity"), axis=1)
    chosen = [0, len(start) // 2, len(start) - 1]
    for k in chosen:
        x, v = block(start[k], 10.0)
        assert now[k] - start[k] == pytest.approx(x - start[k], rel=error)
        assert speed[k] == pytest.approx(v, rel=error)
    run_to(solver, 60.0)
    for k in chosen:
        x, _ = block(start[k], 60.0)
        assert solver.particles.positions()[k, 0] - start[k] == pytest.approx(x - start[k], rel=error)


@pytest.mark.parametrize("friction", [Coulomb(mu=0.2), Voellmy(mu=0.2, xi=1e6)], ids=["coulomb", "voellmy"])
def test_work_of_friction_on_a_plane(friction):
    """A block let go on a plane of 30 degrees: what friction took in 8 s is what weight gave less what it still has,

        W = m (g s sin - v^2 / 2),    s = a t^2 / 2, v = a t, a = g (sin - mu cos)   (Coulomb: W = m mu g cos s)

    and s, v of Voellmy's law as above, at the least depth that friction takes, LEAST_DEPTH = 1 mm. Seen: 4e-10
    and 0.05 %."""
    angle, time, depth = np.radians(30.0), 8.0, 1e-3
    plan, area = lattice((10.0, 0.0), (30.0, 15.0), 2.5)
    ground = Ground(slope(30.0), (-20.0, 0.0), (400.0, 15.0), friction, (OPEN, WALL))
    solver = run_to(flow(plan, 1e-6 * area, ground, 5.0, options=replace(UNDAMPED, cfl=0.25)), time)
    push = G * (np.sin(angle) - friction.mu * np.cos(angle))
    way, speed = 0.5 * push * time**2, push * time
    if isinstance(friction, Voellmy):
        limit = np.sqrt(friction.xi * depth * push / G)
        way = limit**2 / push * np.log(np.cosh(push * time / limit))
        speed = limit * np.tanh(push * time / limit)
    taken = solver.particles.mass * (G * way * np.sin(angle) - 0.5 * speed**2)
    assert solver.contact_work == pytest.approx(taken, rel=0.002)
