"""Lattices that fall apart, and what holds them together (B4-B6 of Bui & Nguyen 2021): pairing, tension, momentum.

An elastic lattice of 16 x 16 particles, periodic both ways, rho = 2700 kg/m3, E = 10 MPa, nu = 0.3, dx = 0.5 m, under
a uniform stress; one particle is kicked, or all are shifted a little. What it comes to is the least distance between
neighbours, in dx.
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import jittered, nearest, solver_of

STONE = Elastic(density=2700.0, youngs_modulus=1e7, poisson_ratio=0.3)
DX = 0.5
BARE = {"viscosity": 0.0, "disorder_damping": 0.0, "gradient": "plain"}


def least_spacing(stress, time, jitter=0.0, **scheme):
    """stress: isotropic, > 0 in tension [Pa]."""
    positions, volumes = lattice([0.0, 0.0], [16 * DX, 16 * DX], DX, 1)
    velocities = np.zeros_like(positions)
    velocities[len(positions) // 2 + 8] = 1e-3
    solver = solver_of(jittered(positions, DX, jitter), volumes, STONE, dx=DX, stress=stress * np.eye(3),
                       velocity=lambda x: velocities, lower=[0.0, 0.0], upper=[16 * DX, 16 * DX],
                       sides=[["periodic", "periodic"]] * 2, scheme={**BARE, **scheme})
    dt = 0.2 * DX / STONE.wave_speed()
    while solver.time < time:
        solver.step(dt)
        # What has gone that far needs no more
        if solver.steps % 200 == 0 and nearest(solver).min() < 0.3:
            break
    return float(nearest(solver).min())


QUICK = {("cubic_spline", 1.8), ("wendland_c2", 1.8)}
SLOWLY = pytest.mark.xfail(strict=True, reason="on this lattice, cut at 3 h and lowered to zero there, it holds 3 s")


@pytest.mark.parametrize(("kernel", "smoothing", "holds"), [
    pytest.param(*case, marks=[] if case[:2] in QUICK else [pytest.mark.slow]) for case in (
        ("cubic_spline", 1.2, True), ("cubic_spline", 1.8, False), ("cubic_spline", 2.4, False),
        ("gaussian", 1.2, True), ("gaussian", 1.8, True),
        ("wendland_c2", 1.2, True), ("wendland_c2", 1.8, True), ("wendland_c2", 2.4, True),
        ("wendland_c6", 1.8, True))] + [pytest.param("gaussian", 2.4, False, marks=[SLOWLY, pytest.mark.slow])])
def test_pairing_under_compression(kernel, smoothing, holds):
    """B4, all nine: the cubic spline pairs when it has more neighbours than at h = 1.2 dx, Wendland's kernels do not.
    The source has the Gaussian pair at 2.4 dx; the atlas finds waves that grow by 0.013 c / dx there at most."""
    found = least_spacing(-5e5, 3.0, kernel=kernel, smoothing=smoothing)
    assert found > 0.9 if holds else found < 0.5


@pytest.mark.parametrize(("cure", "holds"), [
    ({}, False), ({"artificial_stress": 0.5, "artificial_stress_power": 2.5}, True)], ids=str)
def test_clumping_in_tension(cure, holds):
    """Of 10 % strain; artificial stress cures it."""
    scheme = {"kernel": "cubic_spline", "smoothing": 1.2, "viscosity": 0.1, **cure}
    found = least_spacing(1e6, 3.0, jitter=0.02, **scheme)
    assert found > 0.7 if holds else found < 0.5


def test_momentum_by_differences_blows_up_on_irregular_particles():
    """Eq. 57 gives every particle the exact force of a uniform stress, and the whole a force of its own."""
    scheme = {"kernel": "cubic_spline", "smoothing": 1.2}
    assert least_spacing(-5e4, 2.0, jitter=0.2, momentum="difference", **scheme) < 0.4
    assert least_spacing(-5e4, 2.0, jitter=0.2, momentum="density", **scheme) > 0.5
