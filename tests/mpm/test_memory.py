"""Memory follows the snow, not the domain."""

import numpy as np
import pytest

from snowmpm.errors import InputError, SimulationError
from snowmpm.materials import CohesiveCamClay
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import lattice
from tests.support.mpm_block import SNOW

DX = 0.1
PARTICLE_LIMIT = 160  # bytes in 3-D, float32, one state variable: all tables and the room that a sort needs


def slab_on_slope(length):
    """A slab at the top of a slope of this length [m], 3-D."""
    slope = Plane(np.deg2rad(-30.0))

    class Slope:
        def query(self, points):
            distance, normal = slope.query(points[:, [0, 2]])
            return distance, np.insert(normal, 1, 0.0, axis=1)

    local, volumes = lattice([0.0, 0.0, 0.0], [4.0, 2.0, 0.4], DX)
    along, up = np.insert(slope.along, 1, 0.0), np.insert(slope.normal, 1, 0.0)
    x = local[:, :1] * along + local[:, 1:2] * [0.0, 1.0, 0.0] + local[:, 2:] * up
    lower = np.array([-1.0, -1.0, -length])
    return MpmSolver(Population(x, volumes, 0), [SNOW], dx=DX, precision="f32", origin=lower, lower=lower,
                     upper=[length, 3.0, 3.0], gravity=[0.0, 0.0, -9.81], terrain=Slope(), terrain_contact="separate",
                     terrain_friction=0.3)


def test_grid_memory_follows_the_snow():
    """On a slope twenty times as long as the slab, memory is that on a slope of its own length."""
    short, long = slab_on_slope(4.5), slab_on_slope(80.0)
    assert isinstance(SNOW, CohesiveCamClay) and short.particles.layout.state_size == 1
    assert len(long.particles.blocks) <= 1.1 * len(short.particles.blocks)  # blocks lie elsewhere in another domain
    assert long.grid.bytes < 1.1 * short.grid.bytes
    assert long.particles.bytes_per_particle == short.particles.bytes_per_particle <= PARTICLE_LIMIT
    domain = np.prod((long.frame.upper - long.frame.lower) + 1.0) * 16  # bytes of a dense grid, four numbers a node
    assert long.grid.bytes < 0.01 * domain


def test_more_particles_than_indices_are_refused(make_solver, monkeypatch):
    """Taichi would read and write other particles' numbers without a word."""
    # 24 numbers each in 2-D, the spare table included
    monkeypatch.setattr("snowmpm.particles.store.LARGEST_INDEX", 24 * 255)
    with pytest.raises(InputError, match=r"256 particles: at most 255 .* 32-bit"):
        make_solver(2, 0.1, np.zeros(2), np.full(2, 0.8))
    monkeypatch.setattr("snowmpm.particles.store.LARGEST_INDEX", 24 * 256)
    make_solver(2, 0.1, np.zeros(2), np.full(2, 0.8))


def test_more_nodes_than_indices_are_refused(make_solver, monkeypatch):
    monkeypatch.setattr("snowmpm.mpm.grid.node_mask", lambda flip: 250)
    with pytest.raises(SimulationError, match="32-bit"):
        make_solver(2, 0.1, np.zeros(2), np.full(2, 0.8))
