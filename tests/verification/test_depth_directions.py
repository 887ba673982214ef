"""No direction of the grid is better than another (D9): a release on the wall of a bowl, turned by 0, 120, 225 degrees.
Maps are those of the columns turned back."""

import numpy as np
import pytest

from tests.support.depth_flows import Ground, coulomb, flow, lattice, run_to

RADIUS, RELEASE, DX = 100.0, 45.0, 1.0
"""Of the bowl, and of the release from its middle; cells [m]."""
TURNS = (0.0, 120.0, 225.0)
DURING, REST = 5.0, 15.0
"""[s]"""


def bowl(plan):
    return RADIUS - np.sqrt(RADIUS**2 - (plan**2).sum(axis=1))


def turned(plan, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return plan @ np.array([[c, s], [-s, c]])


def depth_map(grid, plan, volumes):
    """Bilinear sums of volumes over the nodes of a grid, over the area of a cell [m]."""
    cell, offset = grid.cells(plan)
    total = np.zeros(grid.shape)
    first, share = cell - (offset < 0.0), np.where(offset < 0.0, 1.0 + offset, offset)
    for i in (0, 1):
        for j in (0, 1):
            weight = np.abs(1 - i - share[:, 0]) * np.abs(1 - j - share[:, 1])
            np.add.at(total, (first[:, 0] + i, first[:, 1] + j), volumes * weight)
    return total / grid.dx**2


@pytest.fixture(scope="module")
def runs():
    """Of each turn: furthest that 99 % of the snow has come through the bowl [m], and depth maps during the flow and at
    rest."""
    plan, area = lattice((RELEASE - 8.0, -8.0), (RELEASE + 8.0, 8.0), DX / 4)
    plan = plan[np.hypot(plan[:, 0] - RELEASE, plan[:, 1]) < 8.0]
    found = []
    for turn in TURNS:
        ground = Ground(bowl, (-60.0, -60.0), (60.0, 60.0), coulomb(12.0))
        solver = flow(turned(plan, turn), 1.5 * area, ground, DX)
        furthest, maps = 0.0, []
        for time in np.arange(DURING, REST + 0.1, 0.5):
            run_to(solver, time)
            place = turned(solver.particles.positions()[:, :2], -turn)
            furthest = max(furthest, -np.quantile(place[:, 0], 0.01))
            if time in (DURING, REST):
                maps.append(depth_map(solver.grid, place, solver.particles.column("volume")[:, 0]))
        found.append((furthest, maps))
    return found


def test_furthest(runs):
    """Below one cell. Seen: 0.03 of one."""
    furthest = [far for far, _ in runs]
    assert min(furthest) > 10.0  # through the middle and up the other side
    assert np.ptp(furthest) < DX


@pytest.mark.parametrize("when", [0, 1], ids=["during", "at rest"])
def test_maps(runs, when):
    """Sum of all differences over that of all depths: 2 %. Seen: 1.7 % during the flow, 0.9 % at rest; 2.5 and 1.1 % in
    cells of 2 m."""
    first, *others = (maps[when] for _, maps in runs)
    for other in others:
        assert np.abs(other - first).sum() / first.sum() < 0.02
