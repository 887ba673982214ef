"""Snow that a depth-averaged flow lays down, in a forest and where it stops: closed forms and balances."""

import numpy as np
import pytest

from snowmpm.components.forest_and_deposition.depth import Stopping
from snowmpm.depth.smoothing import surface_heights
from snowmpm.depth.snapshot import depth_at_nodes
from snowmpm.ground import Bingham, Coulomb, SamosAt, Voellmy
from tests.support.depth_flows import (
    DENSITY,
    OPEN,
    UNDAMPED,
    USUAL,
    WALL,
    G,
    Ground,
    coulomb,
    flat,
    flow,
    lattice,
    run_to,
)

ANGLE = 30.0
SLOPE = np.tan(np.radians(ANGLE))


def inclined(plan):
    return -SLOPE * plan[:, 0]


def sheet(friction, *, depth=1.0, speed=0.0, forest=None, deposition=None, options=USUAL, length=60.0, dx=1.0,
          bed=inclined):
    """`DepthSolver` of a layer `depth` [m] thick (a number, or of plan places), normal to the slope, over length x 6 m
    of a plane, with walls at the long sides; speed [m/s]: down the slope."""
    ground = Ground(bed, (0.0, 0.0), (300.0, 6.0), friction, (OPEN, WALL))
    plan, area = lattice((5.0, 0.0), (5.0 + length, 6.0), dx / 2)
    cosine = 1.0 / np.sqrt(1.0 + SLOPE**2) if bed is inclined else 1.0
    depth = depth(plan) if callable(depth) else depth
    return flow(plan, depth * area / cosine, ground, dx, velocities=np.tile([speed * cosine, 0.0], (len(plan), 1)),
                options=options, adapters=[Stopping(forest, deposition)])


def trees(drag=0.0, detrainment=0.0, start=-np.inf):
    """Forest everywhere from x = start on."""
    return lambda plan: np.where((plan[:, 0] > start)[:, None], [drag, detrainment], 0.0)


def middle(solver, name):
    """Of the columns that were in the middle third at the start, as they are now."""
    store = solver.particles
    identity = store.snapshot().labels[:, 1]
    total = identity.max() + 1
    return store.column(name)[(identity > total / 3) & (identity < 2 * total / 3)]


def test_detrainment_thins_a_sheet_of_constant_speed():
    """dh/dt = -K / (rho v): with mu = tan of the slope the speed stays, and so does its loss. To 0.5 %: the ground that
    rises behind the front is a little flatter."""
    K, v = 100.0, 20.0
    solver = sheet(Coulomb(mu=float(SLOPE)), speed=v, forest=trees(0.0, K), options=UNDAMPED)
    before = middle(solver, "volume").mean()
    run_to(solver, 4.0)
    lost = 1.0 - middle(solver, "volume").mean() / before
    assert lost == pytest.approx(K * 4.0 / (DENSITY * v * 1.0), rel=5e-3)
    np.testing.assert_allclose(np.linalg.norm(middle(solver, "velocity"), axis=1), v, rtol=5e-3)


@pytest.mark.parametrize("law", [Coulomb(mu=0.3), Voellmy(mu=0.2, xi=2000.0)], ids=["coulomb", "voellmy"])
def test_drag_of_trees_limits_the_speed(law):
    """As a Voellmy block: v = v_inf tanh(t / T), v_inf² = h g (sin - mu cos) / (c + g/xi), T = v_inf / (g (sin - mu
    cos)). 0.05 % is seen in the middle of a sheet."""
    c = 0.02
    solver = sheet(law, forest=trees(c))
    run_to(solver, 6.0)
    pull = G * (np.sin(np.radians(ANGLE)) - law.mu * np.cos(np.radians(ANGLE)))
    limit = np.sqrt(pull / (c + (G / law.xi if law.law == "voellmy" else 0.0)))
    found = np.median(np.linalg.norm(middle(solver, "velocity"), axis=1))
    assert found == pytest.approx(limit * np.tanh(6.0 * pull / limit), rel=2e-3)


@pytest.mark.parametrize("law", [SamosAt(mu=0.2), Bingham(yield_stress=50.0, viscosity=10.0)],
                         ids=["samos_at", "bingham"])
def test_drag_adds_to_any_law(law):
    """Where there are no trees, to the bit as without; where there are, slower."""
    found = []
    for forest in (None, trees(0.1, start=100.0), trees(0.1)):
        solver = run_to(sheet(law, forest=forest, length=20.0), 2.0)
        found.append(solver.particles.column("velocity"))
    np.testing.assert_array_equal(found[0], found[1])
    assert found[2][:, 0].mean() < 0.9 * found[0][:, 0].mean()


def waves(plan):
    """Depths that change from cell to cell, no steeper than 17 degrees."""
    return 1.0 + 0.2 * np.sin(1.5 * plan[:, 0])


def test_the_surface_stays_where_snow_becomes_ground():
    """On level ground, of depths that change within cells: away from the walls and the ends to round-off."""
    solver = sheet(coulomb(40.0), depth=waves, deposition=1.0, bed=flat)
    top = surface(solver)[20:50]
    assert np.ptp(top) > 0.2
    for _ in range(5):
        solver.step(0.3)
    assert solver.particles.removed["laid"] > 0.5 * (solver.particles.mass + solver.particles.removed["laid"])
    np.testing.assert_allclose(surface(solver)[20:50], top, rtol=0.0, atol=1e-12)


def test_snow_at_rest_becomes_ground():
    """dm/dt = -m / T, to round-off whatever the step, away from the ends of the sheet, which slump; the surface of snow
    and ground together stays where it is; a deposit that friction holds does not begin to move."""
    solver = sheet(coulomb(40.0), deposition=2.0)
    volume, top = middle(solver, "volume"), surface(solver)[20:50]
    for dt in (0.3, 0.2, 0.5):
        solver.step(dt)
    np.testing.assert_allclose(middle(solver, "volume"), volume * np.exp(-1.0 / 2.0), rtol=1e-12)
    assert (middle(solver, "velocity") == 0.0).all()
    np.testing.assert_allclose(surface(solver)[20:50], top, rtol=0.0, atol=1e-12)


def surface(solver):
    """Height of ground and vertical depth of snow at the nodes [m]."""
    store, grid = solver.particles, solver.grid
    reals = store.reals.to_numpy()[: store.count].astype(float)
    first, depth = depth_at_nodes(grid, store.cells.to_numpy()[: store.count].astype(int), reals)
    height = solver.bed.heights[4:-4, 4:-4].copy()
    part = tuple(slice(low, low + k) for low, k in zip(first, depth.shape, strict=True))
    height[part] += surface_heights(depth, np.ones_like(depth), grid.repeats)
    return height


def bowl(plan):
    """A channel that runs out on the flat."""
    return np.where(plan[:, 0] < 60.0, SLOPE * (60.0 - plan[:, 0]), 0.0)


@pytest.mark.parametrize(("forest", "deposition"), [
    (trees(0.01, 200.0, start=40.0), None), (None, 0.5), (None, 0.0), (trees(0.0, 50.0), 1.0)])
def test_mass_and_momentum_close(forest, deposition):
    """An avalanche that runs out: what flows and what was laid down is what was released; the ground has risen by the
    volume laid down, and the maps hold it."""
    solver = sheet(coulomb(18.0), forest=forest, deposition=deposition, bed=bowl, length=25.0)
    store, ground = solver.particles, solver.bed.heights[4:-4, 4:-4].sum()
    mass, start = store.mass, store.masses() @ store.column("velocity")
    run_to(solver, 12.0)
    removed = store.removed
    assert removed["mass"] == 0.0 and removed["laid"] > 0.05 * mass
    assert store.mass == pytest.approx(store.masses().sum(), rel=1e-10, abs=1e-12 * mass)
    assert store.mass + removed["laid"] == pytest.approx(mass, rel=1e-12)
    gained = store.masses() @ store.column("velocity") + removed["momentum"] - start
    np.testing.assert_allclose(gained[:2], solver.totals.impulse[:2], rtol=0.0, atol=1e-9 * mass)
    held = solver.adapters["forest_and_deposition"].deposit.laid.to_numpy().sum()
    # A column that is taken out for good leaves the 1e-5 that it still holds
    assert held == pytest.approx(removed["laid"] / DENSITY, rel=2e-5)
    assert (solver.bed.heights[4:-4, 4:-4].sum() - ground) * solver.grid.dx**2 == pytest.approx(held, rel=1e-9)
    resting = store.resting_in_plan(np.array([-0.7, -0.3]), 2.3, (140, 4))
    assert resting.sum() == pytest.approx(held, rel=1e-9)


def test_all_may_be_laid_down():
    solver = sheet(coulomb(40.0), deposition=0.0)
    mass = solver.particles.mass
    run_to(solver, 3.0, 0.1)
    assert solver.particles.count == 0 and solver.particles.removed["count"] == 0
    assert solver.particles.removed["laid"] == pytest.approx(mass, rel=1e-12)


def test_energy_of_what_is_laid_down():
    """On level ground without friction, trees take energy out of a broad stream in proportion to the mass that they
    stop: with what was laid down, it closes as well as without trees."""
    solver = sheet(coulomb(0.0), speed=8.0, forest=trees(0.0, 300.0), options=UNDAMPED, bed=flat)

    def energy():
        store = solver.particles
        v2 = (store.column("velocity") ** 2).sum(axis=1)
        return float(store.masses() @ (0.5 * v2 + G * store.positions()[:, 2]))

    before = energy()
    run_to(solver, 2.0)
    assert solver.particles.removed["laid"] > 0.2 * (solver.particles.mass + solver.particles.removed["laid"])
    assert energy() + solver.particles.removed["energy"] == pytest.approx(before, rel=0.01)
