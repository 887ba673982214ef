"""Columns that are taken out: mass, momentum and energy that go with them are what the rest no longer has."""

import numpy as np
import pytest

from tests.support.depth_flows import WALL, Ground, flow, lattice

DX = 1.0


@pytest.fixture(params=[0.02, 0.6], ids=["a few", "most"])
def share(request):
    return request.param


def audit(store, gravity):
    """Mass [kg], momentum [kg m/s], kinetic and potential energy [J] of all columns."""
    mass, velocity = store.masses(), store.column("velocity")
    return mass.sum(), mass @ velocity, 0.5 * mass @ (velocity**2).sum(axis=1) - mass @ store.positions() @ gravity


def test_what_goes_is_what_the_rest_no_longer_has(share):
    """On uneven ground, with snow at a wall, and with neighbours that stay."""
    rng = np.random.default_rng(1)
    plan, area = lattice((0.0, 0.0), (60.0, 40.0), DX / 2.0)
    ground = Ground(lambda at: 3.0 * np.sin(0.2 * at[:, 0]) * np.cos(0.15 * at[:, 1]), (0.0, 0.0), (60.0, 40.0),
                    sides=(WALL, WALL))
    solver = flow(plan, area * (1.0 + 0.5 * np.sin(plan[:, 0])), ground, DX, velocities=rng.normal(size=plan.shape))
    store = solver.particles
    keep = rng.random(store.count) > share
    keep[np.hypot(*(plan - [20.0, 20.0]).T) < 2.0] = False
    before = audit(store, solver.gravity)
    left, labels = store.column("volume")[keep], store.snapshot().labels[keep]
    store.take(keep, solver.gravity)
    after, removed = audit(store, solver.gravity), store.removed
    assert store.count == keep.sum() == len(keep) - removed["count"]
    assert np.array_equal(store.column("volume"), left) and np.array_equal(store.snapshot().labels, labels)
    assert after[0] + removed["mass"] == pytest.approx(before[0], rel=1e-12)
    assert after[1] + removed["momentum"] == pytest.approx(before[1], rel=1e-12)
    assert after[2] + removed["energy"] == pytest.approx(before[2], rel=1e-11)
