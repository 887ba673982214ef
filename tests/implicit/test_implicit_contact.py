"""Surfaces that rub and let go, obstacles and periodic sides in steps that are solved for.

The block of `tests/verification/test_block_on_incline.py` (M12): 0.10 m x 0.05 m of elastic snow on a plane that cuts
the grid anywhere, mu = tan 15 degrees. It rests below that angle, and above it slides with a = g (sin - mu cos).
"""

import numpy as np
import pytest

from snowmpm.errors import SimulationError
from snowmpm.implicit.newmark import Newmark
from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.rigid_walls import block as wall
from snowmpm.study.problems.schemes import lattice
from tests.support.implicit_steps import implicit

G, LONG, HIGH, DX = 9.81, 0.1, 0.05, 0.01
MU = np.tan(np.radians(15.0))
LAW = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3)


def on_plane(tilt):
    """Plane, and particles of the block on it."""
    plane = Plane(tilt, (0.1037, 0.1021))
    x, volumes = lattice([0.0, 0.0], [LONG, HIGH], DX)
    return plane, plane.point + x[:, :1] * plane.along + x[:, 1:] * plane.normal, volumes


def pulled(plane, slope):
    """Gravity against the plane [m/s2]."""
    return -G * (np.sin(slope) * plane.along + np.cos(slope) * plane.normal)


def solved(slope, tilt, velocity=0.0, contact="separate", **options):
    plane, x, volumes = on_plane(tilt)
    return plane, implicit(x, volumes, LAW, DX, upper=[0.4, 0.4], gravity=pulled(plane, slope),
                           velocities=np.tile(velocity * plane.along, (len(x), 1)), surfaces={
                               "terrain": plane, "terrain_contact": contact, "terrain_friction": MU}, **options)


@pytest.mark.parametrize(("degrees", "contact"), [(14.0, "separate"), (14.0, "slip"), (8.0, "separate")])
def test_a_block_rests_below_the_friction_angle(degrees, contact):
    """Ground and weight are in balance, and each line keeps Coulomb's law, though part of them slid on the way."""
    plane, solver = solved(np.radians(degrees), 0.3, contact=contact, time="quasi_static")
    step_solver, solve, seen = solver.step_solver, solver.step_solver._balanced, []

    def watched(touch, *given):
        found = solve(touch, *given)
        seen.append((touch.forces(found[0].trial.full), touch))
        return found

    step_solver._balanced = watched
    solver.step(1.0)
    F, touch = seen[-1]
    weight = solver.particles.mass * G
    np.testing.assert_allclose(solver.passed.force, -solver.particles.mass * solver.gravity, rtol=0, atol=1e-8 * weight)
    np.testing.assert_allclose(F.sum(axis=0), solver.passed.force, atol=1e-8 * weight)
    normal, along = F @ plane.normal, F @ plane.along
    slid = (np.abs(along) > 0.98 * MU * normal) & (normal > 0.01 * weight)
    assert (normal > -1e-7 * weight).all() and (np.abs(along) <= MU * np.maximum(normal, 0.0) + 1e-6 * weight).all()
    assert len(touch.state) > 8 and (slid.any() or degrees < 10.0) and not slid.all()
    assert solver.contact_work > 0.0


def test_a_block_slides_above_it():
    """Mean acceleration in steps of ten cells a wave, the swings of the start damped. Seen: 0.1 % off."""
    slope = np.radians(24.0)
    plane, solver = solved(slope, 0.4, damping=0.3)
    while solver.steps < 12:
        solver.step(0.003)
    gained = solver.particles.masses() @ solver.particles.column("velocity")
    np.testing.assert_allclose(solver.impulse + solver.weight_impulse, gained, rtol=0, atol=1e-8 * G)
    exact = G * (np.sin(slope) - MU * np.cos(slope))
    assert -gained @ plane.along / solver.particles.mass / solver.time == pytest.approx(exact, rel=0.01)
    assert solver.contact_work > 0.0


def test_a_block_comes_to_rest():
    """On the flat from 0.05 m/s within v / (mu g) = 0.019 s: it stops, and does not swing back."""
    _, solver = solved(0.0, 0.0, velocity=0.05)
    speeds = []
    while solver.steps < 12:
        solver.step(0.004)
        speeds.append(solver.particles.column("velocity").mean(axis=0)[0])
    assert speeds[2] > 0.01 and np.abs(speeds[-3:]).max() < 0.1 * 0.05


@pytest.mark.parametrize("rule", [Newmark(0.02), Newmark(0.02, damping=0.3), Newmark(0.02, starts=True)],
                         ids=["average", "damped", "starts"])
def test_way_of_a_step_that_ends_at_rest(rule):
    """From v0 = 0.05 m/s and a0 = -3 m/s2 by Newmark's rule with v1 = 0:

        a1 = -(v0 / dt + (1 - gamma) a0) / gamma,    u* = v0 dt + dt^2 ((1/2 - beta) a0 + beta a1)

    v0 dt / 2 = 0.5 mm for the average acceleration, and in a step that starts. That way ends at rest to round-off."""
    v0, a0 = np.array([0.05]), np.array([-3.0])
    last = -(v0 / 0.02 + (1.0 - rule.gamma) * a0) / rule.gamma
    way = rule.at_rest(v0, a0)
    np.testing.assert_allclose(way, v0 * 0.02 + 0.02**2 * ((0.5 - rule.beta) * a0 + rule.beta * last), rtol=1e-12)
    if not rule.damping:
        np.testing.assert_allclose(way, 5e-4, rtol=1e-12)
    np.testing.assert_allclose(v0 + rule.gain(a0, rule.acceleration(way, v0, a0)), 0.0, atol=1e-15)


def test_a_block_stops_within_a_step():
    """One of 0.05 s, where friction needs 0.019 s: it ends at rest after half of v0 dt, as above. Asked to 0.5 % of the
    speed and of the way; what is seen is 0.22 %, of the block's own elastic shear."""
    _, solver = solved(0.0, 0.0, velocity=0.05)
    start = solver.particles.positions()[:, 0].mean()
    solver.step(0.05)
    assert abs(solver.particles.column("velocity")[:, 0].mean()) < 0.005 * 0.05
    assert solver.particles.positions()[:, 0].mean() - start == pytest.approx(0.5 * 0.05 * 0.05, rel=0.005)


def test_no_balance_above_it():
    _, solver = solved(np.radians(17.0), 0.3, time="quasi_static", iterations=3)
    with pytest.raises(SimulationError) as failed:
        solver.step(1.0)
    assert "nothing holds" in str(failed.value) and len(str(failed.value).splitlines()) == 2


def test_a_surface_lets_go():
    """Pulled away from the plane the block flies off; a plane that slips holds it."""
    for contact, flies in (("separate", True), ("slip", False)):
        plane, solver = solved(np.pi, 0.3, contact=contact)
        for _ in range(4):
            solver.step(0.004)
        speed = solver.particles.column("velocity").mean(axis=0) @ plane.normal
        assert (abs(speed - G * solver.time) < 1e-6 * G * solver.time) if flies else speed < 0.5 * G * solver.time


def test_a_box_that_leans_on_an_obstacle():
    """Between a smooth floor and a wall that it may leave: the wall bears what pushes along the floor."""
    x, volumes = lattice([0.1, 0.0], [0.2, HIGH], DX)
    stop = wall((0.1, 0.025), (1.0, 0.0), 0.05, "separate")
    solver = implicit(x, volumes, LAW, DX, upper=[0.4, 0.4], gravity=[-2.0, -G], time="quasi_static",
                      sides=[["open", "open"], ["slip", "open"]], surfaces={"obstacles": [stop]})
    solver.step(0.5)
    mass = solver.particles.mass
    [row] = solver.obstacle_totals
    np.testing.assert_allclose(row[:2], [-0.5 * 2.0 * mass, 0.0], atol=1e-8 * mass)
    # Moments about the wall's middle, which is as high as the box's: the push is nearer to the foot of the box
    assert -0.5 * HIGH < row[2] / row[0] < 0.5 * HIGH and row[2] != 0.0
    np.testing.assert_allclose(solver.passed.force, mass * np.array([2.0, G]), rtol=1e-8)


@pytest.mark.slow
def test_the_end_of_an_explicit_run():
    """Damped explicit steps on the same grid, from the same unstressed block, under a weight that grows slowly.

    5 % asked of each particle, 4.4 % seen; of the mean 0.1 % along the plane and 0.5 % across. A weight that is there
    at once pushes the explicit block on, by as much again as its elastic way: friction keeps what the way was.
    """
    slope = np.radians(12.0)
    plane, solver = solved(slope, 0.3, time="quasi_static")
    _, x, volumes = on_plane(0.3)
    weight, duration = pulled(plane, slope), 0.4
    for share in (0.5, 1.0):
        solver.set_gravity(share * weight)
        solver.step(1.0)
    found = solver.particles.positions()[np.argsort(solver.particles.labels()[:, 1])] - x
    assert solver.totals.contact_lines > 0 == solver.totals.contact_spared
    explicit = MpmSolver(Population(x, volumes, 0), [LAW], dx=DX, precision="f64", origin=np.zeros(2),
                         lower=np.zeros(2), upper=np.array([0.4, 0.4]), gravity=0.0 * weight,
                         terrain=plane, terrain_contact="separate", terrain_friction=MU, gradient="shape")
    while explicit.time < duration:
        explicit.set_gravity(min(1.0, explicit.time / (0.7 * duration)) * weight)
        dt = explicit.stable_dt()[0]
        explicit.damping_factor = 1.0 - 0.05 * dt * LAW.wave_speed() / DX
        explicit.step(dt)
    way = explicit.particles.positions()[np.argsort(explicit.particles.labels()[:, 1])] - x
    np.testing.assert_allclose(way, found, rtol=0, atol=0.05 * np.abs(found).max())
    for axis in (plane.along, plane.normal):
        assert way.mean(axis=0) @ axis == pytest.approx(found.mean(axis=0) @ axis, rel=0.01)


def layer(shift, sides, long=16):
    """A layer whose left half is loaded, `shift` cells on around."""
    x, volumes = lattice([0.0, 0.0], [long * 0.1, 0.4], 0.1)
    rng = np.random.default_rng(5)
    x = x + 0.02 * rng.random(x.shape)
    moved = x + np.array([0.1 * shift, 0.0])
    moved[:, 0] %= long * 0.1
    solver = implicit(moved, volumes, Elastic(density=300.0, youngs_modulus=1e5, poisson_ratio=0.3), 0.1,
                      upper=[long * 0.1, 2.0], gravity=[2.0, -G], sides=[sides, ["stick", "open"]],
                      velocities=np.where(x[:, :1] < 0.8, 0.1, 0.0) * np.ones((1, 2)), dt=0.02)
    for _ in range(3):
        solver.step(0.02)
    order = np.argsort(solver.particles.labels()[:, 1])
    return (solver.particles.positions()[order] - moved)[:, 1], solver.particles.column("stress")[order]


def test_a_periodic_side_is_no_side():
    """Shifted around by some cells, the layer does the same to round-off, wherever the seam is."""
    way, stress = layer(0, ["periodic", "periodic"])
    for shift in (3, 11):
        other, strained = layer(shift, ["periodic", "periodic"])
        np.testing.assert_allclose(other, way, rtol=0, atol=1e-9 * np.abs(way).max())
        np.testing.assert_allclose(strained, stress, rtol=0, atol=1e-9 * np.abs(stress).max())
    cut, _ = layer(0, ["open", "open"])
    assert np.abs(cut - way).max() > 0.01 * np.abs(way).max()


def settled(side, long, height):
    """Places [m] and ways of a layer under its weight between sides of one kind; long (dim - 1,)."""
    size, dim = [*long, height], len(long) + 1
    x, volumes = lattice([0.0] * dim, size, 0.1)
    solver = implicit(x, volumes, Elastic(density=300.0, youngs_modulus=1e5, poisson_ratio=0.3), 0.1,
                      upper=[*long, 2.0], gravity=[0.0] * (dim - 1) + [-G], time="quasi_static",
                      sides=[[side, side]] * (dim - 1) + [["stick", "open"]])
    solver.step(1.0)
    return x, solver.particles.positions()[np.argsort(solver.particles.labels()[:, 1])] - x


def test_a_periodic_layer_is_a_column():
    """Under its weight alone it settles as between smooth sides."""
    (_, found), (_, between) = (settled(side, [0.8], 0.8) for side in ("periodic", "slip"))
    assert np.abs(found[:, -1]).max() > 1e-3
    # Faint nodes at the upper rim follow others beside a side than where there is none
    np.testing.assert_allclose(found, between, rtol=0, atol=1e-5 * np.abs(found).max())


@pytest.mark.slow
def test_a_period_of_four_cells():
    """In 3-D, where nodes are neighbours on both sides: the column of 2-D. Sides 0.4 m apart move it by 2e-5."""
    (x, found), (columns, expected) = settled("periodic", [0.4, 0.4], 0.4), settled("periodic", [0.8], 0.4)
    at = {round(z, 6): w for z, w in zip(columns[:, 1], expected[:, 1], strict=True)}
    way = np.array([at[round(z, 6)] for z in x[:, 2]])
    top = np.abs(way).max()
    np.testing.assert_allclose(found[:, 2], way, rtol=0, atol=1e-9 * top)
    np.testing.assert_allclose(found[:, :2], 0.0, atol=1e-9 * top)
