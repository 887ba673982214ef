"""Sand that flows keeps its volume only with a gradient in balance with the sum of forces: the corrected one lets
particles crowd."""

import numpy as np
import pytest

from snowmpm.materials import DruckerPrager
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import solver_of

SAND = DruckerPrager(density=1500.0, youngs_modulus=2e5, poisson_ratio=0.3, friction_angle=37.0, cone="plane_strain")
DX, REACH, FULL = 0.0125, 3.0, 28
"""Spacing [m]; distance [DX] within which a lattice has FULL others."""


def collapsed(gradient):
    """A column twice as high as its half-width, 0.5 s after its release: particles in the neighbourhood of each over
    those on a lattice (n,), J (n,)."""
    from scipy.spatial import cKDTree

    positions, volumes = lattice([0.0, 0.0], [0.2, 0.4], DX, 1)
    solver = solver_of(positions, volumes, SAND, dx=DX, gravity=[0.0, -9.81], lower=[0.0, 0.0], upper=[2.0, 1.0],
                       sides=[["slip", "open"], ["stick", "open"]], scheme={"gradient": gradient})
    while solver.time < 0.5:
        solver.step(solver.stable_dt()[0])
    assert solver.particles.removed["count"] == 0
    tree = cKDTree(solver.particles.positions())
    others = tree.query_ball_point(tree.data, 1.001 * REACH * DX, return_length=True) - 1
    return others / FULL, solver.particles.column("volume_ratio").ravel()


@pytest.mark.parametrize(("gradient", "crowds"), [("corrected", True), ("balanced", False),
                                                pytest.param("plain", False, marks=pytest.mark.slow)])
def test_particles_crowd_with_the_corrected_gradient_alone(gradient, crowds):
    others, ratio = collapsed(gradient)
    crowded = (others > 1.25).mean()
    assert crowded > 0.1 if crowds else crowded < 0.01
    if crowds:
        assert np.median(ratio[others > 1.25]) > 0.98, "J tells"
