"""Depth-averaged flow by finite volumes: against theory, against itself on finer cells, and what it must keep."""

import numpy as np
import pytest

import snowmpm
from snowmpm.depth.volumes.cells import FlowCells
from snowmpm.depth.volumes.solver import VolumeSolver
from snowmpm.errors import InputError
from snowmpm.materials import LAWS
from snowmpm.particles.population import Population
from snowmpm.scenes import Scene
from snowmpm.scenes.numerics import Depth
from tests.support.dam_breaks import DryDam, WetDam
from tests.support.dam_scenes import dry_scene, wet_scene
from tests.support.depth_flows import DENSITY, OPEN, PERIODIC, WALL, G, Ground, coulomb, flat, lattice, slope

DAMS = {"flat": (DryDam(), 1.0), "26 degrees": (DryDam(26.0, 18.0), 2.0), "35 degrees": (DryDam(35.0, 30.0), 2.0),
        "30 degrees": (DryDam(30.0, 20.0), 2.0)}


def broken(dam, time, dx):
    """x of the cells along the plane and depth normal to it, of a scene with the usual settings."""
    rear = 12.0 + dam.drive * time**2
    sim = snowmpm.Simulation(dry_scene(dam, dx, time, rear, scheme="volumes"))
    while sim.time < time - 1e-9:
        sim.step()
    cells, cosine = sim.solver.particles, np.cos(np.radians(dam.slope))
    x = cells.grid.places()[:, 1, 0] / cosine
    return x, cells.inner(cells.state_array)[:, 1, 0] * cosine


def place_of(x, depth, least):
    """The last place that is deeper than `least`."""
    i = np.flatnonzero(depth > least)[-1]
    return x[i] + (x[i + 1] - x[i]) * (depth[i] - least) / (depth[i] - depth[i + 1])


@pytest.mark.parametrize("name", DAMS)
def test_dam_breaks_on_slopes_have_the_depth_of_theory(name):
    dam, time = DAMS[name]
    way = np.sqrt(dam.g_z) * time
    errors = []
    for dx in (0.05, 0.025):
        x, depth = broken(dam, time, dx)
        seen = x > dam.place(1.0, time) - 1.0
        errors.append(np.abs(depth - dam.depth(x, time))[seen].sum() * (x[1] - x[0]) / way)
        assert errors[-1] < 0.02
        assert abs(place_of(x, depth, 0.1) - dam.place(0.1, time)) < 0.02 * way
    assert errors[1] < 0.7 * errors[0]


LEVEL = pytest.mark.xfail(strict=True, reason="10.2 % short on the level: a front of no depth is reached slowly; 6.8 %"
                                              " on cells of half the size")


@pytest.mark.parametrize(("name", "dx"), [pytest.param(name, dx, marks=LEVEL if (name, dx) == ("flat", 0.05) else ())
                                          for name in DAMS for dx in (0.05, 0.025)])
def test_the_tip_of_a_dam_break(name, dx):
    dam, time = DAMS[name]
    x, depth = broken(dam, time, dx)
    assert abs(x[np.flatnonzero(depth > 1e-6)[-1]] / dam.place(0.0, time) - 1.0) < 0.08


def test_a_dam_break_on_a_wet_bed():
    """Stoker's: a fan, a plateau, a shock; nothing overshoots."""
    dam, time, dx = WetDam(), 1.0, 0.025
    sim = snowmpm.Simulation(wet_scene(dx, time, dam.ahead, depth={"scheme": "volumes"}))
    while sim.time < time - 1e-9:
        sim.step()
    cells = sim.solver.particles
    x, depth = cells.grid.places()[:, 1, 0], cells.inner(cells.state_array)[:, 1, 0]
    assert np.abs(depth - dam.depth(x, time)).sum() * dx < 0.02 * np.sqrt(G) * time
    plateau = depth[(x > dam.end_of_fan * time + 0.2) & (x < dam.shock * time - 0.2)]
    assert np.abs(plateau - dam.plateau).max() < 0.02 * dam.plateau
    assert depth.max() < 1.0 + 1e-6 and depth.min() > dam.ahead - 1e-6
    middle = 0.5 * (dam.plateau + dam.ahead)
    assert abs(place_of(x[x > dam.end_of_fan], depth[x > dam.end_of_fan], middle) - dam.shock * time) < dx


def solver_of(ground, dx, depth, velocity=(0.0, 0.0), angle=0.0, precision="f64", **options):
    """`VolumeSolver` on a `Ground` with depth(plan) [m] over plan in its cells."""
    plan, area = lattice(ground.lower, ground.upper, dx)
    H = np.asarray(depth(plan), float)
    population = Population(
        positions=np.column_stack([plan, ground.height(plan)]), velocities=np.tile([*velocity, 0.0], (len(plan), 1)),
        volumes=np.maximum(H, 1e-30) * area, material=np.zeros(len(plan), int), starts=np.zeros(len(plan)))
    solver = VolumeSolver(
        population, [LAWS["elastic"](density=DENSITY, youngs_modulus=1e6, poisson_ratio=0.3)],
        Depth(scheme="volumes", **options), friction=coulomb(angle), dx=dx, precision=precision,
        lower=[*ground.lower, -1e3], upper=[*ground.upper, 1e3], gravity=[0.0, 0.0, -G], terrain=ground,
        sides=[*ground.sides, OPEN])
    solver.particles.inner(solver.particles.state_array)[..., 0] = H.reshape(solver.grid.shape)  # not spread
    solver._look()
    return solver


def run(solver, time):
    while solver.time < time - 1e-12:
        solver.step(min(solver.stable_dt()[0], time - solver.time))
    return FlowCells.inner(solver.particles.state_array).copy()


def test_order_of_a_smooth_wave():
    """Against 320 cells: of second order, but for the crests, where slopes are cut."""
    found = {}
    for n in (20, 40, 80, 320):
        ground = Ground(flat, (0.0, 0.0), (8.0, 3 * 8.0 / n), sides=(PERIODIC, PERIODIC))
        solver = solver_of(ground, 8.0 / n, lambda plan: 1.0 + 0.05 * np.sin(2.0 * np.pi * plan[:, 0] / 8.0))
        found[n] = run(solver, 0.6)[:, 0, 0]
    exact = {n: found[320].reshape(n, -1).mean(axis=1) for n in (20, 40, 80)}
    errors = [np.abs(found[n] - exact[n]).mean() for n in (20, 40, 80)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.6).all(), orders


def test_a_deposit_on_a_slope_does_not_creep():
    ground = Ground(slope(20.0), (0.0, 0.0), (20.0, 20.0))
    solver = solver_of(ground, 0.5, lambda plan: np.exp(-((plan - 10.0) ** 2).sum(axis=1) / 60.0), angle=40.0)
    before = FlowCells.inner(solver.particles.state_array).copy()
    for _ in range(200):
        solver.step(solver.stable_dt()[0])
    np.testing.assert_array_equal(FlowCells.inner(solver.particles.state_array), before)


def test_a_steep_heap_slides_until_it_rests_and_keeps_its_mass():
    ground = Ground(slope(10.0), (0.0, 0.0), (30.0, 10.0), sides=(WALL, WALL))
    solver = solver_of(ground, 0.5, lambda plan: 3.0 * (np.abs(plan[:, 0] - 8.0) < 3.0), angle=25.0)
    mass = solver.particles.mass
    run(solver, 12.0)
    assert solver.extremes.speed == 0.0
    assert solver.particles.mass == pytest.approx(mass, rel=1e-13)
    assert solver.contact_work > 0.0


def valley(plan):
    """A gully whose walls are as sharp as cells of 1 m, on a slope."""
    return -0.6 * plan[:, 0] + 2.0 * np.abs(plan[:, 1] - 10.0 + 3.0 * np.sin(0.3 * plan[:, 0]))


@pytest.mark.parametrize("bed", [valley, lambda plan: 0.05 * ((plan - 10.0) ** 2).sum(axis=1)])
def test_without_friction_energy_does_not_grow(bed):
    ground = Ground(bed, (0.0, 0.0), (40.0, 20.0), sides=(WALL, WALL))
    solver = solver_of(ground, 1.0, lambda plan: 1.5 * (np.hypot(plan[:, 0] - 8.0, plan[:, 1] - 10.0) < 4.0))

    def energy():
        cells = solver.particles
        v, x = cells.column("velocity"), cells.positions()
        return float(cells.masses() @ (0.5 * (v**2).sum(axis=1) + G * x[:, 2]))

    start, mass = energy(), solver.particles.mass
    turned = mass * G * 5.0
    for _ in range(300):
        solver.step(solver.stable_dt()[0])
        assert energy() < start + 0.02 * turned
    assert solver.particles.mass == pytest.approx(mass, rel=1e-12)


def test_a_thin_stream_keeps_its_speed_round_a_bend_of_the_ground():
    """From a slope of 45 degrees onto the flat in one cell: as fast along the ground, but for the fall."""
    ground = Ground(lambda plan: np.maximum(20.0 - plan[:, 0], 0.0), (0.0, 0.0), (90.0, 3.0), sides=(OPEN, WALL))
    solver = solver_of(ground, 1.0, lambda plan: 0.02 * ((plan[:, 0] > 5.0) & (plan[:, 0] < 8.0)), (10.0, 0.0))
    start = np.hypot(10.0, 10.0)
    state = run(solver, 2.4)
    mass = state[:, 1, 0]
    middle = (solver.grid.places()[:, 1, 0] * mass).sum() / mass.sum()
    assert middle > 25.0
    speed = (mass * state[:, 1, 1]).sum() / mass.sum()
    assert speed == pytest.approx(np.sqrt(start**2 + 2.0 * G * 13.5), rel=0.01)


@pytest.mark.parametrize("sides", [(WALL, WALL), (PERIODIC, PERIODIC), (OPEN, OPEN)])
def test_axes_and_ends_are_alike(sides):
    def bump(plan, to=lambda plan: plan):
        return 1.0 + np.exp(-((to(plan) - [6.0, 9.0]) ** 2).sum(axis=1) / 4.0)

    def bed(plan):
        return -0.3 * plan[:, 0]

    size = (16.0, 16.0)
    plain = run(solver_of(Ground(bed, (0.0, 0.0), size, sides=sides), 1.0, bump, angle=5.0), 1.0)
    swapped = run(solver_of(Ground(lambda plan: bed(plan[:, ::-1]), (0.0, 0.0), size, sides=sides), 1.0,
                            lambda plan: bump(plan, lambda one: one[:, ::-1]), angle=5.0), 1.0)
    np.testing.assert_allclose(swapped[..., [0, 2, 1]], plain.swapaxes(0, 1), atol=1e-12)
    turned = run(solver_of(Ground(lambda plan: bed(16.0 - plan), (0.0, 0.0), size, sides=sides), 1.0,
                           lambda plan: bump(plan, lambda one: 16.0 - one), angle=5.0), 1.0)
    np.testing.assert_allclose(turned[::-1, ::-1] * [1.0, -1.0, -1.0], plain, atol=1e-12)


def test_what_leaves_over_open_sides_is_counted():
    ground = Ground(slope(30.0), (0.0, 0.0), (12.0, 3.0), sides=(OPEN, WALL))
    solver = solver_of(ground, 0.5, lambda plan: 1.0 * (plan[:, 0] > 6.0), angle=10.0)
    mass = solver.particles.mass
    run(solver, 3.0)
    assert solver.particles.removed["mass"] > 0.5 * mass
    assert solver.particles.mass + solver.particles.removed["mass"] == pytest.approx(mass, rel=1e-12)


def test_sums_in_plan_add_up_to_all_snow():
    ground = Ground(slope(20.0), (0.0, 0.0), (12.0, 9.0))
    solver = solver_of(ground, 0.75, lambda plan: 1.0 + 0.1 * plan[:, 0])
    cells = solver.particles
    for lower, cell, shape in (([0.0, 0.0], 0.75, (16, 12)), ([-1.3, -0.4], 2.0, (8, 6)),
                               ([-0.2, -0.1], 0.4, (40, 30))):
        window, sums = cells.sums_in_plan(np.array(lower), cell, shape)
        assert sums[..., 1].sum() == pytest.approx(cells.mass, rel=1e-12)
        assert all(part.stop <= n for part, n in zip(window, shape, strict=True))


def test_a_run_goes_on_to_the_bit():
    ground = Ground(slope(25.0), (0.0, 0.0), (30.0, 9.0), sides=(OPEN, WALL))

    def made():
        return solver_of(ground, 0.5, lambda plan: 1.5 * (np.abs(plan[:, 0] - 6.0) < 3.0), angle=15.0, precision="f32")

    first = made()
    run(first, 1.0)
    kept = first.state()
    run(first, 2.0)
    second = made()
    second.restore(kept)
    run(second, 2.0)
    np.testing.assert_array_equal(second.particles.state_array, first.particles.state_array)
    assert second.contact_work == first.contact_work and second.steps == first.steps
    np.testing.assert_array_equal(second.totals.impulse, first.totals.impulse)


BESIDE = {
    "rim": ({"solver": {"depth": {"rim": 0.05}}}, "solver.depth.rim = 0.05: acts on columns"),
    "switch": ({"switch": [{"to": "mpm", "when": "t > 0.5", "solver": {"dx": 0.5}}]}, "switch = 'a table': hands"),
    "water": ({"water": {"scheme": "one_phase", "level": 0.5, "consolidation": 0.01}}, "water.scheme = 'one_phase'"),
}


@pytest.mark.parametrize("name", BESIDE)
def test_what_needs_columns_gets_them_and_is_refused_with_volumes(name):
    more, words = BESIDE[name]
    scene = dry_scene(DryDam(26.0, 18.0), 0.5, 1.0, 8.0, scheme="volumes").model_dump(exclude_unset=True)
    del scene["solver"]["depth"]
    more = {**more, "solver": {**scene["solver"], **more.get("solver", {})}}
    chosen = Scene.model_validate({**scene, **more})
    assert chosen.solver.depth.scheme == "columns" and "solver.depth.scheme" in str(chosen.choices[0])
    depth = {**more["solver"].get("depth", {}), "scheme": "volumes"}
    with pytest.raises(InputError, match=words.replace(".", r"\.")):
        snowmpm.Simulation(Scene.model_validate({**scene, **more, "solver": {**more["solver"], "depth": depth}}))
    assert Scene.model_validate(scene).solver.depth.scheme == "volumes" and not Scene.model_validate(scene).choices


def test_a_lake_on_gentle_ground_is_nearly_at_rest():
    """Pressure is that of the thickness normal to the ground, so that level snow on slopes is not quite at rest."""
    speeds = []
    for steep in (0.1, 0.05):
        def bed(plan, steep=steep):
            return steep * 10.0 / np.pi * np.sin(0.1 * np.pi * plan[:, 0]) * np.cos(0.1 * np.pi * plan[:, 1])

        ground = Ground(bed, (0.0, 0.0), (20.0, 20.0), sides=(PERIODIC, PERIODIC))
        solver = solver_of(ground, 0.5, lambda plan: np.full(len(plan), 1.0))
        cells = solver.particles
        level = (1.5 - cells.inner(cells.heights)) / cells.inner(cells.ground)[..., 5] ** 2
        cells.inner(cells.state_array)[..., 0] = level
        solver._look()
        speeds.append(np.abs(run(solver, 2.0)[..., 1:]).max())
    assert speeds[0] < 0.01 and speeds[1] < 0.5 * speeds[0], speeds


def test_snow_that_crosses_a_periodic_side_is_kept():
    ground = Ground(flat, (0.0, 0.0), (40.0, 6.0), sides=(PERIODIC, WALL))
    solver = solver_of(ground, 1.0, lambda plan: 2.0 * ((plan[:, 0] > 2.0) & (plan[:, 0] < 11.0)))
    mass = solver.particles.mass
    state = run(solver, 2.0)
    assert state[-1, 3, 0] > 0.01  # it came round
    assert solver.particles.mass == pytest.approx(mass, rel=1e-12)
