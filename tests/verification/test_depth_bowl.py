"""Snow without friction that swings in a parabolic bowl (D8), after Thacker 1981, doi:10.1017/S0022112081001882.

    planar, z = h0 (x/a)^2:    h = h0 (1 - ((x - X) / a)^2),  X = cos(w t) m,  w = sqrt(2 g h0) / a
    curved, z = h0 (r/a)^2:    h = h0 (sqrt(1 - A^2) / k - r^2 / a^2 (1 - A^2) / k^2),  k = 1 - A cos(w t),
                               w = sqrt(8 g h0) / a

The bed is so flat (cos^2 > 0.985) that what the theory leaves out, the way along the ground, stays below the errors.
Errors: L1 of the depth after one period, over all of it.
"""

import functools

import numpy as np
import pytest

from tests.support.depth_flows import OPEN, USUAL, WALL, G, Ground, depths, flow, lattice, order, run_to

H0, A = 0.5, 10.0
SHIFT, SWING = 1.0, 0.5
"""X [m] and A [-] at the start."""
PLANAR_PERIOD, CURVED_PERIOD = 20.060667, 10.030333
"""[s]"""


def planar_depth(x):
    return np.maximum(0.0, H0 * (1.0 - ((x - SHIFT) / A) ** 2))


def curved_depth(plan):
    root, k = np.sqrt(1.0 - SWING**2), 1.0 - SWING
    return np.maximum(0.0, H0 * (root / k - (plan**2).sum(axis=-1) / A**2 * (root / k) ** 2))


def relative(depth, exact):
    return np.abs(depth - exact).sum() / exact.sum()


@functools.cache
def planar(dx, options=USUAL):
    """Solver and error after a period, in a channel."""
    plan, area = lattice((SHIFT - A, 0.0), (SHIFT + A, 4.0 * dx), (dx / 4, dx))
    ground = Ground(lambda at: H0 * (at[:, 0] / A) ** 2, (-15.0, 0.0), (15.0, 4.0 * dx), sides=(OPEN, WALL))
    solver = run_to(flow(plan, planar_depth(plan[:, 0]) * area, ground, dx, options=options), PLANAR_PERIOD)
    places, depth = depths(solver)
    return solver, relative(depth, planar_depth(places[..., 0]))


@functools.cache
def curved(dx, options=USUAL):
    """Solver and error after a period; 9 columns a cell."""
    reach = 1.6 * A
    plan, area = lattice((-A, -A), (A, A), dx / 3)
    depth = curved_depth(plan)
    ground = Ground(lambda at: H0 * (at**2).sum(axis=1) / A**2, (-reach, -reach), (reach, reach))
    solver = flow(plan[depth > 0.0], depth[depth > 0.0] * area, ground, dx, options=options)
    places, now = depths(run_to(solver, CURVED_PERIOD))
    return solver, relative(now, curved_depth(places))


def test_periods():
    assert 2.0 * np.pi * A / np.sqrt(2.0 * G * H0) == pytest.approx(PLANAR_PERIOD, rel=1e-7)
    assert 2.0 * np.pi * A / np.sqrt(8.0 * G * H0) == pytest.approx(CURVED_PERIOD, rel=1e-7)


def converges(errors, gate):
    return errors[-1] < gate and order(errors).min() > 0.8


def test_planar():
    """Seen 0.8, 0.15 and 0.08 %."""
    assert converges([planar(dx)[1] for dx in (1.0, 0.5, 0.25)], 0.001)


def test_curved_converges():
    """Seen 15.7, 6.7, 2.8 %."""
    assert order([curved(dx)[1] for dx in (1.0, 0.5, 0.25)]).min() > 0.8


@pytest.mark.xfail(strict=True, reason="2.75 %: exchange where snow gathers, which keeps shocks clean, takes from the"
                   " swing; 2.1 % with mixing 12 at the nodes in place of 17 at the corners")
def test_curved():
    assert curved(0.25)[1] < 0.025


def test_edge():
    """Where the bowl is dry nothing is, nowhere is less than nothing, and no snow is lost."""
    solver, _ = curved(0.5)
    places, depth = depths(solver)
    assert depth.min() >= 0.0
    root, k = np.sqrt(1.0 - SWING**2), 1.0 - SWING
    shore = A * np.sqrt(k / root)  # of the start, so after a period as well
    assert depth[np.hypot(*np.moveaxis(places, -1, 0)) > shore + 2.0].max() == 0.0
    assert solver.particles.removed["count"] == 0
    assert depth.sum() * 0.25 == pytest.approx(solver.particles.column("volume").sum(), rel=1e-9)
