"""What a grid must not do to a flow: columns that only drift over it keep their momentum.

A sheet 1 m deep, of columns a little out of order, that moves at the speed Fr sqrt(g h) over level ground without
friction, all sides periodic. Particles that feel each other through a grid, by forces that conserve energy and not
momentum, are known to take what they lose from the drift when it is slower than waves, and to grow disordered ("finite-
grid instability", as of particles in cells of a plasma, arXiv:2503.13697).
"""

import numpy as np
import pytest

from tests.support.depth_flows import (
    PERIODIC,
    UNDAMPED,
    USUAL,
    G,
    Ground,
    energy,
    flat,
    flow,
    lattice,
    momentum,
    run_to,
)

DX, CELLS = 0.2, 16


def drifting(froude, options=USUAL):
    """9 columns a cell, up to 0.3 of their distance out of place."""
    side = CELLS * DX
    plan, area = lattice((0.0, 0.0), (side, side), DX / 3)
    plan = np.mod(plan + 0.1 * DX * np.random.default_rng(1).uniform(-1.0, 1.0, plan.shape), side)
    ground = Ground(flat, (0.0, 0.0), (side, side), sides=(PERIODIC, PERIODIC))
    velocities = np.tile([froude * np.sqrt(G), 0.0], (len(plan), 1))
    return flow(plan, area, ground, DX, velocities=velocities, options=options)


def lost(froude, time, options=USUAL):
    """Share of the momentum that is gone after `time` [s]."""
    solver = drifting(froude, options)
    before = momentum(solver)[0]
    return 1.0 - momentum(run_to(solver, time))[0] / before


@pytest.mark.parametrize("froude", [0.5, 1.0, 3.0])
def test_fast(froude):
    assert abs(lost(froude, 5.0)) < 1e-3


@pytest.mark.parametrize("froude", [0.2, 0.3])
def test_slow(froude):
    assert abs(lost(froude, 5.0)) < 1e-2


def test_disorder_dies_out():
    """At the speed of waves and above. Seen: 0.3 % of it after 5 s."""
    solver = run_to(drifting(1.0), 5.0)
    assert solver.particles.column("velocity").std(axis=0).max() < 0.01 * np.sqrt(G)


def test_energy_of_the_undamped_flow():
    """It stays where it is, also where momentum goes."""
    solver = drifting(0.2, UNDAMPED)
    before = energy(solver)
    assert energy(run_to(solver, 5.0)) == pytest.approx(before, rel=1e-3)
