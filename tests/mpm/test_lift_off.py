"""A body that leaves a wall leaves it freely: no pull, no stickiness, whatever the friction."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import lattice

DX, DT = 0.01, 1e-4


def pulled_off(contact, steps):
    """(solver, where particles began, pull [m/s2], plane) of a block on an oblique plane that its weight pulls off."""
    plane = Plane(np.deg2rad(-24.0))
    local, volumes = lattice([0.0, 0.0], [0.10, 0.05], DX)
    plane.point = 0.3 * DX * plane.normal
    start = plane.point + local[:, :1] * plane.along + local[:, 1:] * plane.normal
    pull = 4.0 * plane.along + 5.0 * plane.normal
    solver = MpmSolver(Population(start, volumes, 0),
                       [Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3)], dx=DX, precision="f64",
                       origin=np.zeros(2), lower=[-4.0, -4.0], upper=[4.0, 4.0], gravity=pull, terrain=plane,
                       terrain_contact=contact, terrain_friction=0.3 if contact == "separate" else 0.0)
    for _ in range(steps):
        solver.step(DT)
    return solver, start, pull, plane


def test_block_pulled_off_an_oblique_plane():
    """It moves as if the plane were not there: symplectic Euler's x = g t (t + dt) / 2, to round-off."""
    solver, start, pull, _ = pulled_off("separate", 1000)
    moved = solver.particles.positions() - start[solver.particles.labels()[:, 1]]
    expected = 0.5 * pull * solver.time * (solver.time + DT)
    np.testing.assert_allclose(moved, np.broadcast_to(expected, moved.shape), rtol=1e-9)
    assert np.abs(solver.impulse).max() < 1e-9


def test_a_plane_that_holds_the_block_pulls():
    """T1 of Larese et al. (2020): contact that sticks draws the block back, with the whole of its weight in the mean;
    contact that may part never does (above)."""
    solver, _, pull, plane = pulled_off("stick", 4000)
    weight = solver.particles.masses().sum() * pull * solver.time
    given = solver.surfaces[0].total[:2]
    assert given @ plane.normal < 0.0
    np.testing.assert_allclose(given, -weight, atol=0.05 * np.linalg.norm(weight))
