"""A grain that flies alone: its volume has an end, and what it must close again is what it opened."""

import numpy as np
import pytest

from snowmpm.materials import ModifiedCamClay
from snowmpm.particles.response import LARGEST_RATIO
from snowmpm.stepping.time_step import DEFORMATION_LIMIT, FREE_LIMIT

SNOW = ModifiedCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, hardening=1.0, p0=0.0)


def stretch(solver, rate, steps):
    """Steps of the one particle under a velocity gradient rate I; -> J and ζ after each."""
    layout, found = solver.particles.layout, []
    for _ in range(steps):
        table = solver.particles.table()
        table[:, layout.columns("affine")] = rate * np.eye(solver.dim).ravel()
        solver.particles.overwrite(table)
        solver.step(1e-3)
        table = solver.particles.table()
        found.append((table[0, layout.columns("volume_ratio")][0], table[0, layout.columns("state")][0]))
    return np.array(found).T


@pytest.mark.parametrize("dim", [2, 3])
def test_gap_and_volume_stay_the_same_thing_beyond_the_largest_volume(make_solver, dim):
    solver = make_solver(dim, 0.1, np.zeros(dim), np.full(dim, 0.05), law=SNOW)
    assert solver.particles.count == 1
    ratio, zeta = stretch(solver, 300.0, 40)  # 36 in ln J if nothing ended it
    assert 0.2 * LARGEST_RATIO < ratio[-1] <= LARGEST_RATIO and (np.diff(ratio) >= 0.0).all()
    # Without stress it asks for a longer step than a loaded one would
    expected = 300.0 * np.sqrt(dim) * DEFORMATION_LIMIT / FREE_LIMIT
    assert solver.extremes.gradient == pytest.approx(expected, rel=0.3)  # the grid keeps about that much of it
    # To the third order that det(I + A + A²/2) leaves of each step of 0.3
    np.testing.assert_allclose(np.log(ratio), -zeta, rtol=0.02)
    ratio, zeta = stretch(solver, -300.0, 5)
    np.testing.assert_allclose(np.log(ratio), -zeta, rtol=0.02)
    assert (np.diff(ratio) < 0.0).all()
