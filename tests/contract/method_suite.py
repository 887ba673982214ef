"""What must hold for every method, asked through the contract and by the scenes of `method_examples` alone.

CHECKS take the name of a method.
"""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.support.same_runs import assert_goes_on_alike

MIDDLE, END = 0.006, 0.015
"""[s] of the eventful scene: while both loads act; when a body was taken out, snow left its blocks and met the wall."""
MASS = {2: given.DENSITY * given.SIDE**2, 3: given.DENSITY * given.SIDE**3}  # of the block


def steps(simulation, n):
    for _ in range(n):
        simulation.step()
    return simulation


def reach(simulation, time):
    while simulation.time < time:
        simulation.step(until=time)
    return simulation


def in_order(simulation, *names):
    """Fields in the order of the numbers of the particles."""
    fields = simulation.particles
    order = np.argsort(fields["id"])
    return [fields[name][order] for name in names]


def momentum(simulation):
    return simulation.particles["mass"] @ simulation.particles["velocity"]


# ---- physics --------------------------------------------------------------------------------------------------------


def mass_and_momentum_are_audited(method):
    simulation = Simulation(given.eventful(method))
    start = simulation.audit()
    row = reach(simulation, END).audit()
    assert row["mass"] + row["removed_mass"] == pytest.approx(start["mass"], rel=1e-12)
    assert row["particles"] + row["removed_particles"] == start["particles"]
    assert (row["removed_particles"] > 0) == given.can(method, "removal")
    assert row["momentum_residual"] < 1e-11
    # It is no balance of nothing
    assert np.linalg.norm(simulation.solver.totals.weight_impulse) > 0.1 * start["mass"] * simulation.time * given.G
    if given.able(method).terrain or given.can(method, "loads"):
        assert np.linalg.norm(simulation.solver.totals.impulse) > 1e-3 * start["mass"]
    assert np.isfinite(list(row.values())).all()


def rest_stays_at_rest(method):
    simulation = Simulation(given.resting(method))
    (before,) = in_order(simulation, "position")
    reach(simulation, 0.02)
    scale = max(np.sqrt(np.linalg.norm(simulation.solver.gravity) * given.SIDE), 1e-12)
    assert simulation.max_speed <= given.EXAMPLES[method].at_rest * scale
    (after,) = in_order(simulation, "position")
    assert np.abs(after - before).max() <= given.EXAMPLES[method].at_rest * scale * simulation.time
    assert simulation.time > 0.0 and len(after) == len(before)


def translation_is_rigid(method):
    for dim in given.able(method).dimensions:
        along = 8.0, 0.0 if given.EXAMPLES[method].grounded else 5.6, 2.4
        v = np.array(given.point(dim, *along))
        simulation = Simulation(given.scene(method, dim, bodies=[given.block(dim, along)]))
        (before,) = in_order(simulation, "position")
        reach(simulation, 0.06)  # about five cells
        after, velocity, stress = in_order(simulation, "position", "velocity", "stress")
        # Columns stand at half the depth of the snow, which the grid sees differently wherever they are
        axes = slice(0, 2 if given.EXAMPLES[method].in_plan else dim)
        np.testing.assert_allclose((after - before)[:, axes], np.broadcast_to(0.06 * v, after.shape)[:, axes], rtol=0,
                                   atol=1e-11)
        np.testing.assert_allclose(velocity, np.broadcast_to(v, velocity.shape), rtol=0, atol=1e-10)
        assert np.abs(stress).max() < 1e-4  # Pa: round-off strains of 1e-10 times E = 1e6 Pa
        assert simulation.solver.particles.sorts >= 1 or given.EXAMPLES[method].in_plan


def what_leaves_the_domain_is_booked(method):
    dim = given.least_dimension(method)
    small = {"min": given.point(dim, -0.4, -0.4, -0.4), "max": given.point(dim, 0.8, 0.8, 0.8)}
    simulation = Simulation(given.scene(method, domain=small, bodies=[given.block(dim, (8.0, 0.0))]))
    while simulation.solver.particles.removed["count"] == 0:
        simulation.step()
        assert simulation.time < 0.2
    row, removed = simulation.audit(), simulation.solver.particles.removed
    assert row["mass"] + removed["mass"] == pytest.approx(MASS[dim], rel=1e-12)
    total = momentum(simulation) + removed["momentum"]
    np.testing.assert_allclose(total, MASS[dim] * 8.0 * np.eye(dim)[0], rtol=0, atol=1e-10 * MASS[dim])
    assert row["taken_mass"] == 0.0 and row["momentum_residual"] < 1e-11


# ---- what acts on particles -----------------------------------------------------------------------------------------


def what_is_taken_out_is_booked(method):
    if not given.can(method, "removal"):
        return
    simulation = steps(Simulation(given.eventful(method, events=[])), 3)
    solver, before = simulation.solver, momentum(simulation)
    gone = solver.particles.positions()[:, 0] > 0.3
    kept = np.sort(simulation.particles["id"][~gone])
    mass = float(simulation.particles["mass"][gone].sum())
    solver.remove(gone)
    removed = solver.particles.removed
    assert solver.particles.count == len(kept) > 0 and removed["count"] == gone.sum() > 0
    assert np.array_equal(np.sort(simulation.particles["id"]), kept)
    assert removed["mass"] == pytest.approx(mass, rel=1e-12) == removed["taken"]
    np.testing.assert_allclose(momentum(simulation) + removed["momentum"], before, rtol=0,
                               atol=1e-12 * np.abs(before).max())
    steps(simulation, 3)
    assert simulation.audit()["momentum_residual"] < 1e-11 and np.isfinite(simulation.particles["position"]).all()


def loads_and_pushes_are_booked(method):
    if not given.can(method, "loads"):
        return
    dim = given.least_dimension(method)
    solver = Simulation(given.scene(method)).solver
    pull = np.array(given.point(dim, 3.0, 0.0 if given.EXAMPLES[method].grounded else -5.0, 1.0))
    solver.set_loads([(np.full(dim, 0.5 * given.SIDE), 3.0, pull)])
    dt = min(1e-3, solver.stable_dt()[0])  # without gravity nothing need limit it
    solver.step(dt)
    gained = solver.particles.snapshot().column("velocity")
    np.testing.assert_allclose(solver.totals.impulse, MASS[dim] * dt * pull, rtol=1e-9)
    np.testing.assert_allclose(gained.mean(axis=0), dt * pull, rtol=1e-9, atol=1e-15)
    solver.set_loads([])
    numbers, mass = (0, solver.particles.count), solver.particles.mass
    solver.push(numbers, 2.0 * pull, mass)
    np.testing.assert_allclose(solver.totals.impulse, MASS[dim] * (dt + 2.0) * pull, rtol=1e-9)
    np.testing.assert_allclose(solver.particles.column("velocity").mean(axis=0), (dt + 2.0) * pull, rtol=1e-9)


# ---- bits -----------------------------------------------------------------------------------------------------------


def a_resumed_run_is_the_same_to_the_bit(method, folder):
    assert_goes_on_alike(reach(Simulation(given.eventful(method)), MIDDLE), END, folder)


def float32_follows_float64(method):
    if len(given.able(method).precisions) == 1:
        return
    found = []
    for precision in ("f32", "f64"):
        simulation = reach(Simulation(given.eventful(method, precision=precision)), END)
        assert simulation.audit()["momentum_residual"] < {"f32": 1e-5, "f64": 1e-11}[precision]
        found.append([simulation.solver.steps, *in_order(simulation, "id", "position", "velocity")])
    single, double = found
    assert single[0] == double[0] and np.array_equal(single[1], double[1])
    # Positions in f32 are good to 1e-7 of a block of cells; velocities to that of E / (rho c) = 70 m/s
    np.testing.assert_allclose(single[2], double[2], rtol=0, atol=1e-5 * given.DX)
    np.testing.assert_allclose(single[3], double[3], rtol=0, atol=1e-3)


# ---- what a method says of itself -----------------------------------------------------------------------------------


def steps_and_clock_are_as_said(method):
    simulation = Simulation(given.eventful(method))
    solver = simulation.solver
    dt, cause = solver.stable_dt()
    assert 0.0 < dt <= solver.critical_dt()[0] and isinstance(cause, str)
    assert 0.0 < solver.limits.cfl <= solver.limits.critical_cfl
    assert solver.memory >= 0 and solver.workload.blocks == solver.particles.n_blocks > 0
    solver.step(0.5 * dt)
    solver.step(0.5 * dt)
    assert solver.time == pytest.approx(dt, rel=1e-12) and solver.steps == 2
    assert np.abs(solver.totals.weight_impulse).max() > 0.0
    solver.restart_clock()
    assert solver.time == 0.0 and solver.steps == 0 and solver.unconverged == 0
    totals = solver.totals
    assert not np.any([totals.impulse, totals.weight_impulse, totals.momentum_gain])
    assert totals.plastic_work == totals.contact_work == 0.0


def a_simulation_is_what_its_scene_says(method):
    can, dim = given.able(method), given.least_dimension(method)
    cells = (given.SIDE / given.DX) ** (dim - given.EXAMPLES[method].in_plan)
    for chosen in (1, 2 ** (dim - given.EXAMPLES[method].in_plan)):
        simulation = Simulation(given.scene(method, solver={"particles_per_cell": chosen}))
        assert simulation.n_particles == round((can.filling or chosen) * cells)
        assert simulation.audit()["mass"] == pytest.approx(MASS[dim], rel=1e-12)
    if not can.grid:  # choices of a grid are then nobody's
        ends = [in_order(steps(Simulation(given.eventful(method, solver=choice)), 3), "position", "velocity")
                for choice in ({}, {"transfer": "pic", "kernel": "cubic", "gradient": "shape"})]
        assert all(np.array_equal(one, other) for one, other in zip(*ends, strict=True))


CHECKS = (
    mass_and_momentum_are_audited, rest_stays_at_rest, translation_is_rigid, what_leaves_the_domain_is_booked,
    what_is_taken_out_is_booked, loads_and_pushes_are_booked, a_resumed_run_is_the_same_to_the_bit,
    float32_follows_float64, steps_and_clock_are_as_said, a_simulation_is_what_its_scene_says,
)  # fmt: skip
"""Checks of a method: check(method), the one of resumed runs also with a folder."""
