"""Edges of obstacles: a face acts on the snow that lies on it, not on snow that lies on the face beside it."""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import lattice

DX, SPEED, WIDE, HIGH = 0.01, 0.3, 10, 4
LAW = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.2)
HALF = 12 * DX
"""Half side of the obstacle [m]."""


def slide(edge, bottom, begin, seconds):
    """Momentum [over that at the start] of an elastic block that moves against x, and its lowest x [cells].

    edge: of the obstacle's upper right corner, bottom and begin: of the block's lower left one [cells]."""
    x, volumes = lattice([begin * DX, bottom * DX], [(begin + WIDE) * DX, (bottom + HIGH) * DX], DX)
    velocity = np.tile([-SPEED, 0.0], (len(x), 1))
    obstacle = block([edge * DX - HALF, 0.0], [0.0, 1.0], HALF, "separate")
    solver = MpmSolver(Population(x, volumes, 0, velocity), [LAW], dx=DX, precision="f64", origin=np.zeros(2),
                       lower=[-1.0, -1.0], upper=[1.0, 1.0], gravity=np.zeros(2), obstacles=[obstacle])
    while solver.time < seconds:
        solver.step(solver.stable_dt()[0])
    particles = solver.particles
    mean = (particles.column("velocity") * volumes[0]).sum(axis=0) / volumes.sum()
    return mean / -SPEED, particles.positions()[:, 0].min() / DX


@pytest.mark.parametrize("edge", [0.0, 0.25, 0.5, 0.75])
def test_a_block_slides_off_a_plate_as_if_its_flank_were_not_there(edge):
    """Without friction, wherever the edge lies between the nodes: the flank once took 32 to 143 % of the momentum."""
    momentum, farthest = slide(edge, 0.0, -WIDE / 2, 3 * DX / SPEED)
    np.testing.assert_allclose(momentum, [1.0, 0.0], atol=1e-6)
    assert farthest < -WIDE / 2 - 2.5


@pytest.mark.parametrize("edge", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("bottom", [-2.0, -1.0])
def test_a_flank_stops_what_reaches_below_the_edge(edge, bottom):
    """A block half, or a quarter, of which meets the flank turns back, and does not enter it by half a cell."""
    momentum, farthest = slide(edge, bottom, edge + 1.0, 8 * DX / SPEED)
    assert momentum[0] < 0.0
    assert farthest > edge + 0.25 - 0.5
