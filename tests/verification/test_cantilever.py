"""A cantilever (M11): its first frequency, and how far it hangs under its own weight.

Plane strain: EI = E' t^3 / 12, E' = E / (1 - nu^2). First frequency of a slender beam (1.875104^2 / 2 pi L^2)
sqrt(E' t^2 / 12 rho) = 0.5355 Hz for L = 1 m, t = 0.1 m, E = 1e6 Pa, nu = 0.3, rho = 1000 kg/m3; shear, and rotation of
its slices, make it 1 % slower (Timoshenko). The hanging beam follows the elastica, with q its weight per length:
qL^3/EI = 1 lowers its end by 0.123471 L, 5 by 0.495905 L. The clamp is a side that sticks, half a cell off the nodes.

Small deflections are right to 0.4 %. With the affine gradient, large ones come out too large by about 4 % for each
thickness that the end moves, on any grid: it is not quite the gradient of the motion, and the outermost particles drift
apart by more than their own strain says. The gradient of the shape functions is that of the motion.
"""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.cantilever import LENGTH, SMALL_LOAD, THICKNESS, beam, first_mode, hang, small_deflection
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import AFLIP, APIC, FLIP


@pytest.mark.parametrize(("scheme", "kept"), [
    (APIC, 0.97), (AFLIP, 0.97), pytest.param(replace(APIC, kernel="cubic"), 0.97, marks=pytest.mark.slow),
    pytest.param(FLIP, 0.9, marks=pytest.mark.slow)], ids=str)
def test_first_frequency(scheme, kept):
    """kept: of the amplitude of the speed after half a period."""
    law, exact = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3), 0.5355

    def velocity(x):
        deflection, slope = first_mode(x[:, 0] / LENGTH)
        return 0.01 * np.stack([-x[:, 1] * slope / LENGTH, deflection], axis=1)

    solver = beam(law, scheme, 0.1, 6, velocity=velocity)
    states, rows = ParticleStates(solver), []
    mode = first_mode((states.reference[:, 0] - 0.5 * solver.dx) / LENGTH)[0]
    while solver.time < 0.8 / exact:
        for _ in range(20):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[:, 1] * mode).mean()))
    time, speed = np.array(rows).T
    n = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    crossings = time[n] - speed[n] * (time[n + 1] - time[n]) / (speed[n + 1] - speed[n])
    frequency = 0.5 / np.diff(crossings)
    assert frequency == pytest.approx([0.99 * exact], rel=0.01)
    assert -speed.min() > kept * speed[0]


def test_a_small_deflection():
    """q L^3 / 8 EI, and what shear adds to it, 0.8 % at L / t = 10."""
    assert -hang(SMALL_LOAD, THICKNESS)[1] == pytest.approx(small_deflection(), rel=0.01)


BENT = pytest.mark.xfail(strict=True, reason="affine: 4 % too far per thickness of deflection; quadratic shape: 8 %")
SMALL, LARGE = (1.0, 0.123471), (5.0, 0.495905)
SHAPE, CUBIC = replace(APIC, gradient="shape"), replace(APIC, gradient="shape", kernel="cubic")


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "load", "down"), [
    (CUBIC, *SMALL), (CUBIC, *LARGE), (SHAPE, *SMALL), pytest.param(SHAPE, *LARGE, marks=BENT),
    pytest.param(APIC, *SMALL, marks=BENT), pytest.param(APIC, *LARGE, marks=BENT)], ids=str)
def test_hanging_under_its_weight(scheme, load, down):
    """L / t = 20, six cells. Seen: cubic with shape gradients +0.6, +1.0 %; quadratic +1.0, +7.8 %."""
    assert -hang(load, 0.05, scheme)[1] == pytest.approx(down, rel=0.03)
