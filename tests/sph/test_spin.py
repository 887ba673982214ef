"""A disc that spins (M18e): 10 particles in radius, 10 rad/s, in the stress that turns it round."""

import numpy as np
import pytest

from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import nearest, solver_of
from tests.support.spinning_disc import DX, LAW, RADIUS, turning_stress

OMEGA = 10.0


def spun(turns, **scheme):
    """-> spin, kinetic energy and mean square of the radius over those of the start, less 1; least spacing [dx]."""
    positions, volumes = lattice([-RADIUS] * 2, [RADIUS] * 2, DX, 1)
    inside = (positions**2).sum(axis=1) < RADIUS**2
    x = positions[inside]
    solver = solver_of(x, volumes[inside], LAW, dx=DX, scheme=scheme,
                       velocity=lambda x: OMEGA * np.stack([-x[:, 1], x[:, 0]], axis=1))
    stress, strain = (OMEGA**2 * part for part in turning_stress(x))
    states = ParticleStates(solver)
    states.set(stress=stress, elastic=2.0 * strain, volume_ratio=np.exp(strain[:, :3].sum(axis=1))[:, None])

    def measured():
        x, v = states.positions(), states.column("velocity")
        return np.array([(x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]).mean(), (v**2).sum(axis=1).mean(),
                         (x**2).sum(axis=1).mean()])

    before = measured()
    while solver.time < turns * 2.0 * np.pi / OMEGA:
        solver.step(solver.stable_dt()[0])
    return measured() / before - 1.0, nearest(solver).min()


@pytest.mark.slow
def test_ten_turns():
    change, least = spun(10.0)
    assert np.abs(change).max() < 0.002 and least > 0.9


@pytest.mark.slow
def test_plain_gradients_take_the_spin_for_a_strain():
    change, least = spun(1.0, gradient="plain")
    assert change[0] < -0.5 and least < 0.8
    change, least = spun(1.0)
    assert np.abs(change).max() < 5e-4 and least > 0.95
