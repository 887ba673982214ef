"""R3: steady flow of mu(I) down a rough incline, with the profile of Bagnold.

    tan(theta) = mu(I),   u(z) = 2/3 I/d sqrt(phi g cos(theta)) (h^1.5 - (h - z)^1.5),   phi = rho / rho_s

(Jop, Forterre and Pouliquen 2006, doi:10.1038/nature04801). h = 0.4 m, periodic along the slope, 20 cells. It begins
with nine tenths of these speeds, and comes up to them.
"""

import numpy as np
import pytest

from snowmpm.materials import MuI
from snowmpm.particles.fields import ParticleFields
from snowmpm.study.problems.granular_slab import G, pressed, slab
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice

DEPTH, CELLS, SLOPE = 0.4, 20, np.radians(26.0)
GRAINS = MuI(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3, static_friction=0.38, limit_friction=0.64,
             grain_diameter=0.03, grain_density=2500.0)


def inertial_number():
    """I at which mu(I) is the slope's."""
    mu = np.tan(SLOPE)
    return GRAINS.inertial_number * (mu - GRAINS.static_friction) / (GRAINS.limit_friction - mu)


def bagnold(z):
    """Speed [m/s] at heights z (n,) [m]."""
    share = GRAINS.density / GRAINS.grain_density
    scale = 2.0 / 3.0 * inertial_number() / GRAINS.grain_diameter * np.sqrt(share * G * np.cos(SLOPE))
    return scale * (DEPTH**1.5 - (DEPTH - z) ** 1.5)


@pytest.fixture(scope="module")
def flow():
    """-> solver after 8 s, and the height at which each of its particles began [m]."""
    height = lattice([0.0, 0.0], [8 * DEPTH / CELLS, DEPTH], DEPTH / CELLS)[0][:, 1]
    state, volume_ratio = pressed(GRAINS, height, DEPTH, SLOPE)
    solver = slab(GRAINS, APIC, DEPTH, CELLS, SLOPE, G, **state)
    states = ParticleStates(solver)
    states.set(volume_ratio=volume_ratio)
    states.add(velocity=np.stack([0.9 * bagnold(height), np.zeros(len(height))], axis=1))
    while solver.time < 8.0:
        solver.step(solver.stable_dt()[0])
    return solver, states, height


@pytest.mark.slow
def test_the_profile(flow):
    _, states, height = flow
    speed = states.column("velocity")[:, 0]
    upper = height > 0.2 * DEPTH
    assert np.abs(speed / bagnold(height) - 1.0)[upper].max() < 0.02


@pytest.mark.slow
def test_the_inertial_number_is_the_same_at_all_depths(flow):
    solver, _, _ = flow
    fields = ParticleFields(solver.particles)
    z = fields["position"][:, 1]
    inner = (z > 0.1 * DEPTH) & (z < 0.8 * DEPTH)
    found = fields["inertial_number"][inner]
    assert np.median(found) == pytest.approx(inertial_number(), rel=0.03)
    assert (fields["flow_regime"][inner] == 3).mean() > 0.95
