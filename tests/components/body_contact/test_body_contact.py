"""Bodies in velocity fields of their own: they push, slide and part, and share momentum only while they push."""

import numpy as np
import pytest

from snowmpm.components.body_contact.mpm import BodyContact
from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import lattice

DX = 0.05
ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)


def two_boxes(boxes, velocities, *, fields=(0, 1), friction=0.0, gravity=0.0, floor=-4.0):
    """Solver of two elastic boxes above a floor they stick to, and which of its particles belong to the second."""
    parts = [lattice(lower, upper, DX) for lower, upper in boxes]
    counts = [len(volumes) for _, volumes in parts]
    dim = len(boxes[0][0])
    population = Population(
        np.concatenate([x for x, _ in parts]), np.concatenate([v for _, v in parts]), 0,
        np.repeat(np.array(velocities, float), counts, axis=0), field=np.repeat(fields, counts))
    pull = np.zeros(dim)
    pull[-1] = -gravity
    lower = np.full(dim, -4.0)
    lower[-1] = floor
    sides = [["open", "open"]] * (dim - 1) + [["stick", "open"]]
    solver = MpmSolver(population, [ICE], dx=DX, precision="f64", origin=np.full(dim, -4.0), lower=lower,
                       upper=np.full(dim, 4.0), gravity=pull, sides=sides,
                       adapters=[BodyContact(np.full((2, 2), friction), ["one", "two"])])
    return solver, lambda: solver.particles.labels()[:, 1] >= counts[0]


def test_bodies_that_part_do_not_hold_each_other():
    """Side by side in contact, moving apart: nothing happens; in one field they would be torn."""
    boxes = [([0.0, 0.0], [0.4, 0.4]), ([0.4, 0.0], [0.8, 0.4])]
    solver, second = two_boxes(boxes, [[-0.5, 0.0], [0.5, 0.0]])
    for _ in range(200):
        solver.step(solver.stable_dt()[0])
    v = solver.particles.column("velocity")
    assert np.abs(v[second()] - [0.5, 0.0]).max() < 1e-12
    assert np.abs(v[~second()] - [-0.5, 0.0]).max() < 1e-12
    assert np.abs(solver.particles.column("stress")).max() < 1e-6


@pytest.mark.parametrize("dim", [2, 3])
def test_bodies_that_collide_share_momentum(dim):
    """Equal blocks, head on, symmetric: momentum is kept to round-off and they rebound."""
    low, high = np.zeros(dim), np.full(dim, 0.3)
    shift = np.zeros(dim)
    shift[0] = 0.35
    velocity = np.zeros(dim)
    velocity[0] = 0.5
    solver, second = two_boxes([(low, high), (low + shift, high + shift)], [velocity, -velocity])
    before = (solver.particles.masses()[:, None] * solver.particles.column("velocity"))[second()].sum(axis=0)
    while solver.time < 0.25:
        solver.step(solver.stable_dt()[0])
    mass, v = solver.particles.masses(), solver.particles.column("velocity")
    # X6: what one gave the other is what that gained, and the sum of both is nothing
    reaction, gained = solver.grid.fields.given, (mass[:, None] * v)[second()].sum(axis=0) - before
    assert np.abs(reaction[1, 0] - gained).max() < 1e-12 * mass.sum() and gained[0] > 0.1 * mass.sum()
    assert np.abs(reaction.sum(axis=(0, 1))).max() == 0.0 and np.abs(reaction[0, 1] + reaction[1, 0]).max() == 0.0
    assert np.abs(mass @ v).max() < 1e-12 * mass.sum()
    apart = v[second()].mean(axis=0) - v[~second()].mean(axis=0)
    assert apart[0] > 0.5  # of 1.0; the rest vibrates
    assert np.abs(apart[1:]).max() < 1e-10
    assert solver.contact_work == pytest.approx(0.0, abs=1e-12)  # no friction, no loss


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_block_slides_on_a_block_as_coulomb_says(friction):
    """A block thrown along a slab that lies on the floor loses mu g of its speed a second."""
    g, speed, times = 9.81, 1.5, (0.1, 0.3)
    boxes = [([-1.0, 0.0], [1.0, 0.2]), ([-0.9, 0.2], [-0.6, 0.35])]
    solver, second = two_boxes(boxes, [[0.0, 0.0], [speed, 0.0]], friction=friction, gravity=g, floor=0.0)
    mean = []
    for end in times:
        while solver.time < end:
            solver.step(min(solver.stable_dt()[0], end - solver.time + 1e-12))
        mean.append(solver.particles.column("velocity")[second(), 0].mean())
    slowed = (mean[0] - mean[1]) / (times[1] - times[0])
    assert slowed == pytest.approx(friction * g, abs=0.02 * g * max(friction, 0.1))
    assert (solver.contact_work > 1e-12) == (friction > 0.0)  # J; 15 J with friction


def test_goes_on_from_its_state_bit_by_bit():
    boxes = [([0.0, 0.0], [0.3, 0.3]), ([0.3, 0.05], [0.6, 0.35])]
    solver, other = (two_boxes(boxes, [[1.0, 0.0], [-1.0, 0.2]], friction=0.3)[0] for _ in range(2))
    for _ in range(20):
        solver.step(5e-4)
    other.restore(solver.state())
    assert solver.contact_work > 0.0 and other.contact_work == solver.contact_work
    for each in (solver, other):
        for _ in range(20):
            each.step(5e-4)
    np.testing.assert_array_equal(other.particles.table(), solver.particles.table())
    assert other.contact_work == solver.contact_work
    np.testing.assert_array_equal(other.grid.fields.given, solver.grid.fields.given)
