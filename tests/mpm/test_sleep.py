"""Snow that does nothing is not computed, and wakes when it should (`mpm.sleep`)."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape
from tests.mpm.sleep_cases import CALM, CASES, DX, LONG, advance, settle, stage
from tests.support.thread_counts import with_one_and_two_threads

PLAIN = CASES["2-D f64 apic"]


def motion(solver):
    """Momentum (dim,) and kinetic energy, affine part included."""
    m, v = solver.particles.masses(), solver.particles.column("velocity")
    C = solver.particles.column("affine")
    return m @ v, 0.5 * float(m @ (v**2).sum(axis=1) + solver.second_moment() * m @ (C**2).sum(axis=1))


def open_momentum(solver, start=0.0):
    """What is left of the balance, over the weight's impulse; start: the momentum then."""
    totals = solver.totals
    left = motion(solver)[0] - start - totals.impulse - totals.weight_impulse - totals.held_impulse
    return np.linalg.norm(left) / np.linalg.norm(totals.weight_impulse)


def x_of_blocks(solver):
    """Left ends of the blocks [m]."""
    return solver.frame.origin[0] + DX * 8 * solver.particles.blocks.coordinates[:, 0]


@pytest.fixture(scope="module")
def settled():
    """A layer between walls that has come to rest, all of it asleep."""
    return settle(stage(*PLAIN, drop=False, closed=True))


def again(settled):
    solver, state, _start = settled
    solver.set_loads([])
    solver.restore(state)
    return solver


def test_a_layer_at_rest_is_left_out(settled):
    solver = again(settled)
    assert solver.totals.asleep == 1.0 and solver.sleep.n_tiles == solver.grid.n_work == solver.grid.contact.n_work == 0
    before, time = solver.particles.table(), solver.time
    advance(solver, solver.steps + 20)
    assert np.array_equal(solver.particles.table(), before) and solver.time > time
    assert open_momentum(solver, settled[2]) < 1e-12


def test_what_falls_asleep_is_booked():
    """Energy and momentum that vanish from the particles in one step are those of the books."""
    solver = stage(*PLAIN, drop=False)
    while not solver.totals.asleep and solver.time < 1.0:
        totals, (_, energy) = solver.totals, motion(solver)
        solver.step(solver.stable_dt()[0])
    assert solver.totals.asleep > 0.0 and open_momentum(solver) < 1e-12
    slept = solver.totals.slept_energy - totals.slept_energy
    assert 0.0 < slept <= 1.1 * energy  # within what one step changes
    calm = CALM**2 * 9.81 * DX
    assert slept <= 0.5 * solver.particles.mass * calm * (1.0 + 2.0 * 0.25)  # |v|^2 and, by D = dx^2/4, |C|^2 dx^2


def test_a_wave_wakes_what_it_reaches():
    """A box falls on one end: the other is still asleep then, and awake when the wave has come there."""
    solver = stage(*PLAIN)
    far_asleep_at_impact, far_woke = False, False
    while solver.time < 0.75 and not far_woke:
        solver.step(solver.stable_dt()[0])
        far, asleep = x_of_blocks(solver) > LONG - 2.0, solver.sleep.asleep
        near = (x_of_blocks(solver) < 0.5) & (x_of_blocks(solver) > -0.5)
        if asleep[far].all() and not asleep[near].all():
            far_asleep_at_impact = True
        middle = (x_of_blocks(solver) > 1.5) & (x_of_blocks(solver) < 3.0)
        far_woke = far_asleep_at_impact and solver.time > 0.42 and not asleep[middle].any()
    assert far_asleep_at_impact and far_woke
    assert open_momentum(solver) < 1e-12


@pytest.mark.slow
def test_the_outcome_is_that_without_sleep():
    """Where the snow lies in the end, to a share of a cell; most of it slept."""
    ends = []
    for sleeping in (0.0, CALM):
        solver = stage(*PLAIN, sleeping=sleeping)
        while solver.time < 1.2:
            solver.step(solver.stable_dt()[0])
        order = np.argsort(solver.particles.labels()[:, 1])
        ends.append(solver.particles.positions()[order])
    assert solver.totals.asleep > 0.5
    assert np.abs(ends[1] - ends[0]).max() < 0.2 * DX


def test_a_load_wakes_the_snow_around_it_only(settled):
    solver = again(settled)
    solver.set_loads([(np.array([1.0, 0.1]), 0.2, np.array([0.0, -20.0]))])
    advance(solver, solver.steps + 8)
    awake, x = ~solver.sleep.asleep, x_of_blocks(solver)
    assert awake[(x <= 1.0) & (x + 0.8 > 1.0)].all() and not awake[x > 4.0].any()
    assert open_momentum(solver, settled[2]) < 1e-12


def test_what_presses_on_sleeping_snow_wakes_it():
    """Snow 3 blocks deep, all but its surface asleep; then the surface is pressed. What sleeps below feels it."""
    solver, *_ = settle(stage(*PLAIN, drop=False, deep=2.4, long=0.8, closed=True))
    lowest = solver.particles.blocks.coordinates[:, 1] == solver.particles.blocks.coordinates[:, 1].min()
    assert solver.sleep.asleep[lowest].all()
    solver.set_loads([(np.array([0.4, 2.4]), 0.4, np.array([0.0, -80.0]))])
    woke, end = False, solver.time + 1.0
    while solver.time < end and not woke:
        solver.step(solver.stable_dt()[0])
        woke = not solver.sleep.asleep[lowest].any()
    assert woke


def test_a_cut_wakes_the_snow_along_it_only(settled):
    solver = again(settled)
    solver.sever(np.array([[3.0], [3.2]]), 0.1, (0, 0), [])
    awake, x = ~solver.sleep.asleep, x_of_blocks(solver)
    assert awake[(x <= 3.0) & (x + 0.8 > 3.2)].all() and not awake[(x < 1.0) | (x > 5.5)].any()


def test_whoever_changes_particles_wakes_all(settled):
    solver = again(settled)
    solver.push((0, 1), np.zeros(2), 1.0)
    advance(solver, solver.steps + 1)
    assert not solver.sleep.asleep.any()


def test_snow_beside_an_obstacle_stays_awake():
    """Its load is wanted."""
    wall = Obstacle("wall", SolidShape(BOX, np.array([LONG + 0.1, 0.2]), np.eye(2), np.array([0.1, 0.4])),
                    RigidMotion(np.array([LONG + 0.1, 0.2])), "separate", 0.3)
    solver = stage(*PLAIN, drop=False, obstacles=[wall])
    while solver.time < 0.6:
        solver.step(solver.stable_dt()[0])
    x = x_of_blocks(solver)
    assert not solver.sleep.asleep[x + 0.8 > LONG - 1e-9].any()
    assert solver.sleep.asleep[(x > 1.5) & (x < 0.5 * LONG)].all()


def test_none_sleeps_in_flight():
    """Slow at the top of it, but not for long."""
    solver = stage(*PLAIN, drop=False)
    solver.particles.push((0, 10**6), np.array([0.0, 2.0]))
    slowest = np.inf
    while solver.time < 0.35:
        solver.step(solver.stable_dt()[0])
        slowest = min(slowest, solver.extremes.speed)
        assert not solver.sleep.asleep.any()
    assert slowest < 0.5 * CALM * np.sqrt(9.81 * DX)


def test_the_kernels_of_a_gpu_are_refused():
    with pytest.raises(InputError, match=r"solver\.sleeping"):
        stage(*PLAIN, atomic=True)


@pytest.mark.slow
@pytest.mark.parametrize("case", [
    case if case.startswith("2-D") else pytest.param(case, marks=pytest.mark.slow) for case in CASES])
def test_one_and_two_threads_and_a_resumed_run_leave_the_same_bits(case):
    one, two = with_one_and_two_threads("tests.mpm.sleep_cases", case)
    assert one["hash"] == two["hash"] == one["resumed"]
    assert one["shares"] == two["shares"]
    assert 0.0 < one["saved"] < 1.0 and one["shares"][-1] < max(one["shares"])  # some sleep, and some have woken
