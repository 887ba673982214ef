"""What is at rest stays at rest (D1): a lake on uneven ground, a deposit that friction holds.

A layer of thickness cos H, normal to the ground, for the volume H over an area in plan, has its surface cos^2 H above
the ground. So a level surface z = b + cos^2 H holds the volume (z - b) / cos^2 over an area in plan (`depth.nodes`).
"""

import numpy as np
import pytest

from tests.support.depth_flows import (
    PERIODIC,
    UNDAMPED,
    USUAL,
    WALL,
    G,
    Ground,
    coulomb,
    flow,
    lattice,
    order,
    run_to,
)

LEVEL = 1.0
"""Of the lake's surface [m]."""
CELERITY = np.sqrt(G * LEVEL)


def lake(bed, slope2, side, cells, sides, options=USUAL):
    """A lake over a square, 2 x 2 columns a cell. slope2: squared slope of the bed at plan positions (n, 2)."""
    dx = side / cells
    plan, area = lattice((0.0, 0.0), (side, side), dx / 2)
    volumes = (LEVEL - bed(plan)) * (1.0 + slope2(plan)) * area
    return flow(plan, volumes, Ground(bed, (0.0, 0.0), (side, side), sides=(sides, sides)), dx, options=options)


def peak_speed(solver, time):
    """Largest speed of all columns in all steps until `time` [s], over that of waves."""
    peak = 0.0
    while solver.time < time:
        solver.step(solver.stable_dt()[0])
        peak = max(peak, solver.extremes.speed)
    return peak / CELERITY


SIDE, HILL, WIDTH = 16.0, 0.5, 2.5


def hill(plan):
    """Half as high as the lake is deep, and flat at the sides."""
    return HILL * np.exp(-((plan - 0.5 * SIDE) ** 2).sum(axis=1) / WIDTH**2)


def hill_slope2(plan):
    return (2.0 * hill(plan) / WIDTH**2) ** 2 * ((plan - 0.5 * SIDE) ** 2).sum(axis=1)


@pytest.mark.parametrize("sides", [PERIODIC, WALL], ids=["periodic", "wall"])
def test_lake_over_a_hill(sides):
    """Speeds fall with the square of the spacing, below 1e-3 sqrt(g h) at ten cells over the half-width of the hill."""
    coarse, fine = (peak_speed(lake(hill, hill_slope2, SIDE, cells, sides), 2.0) for cells in (64, 128))
    assert coarse < 1e-3
    assert order([coarse, fine])[0] > 1.7


@pytest.mark.xfail(strict=True, reason="1.68: five cells over the half-width are too few for the smoothed ground")
def test_lake_over_a_hill_of_few_cells():
    """The same order from half as many cells."""
    coarse, fine = (peak_speed(lake(hill, hill_slope2, SIDE, cells, PERIODIC), 2.0) for cells in (32, 64))
    assert order([coarse, fine])[0] > 1.7


def waves(plan):
    k = 2.0 * np.pi / SIDE
    return 0.25 * (1.0 + np.sin(k * plan[:, 0]) * np.cos(k * plan[:, 1]))


def waves_slope2(plan):
    k = 2.0 * np.pi / SIDE
    (cos_x, cos_y), (sin_x, sin_y) = np.cos(k * plan.T), np.sin(k * plan.T)
    return (0.25 * k) ** 2 * ((cos_x * cos_y) ** 2 + (sin_x * sin_y) ** 2)


@pytest.mark.parametrize("sides", [
    PERIODIC,
    pytest.param(WALL, marks=pytest.mark.xfail(
        strict=True, reason="7.7e-2, falling as dx^0.7: at a wall depths are mirrored and the bed goes on straight"))],
    ids=["periodic", "wall"])
def test_lake_on_ground_that_slopes_at_the_sides(sides):
    assert peak_speed(lake(waves, waves_slope2, SIDE, 64, sides), 2.0) < 1e-3


@pytest.mark.parametrize("damping", [USUAL, UNDAMPED], ids=["damped", "undamped"])
@pytest.mark.parametrize(("inclination", "heap"), [(0.0, 0.8), (0.6, 0.15)])
def test_deposit_below_the_friction_angle(inclination, heap, damping):
    """A cone on a plane, its surface flatter than the friction angle everywhere: it does not move at all. Slopes as
    shares of tan(30 degrees)."""
    friction, dx, radius = np.tan(np.radians(30.0)), 0.5, 4.0
    fall, rise = inclination * friction, heap * friction
    plan, area = lattice((-radius, -radius), (radius, radius), dx / 3)
    depth = rise * (radius - np.hypot(*plan.T))
    inside = depth > 0.0
    ground = Ground(lambda at: -fall * at[:, 0], (-6.0, -6.0), (6.0, 6.0), coulomb(30.0))
    solver = flow(plan[inside], depth[inside] * area, ground, dx, options=damping)
    start = solver.particles.positions()
    run_to(solver, 60.0)
    moved = np.abs(solver.particles.positions() - start)[:, :2].max()
    assert moved < 1e-6 * dx
    assert moved == 0.0  # not even by round-off


def test_deposit_above_the_friction_angle():
    """The same cone, a quarter steeper than friction holds, spreads."""
    friction, dx, radius = np.tan(np.radians(30.0)), 0.5, 4.0
    plan, area = lattice((-radius, -radius), (radius, radius), dx / 3)
    depth = 1.25 * friction * (radius - np.hypot(*plan.T))
    inside = depth > 0.0
    ground = Ground(lambda at: np.zeros(len(at)), (-6.0, -6.0), (6.0, 6.0), coulomb(30.0))
    solver = flow(plan[inside], depth[inside] * area, ground, dx)
    start = np.hypot(*solver.particles.positions()[:, :2].T).mean()
    run_to(solver, 3.0)
    assert np.hypot(*solver.particles.positions()[:, :2].T).mean() - start > 0.1 * dx
    assert solver.particles.column("velocity").any(axis=1).mean() < 0.05  # most of it lies still again
