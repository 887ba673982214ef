"""SPH on a cantilever (M11): its first frequency. L = 1 m, t = 0.1 m, 6 particles across, 0.5355 Hz (Timoshenko: 1 %
less)."""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.cantilever import first_mode
from snowmpm.study.problems.particle_states import ParticleStates
from tests.sph.stage import lattice, solver_of
from tests.verification.test_sph_elastic import crossings

EXACT, LENGTH, THICK = 0.5355, 1.0, 0.1


def frequency(**scheme):
    """-> over the exact one, amplitude of the speed kept after half a period."""
    law, dx = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3), THICK / 6

    def velocity(x):
        deflection, slope = first_mode(x[:, 0] / LENGTH)
        return 0.01 * np.stack([-x[:, 1] * slope / LENGTH, deflection], axis=1)

    positions, volumes = lattice([0.0, -0.5 * THICK], [LENGTH, 0.5 * THICK], dx)
    solver = solver_of(positions, volumes, law, dx=dx, velocity=velocity, lower=[0.0, -0.6], upper=[1.5, 0.6],
                       sides=[["stick", "open"], ["open", "open"]], scheme=scheme)
    states = ParticleStates(solver)
    mode, rows = first_mode(states.reference[:, 0] / LENGTH)[0], []
    while solver.time < 1.0 / EXACT:
        for _ in range(10):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[:, 1] * mode).mean()))
    time, speed = np.array(rows).T
    return float((0.5 / np.diff(crossings(time, speed)) / EXACT)[0]), float(-speed.min() / speed[0])


@pytest.mark.slow
def test_the_corrected_sum_is_stiffer_and_keeps_the_motion():
    plain, corrected = frequency(), frequency(momentum="corrected")
    assert corrected[0] > plain[0] + 0.03
    assert min(plain[1], corrected[1]) > 0.99


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="0.911 of it: dummies of a clamp follow means over three particles, half of the"
                                       " beam's depth, and let it turn a little; 0.876 with the usual momentum sum")
def test_first_frequency():
    assert frequency(momentum="corrected")[0] == pytest.approx(0.99, rel=0.03)
