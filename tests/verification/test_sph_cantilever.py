"""SPH on a cantilever (M11; B7 in three dimensions): its first frequency. M11: L = 1 m, t = 0.1 m, 0.5355 Hz for a
slender beam, of which shear takes 1 %.

The corrected gradient and the sum of forces in balance with it. At a free surface their fit is one-sided, and sees the
bending strain of the outer layer nearer the middle than it is: the beam is 9 % too slow with 6 particles across it, 3 %
with 12, less with a narrower kernel. The clamp is not what gives way: half of a beam that swings free of any, against a
mirror, is as slow.
"""

import functools

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.cantilever import first_mode
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.crossings import crossings
from tests.support.sph_block import nearest, solver_of

LENGTH, THICK = 1.0, 0.1
CLAMPED, FREE = 1.875104, 2.365020
"""k L of the first mode of a beam clamped at one end, and of half of one that is free at both."""


def free_mode(x):
    """Deflection and slope of half a free beam at x / L from its middle."""
    z = FREE * x
    return (np.cos(z) / np.cos(FREE) + np.cosh(z) / np.cosh(FREE),
            FREE * (np.sinh(z) / np.cosh(FREE) - np.sin(z) / np.cos(FREE)))


def frequency(across, clamped=True, **scheme):
    """First frequency over that of a slender beam, from the first quarter of a period."""
    law, dx = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3), THICK / across
    mode, side = (first_mode, "stick") if clamped else (free_mode, "slip")
    exact = 0.5355 * (1.0 if clamped else (FREE / CLAMPED) ** 2)

    def velocity(x):
        deflection, slope = mode(x[:, 0] / LENGTH)
        return 0.01 * np.stack([-x[:, 1] * slope / LENGTH, deflection], axis=1)

    positions, volumes = lattice([0.0, -0.5 * THICK], [LENGTH, 0.5 * THICK], dx, 1)
    solver = solver_of(positions, volumes, law, dx=dx, velocity=velocity, lower=[0.0, -0.6], upper=[1.5, 0.6],
                       sides=[[side, "open"], ["open", "open"]], scheme=scheme)
    states = ParticleStates(solver)
    shape, rows = mode(states.reference[:, 0] / LENGTH)[0], []
    while solver.time < 0.35 / exact:
        for _ in range(10):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[:, 1] * shape).mean()))
    time, speed = np.array(rows).T
    return float(0.25 / crossings(time, speed)[0] / exact)


@pytest.mark.slow
def test_first_frequency():
    assert frequency(12, momentum="corrected", smoothing=1.2) == pytest.approx(0.99, rel=0.03)


@pytest.mark.slow
def test_the_corrected_sum_is_stiffer_and_the_clamp_is_not_to_blame():
    plain, corrected = (frequency(6, momentum=form) for form in ("density", "corrected"))
    assert corrected > plain + 0.03
    assert frequency(6, clamped=False, momentum="corrected") == pytest.approx(corrected, abs=0.02)
    assert 0.97 * corrected < 0.91 < 1.03 * corrected


WIDE, LONG, SWING = 0.2, 2.0, 0.1
"""Of B7 (Bui, ALERT 2020), b x d = 0.2 x 0.1 m, L = 2 m [m]; deflection of the tip, chosen [m]."""


@functools.cache
def swinging(across):
    """B7 with so many particles over its depth, artificial stress on: time [s] and speed in the first mode over that of
    the start, along the first 0.6 periods of a slender beam; its solver, and that period.
    """
    law, dx = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3), THICK / across
    omega = CLAMPED**2 / LONG**2 * np.sqrt(law.youngs_modulus / law.density / 12.0) * THICK
    tip = first_mode(np.ones(1))[0][0]

    def velocity(x):
        deflection, slope = (part * SWING * omega / tip for part in first_mode(x[:, 0] / LONG))
        return np.stack([-x[:, 2] * slope / LONG, 0.0 * slope, deflection], axis=1)

    positions, volumes = lattice([0.0, 0.0, -0.5 * THICK], [LONG, WIDE, 0.5 * THICK], dx, 1)
    open_ = ["open", "open"]
    solver = solver_of(positions, volumes, law, dx=dx, velocity=velocity, lower=[0.0, -0.3, -0.6],
                       upper=[2.4, 0.5, 0.6], precision="f32", sides=[["stick", "open"], open_, open_],
                       scheme={"momentum": "corrected", "smoothing": 1.2, "artificial_stress": 0.5})
    states, rows = ParticleStates(solver), []
    shape = first_mode(states.reference[:, 0] / LONG)[0]
    start = (states.column("velocity")[:, 2] * shape).mean()
    while solver.time < 0.6 * 2.0 * np.pi / omega:
        for _ in range(50):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[:, 2] * shape).mean() / start))
    return *np.array(rows).T, solver, 2.0 * np.pi / omega


COARSE = pytest.param(4, marks=pytest.mark.xfail(strict=True, reason="10.5 % too slow, see the top of this file"))


@pytest.mark.slow
@pytest.mark.parametrize("across", [COARSE, 5])
def test_a_beam_in_three_dimensions_swings_at_the_frequency_of_beam_theory(across):
    """To 10 %, which is chosen: the source gives neither figures nor a spacing. Five particles over the depth, added
    after four had missed it, are 7.1 % too slow."""
    time, speed, _, period = swinging(across)
    assert period / 4.0 / crossings(time, speed)[0] == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_nothing_comes_apart_and_stress_is_smooth():
    """Axial stress near the clamp is linear over the depth to 15 %; nothing is lost or clumps, and damping is weak."""
    _, speed, solver, _ = swinging(4)
    states = ParticleStates(solver)
    near = np.abs(states.reference[:, 0] - 0.3) < 0.1
    z, stress = states.reference[near, 2], states.column("stress")[near, 0]
    fit = np.polyval(np.polyfit(z, stress, 1), z)
    assert (stress - fit).std() < 0.15 * fit.std()
    assert solver.particles.count == len(states.reference) and solver.particles.removed["count"] == 0
    assert 0.9 < nearest(solver).min() < nearest(solver).max() < 1.1
    assert -1.0 < speed.min() < -0.8
