"""X4: a bank of soil tilts a dry wall of six blocks; their motion on two grids."""

import numpy as np
import pytest

from snowmpm import Simulation, load_scene

pytestmark = pytest.mark.slow


def tilted(dx, until=1.4):
    """Displacements (6, 2) [m] and turns (6,) [rad] of the blocks, and the history's row."""
    simulation = Simulation(load_scene("block_wall_2d", {"solver.dx": dx}))
    bodies = simulation.solver.adapters["rigid_bodies"].world.bodies
    while simulation.time < until:
        simulation.step()
    moved = np.array([body.motion.centre - body.motion.start_centre for body in bodies])
    return moved, np.array([body.motion.turn[0] for body in bodies]), simulation.audit()


def test_the_blocks_move_alike_on_two_grids():
    (coarse, turned, row), (fine, finer_turned, _) = tilted(0.0625), tilted(0.05)
    assert row["rigid_momentum_residual"] < 1e-10 and row["momentum_residual"] < 1e-6
    assert (fine[1:, 0] > 0.02).all() and (finer_turned[1:] < 0.0).all()  # outwards, and over
    # X4 asks for 10 %; of the uppermost block, which goes farthest
    assert coarse[-1, 0] == pytest.approx(fine[-1, 0], rel=0.1)
    assert turned[-1] == pytest.approx(finer_turned[-1], rel=0.1)
