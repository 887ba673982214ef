"""SPH on elastic problems with exact answers: a bar that vibrates (M4), waves (M8), a bar against a wall (M9).

The viscosity of the default is on: without it a lattice in alternating tension falls apart within a period (tensile
instability), with it the vibration keeps 99 % of its amplitude. A front against a wall wants three times as much.
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.crossings import crossings
from tests.support.elastic_pulse import DX, LAW, SPEEDS, STRAIN, TRAVEL, pulse, set_off
from tests.support.sph_block import nearest, solver_of
from tests.support.thrown_bar import LAW as BAR
from tests.support.thrown_bar import SPEEDS as IMPACTS

LENGTH, PERIOD = 25.0, 10.0


def vibration(cells, side, periods):
    """-> period of the first mode, amplitude of the mean velocity in the last half period over the first one."""
    dx = LENGTH / cells
    positions, volumes = lattice([0.0, 0.0], [LENGTH, 4 * dx], dx, 1)
    solver = solver_of(positions, volumes, Elastic(density=1.0, youngs_modulus=100.0, poisson_ratio=0.0), dx=dx,
                       lower=[0.0, 0.0], upper=[2 * LENGTH, 4 * dx], sides=[[side, "open"], ["slip", "slip"]],
                       velocity=lambda x: np.stack([0.1 * np.sin(np.pi * x[:, 0] / (2 * LENGTH)), 0.0 * x[:, 0]], 1))
    dt, times, means = 0.3 * dx / 10.0, [], []
    while solver.time < periods * PERIOD:
        solver.step(dt)
        times.append(solver.time - 0.5 * dt)
        means.append(solver.particles.column("velocity")[:, 0].mean())
    times, means = np.array(times), np.array(means)
    return (2.0 * np.diff(crossings(times, means)).mean() / PERIOD,
            np.abs(means[times > (periods - 0.5) * PERIOD]).max() / means[0])


@pytest.mark.parametrize("side", [pytest.param("stick", marks=pytest.mark.slow), "symmetric"])
def test_period_of_a_bar(side):
    coarse, fine = vibration(25, side, 1.9), vibration(50, side, 1.9)
    assert abs(fine[0] - 1.0) < 0.005
    assert abs(fine[0] - 1.0) < 0.7 * abs(coarse[0] - 1.0)
    assert 0.98 < fine[1] < 1.001


@pytest.mark.slow
def test_bar_over_ten_periods():
    period, kept = vibration(50, "stick", 10.0)
    assert abs(period - 1.0) < 0.005
    assert 0.9 < kept < 1.001


@pytest.mark.parametrize("kind", [pytest.param("pressure", marks=pytest.mark.slow), "shear"])
def test_a_pulse_keeps_its_speed_and_its_peak(kind):
    length = 16 / 0.364 * DX
    positions, volumes = lattice([0.0, 0.0], [3.2, 8 * DX], DX, 1)
    solver = solver_of(positions, volumes, LAW, dx=DX, lower=[0.0, 0.0], upper=[3.2, 8 * DX],
                       sides=[["periodic", "periodic"]] * 2)
    steps = int(np.ceil(TRAVEL / SPEEDS[kind] / (0.3 * DX / LAW.wave_speed())))
    dt = TRAVEL / SPEEDS[kind] / steps
    states = set_off(solver, kind, length, 0.5, dt)
    for _ in range(steps):
        solver.step(dt)
    row = np.flatnonzero(states.reference[:, 1] < 0.6 * DX)
    x = states.reference[row, 0]
    v = states.column("velocity")[row, int(kind == "shear")] / (STRAIN * SPEEDS[kind])
    shifts = np.linspace(0.95 * TRAVEL, 1.05 * TRAVEL, 2001)
    best = shifts[np.argmax([v @ pulse(x - 0.5 - shift, length) for shift in shifts])]
    assert best / TRAVEL == pytest.approx(1.0, abs=0.01)
    assert 0.9 < v.max() < 1.001


@pytest.mark.slow
def test_rayleigh_wave():
    """As `test_waves.test_rayleigh_wave`: the frequency of a standing wave of 32 cells, from the velocity of its mode;
    the free surface is where the kernel is cut off."""
    wavelength, depth = 32 * DX, 96 * DX
    positions, volumes = lattice([0.0, 0.0], [wavelength, depth], DX, 1)
    k, c = 2 * np.pi / wavelength, SPEEDS["rayleigh"]
    q, s = (np.sqrt(1.0 - (c / SPEEDS[kind]) ** 2) for kind in ("pressure", "shear"))
    B = -2.0 * q / (1.0 + s**2)

    def mode(x):
        z = depth - x[:, 1]
        return np.stack([np.sin(k * x[:, 0]) * (np.exp(-q * k * z) + s * B * np.exp(-s * k * z)),
                         -np.cos(k * x[:, 0]) * (q * np.exp(-q * k * z) + B * np.exp(-s * k * z))], axis=1)

    solver = solver_of(positions, volumes, LAW, dx=DX, lower=[0.0, 0.0], upper=[wavelength, 2 * depth],
                       velocity=lambda x: STRAIN * c * mode(x),
                       sides=[["periodic", "periodic"], ["stick", "open"]])
    states = ParticleStates(solver)
    shape = mode(states.reference)
    times, amplitudes = [], []
    dt = 0.3 * DX / LAW.wave_speed()
    while solver.time < 1.9 * wavelength / c:
        solver.step(dt)
        times.append(solver.time - 0.5 * dt)
        amplitudes.append((states.column("velocity") * shape).sum())
    found = crossings(np.array(times), np.array(amplitudes))
    assert wavelength / (2.0 * np.diff(found).mean()) == pytest.approx(c, rel=0.03)


def impact(speed, **scheme):
    """A bar against a wall: -> its solver afterwards, times over that of contact, stress on the wall over that of the
    shock."""
    dx, high, exact = 0.01, 0.04, IMPACTS[speed][2]
    positions, volumes = lattice([0.0, 0.0], [1.0, high], dx, 1)
    solver = solver_of(positions, volumes, BAR, dx=dx, velocity=lambda x: np.tile([-speed, 0.0], (len(x), 1)),
                       lower=[0.0, 0.0], upper=[2.0, high], sides=[["separate", "open"], ["slip", "slip"]],
                       scheme=scheme)
    contact, rows = 2.0 / BAR.wave_speed(), []
    while solver.time < 1.3 * contact:
        before, start = solver.impulse[0], solver.time
        solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (solver.impulse[0] - before) / (solver.time - start) / high))
    time, stress = np.array(rows).T
    return solver, time / contact, stress / exact


@pytest.mark.parametrize(("speed", "alpha"), [
    (1.0, 0.3), pytest.param(5.0, 0.3, marks=pytest.mark.slow), pytest.param(1.0, 1.0, marks=pytest.mark.slow)])
def test_bar_against_a_wall(speed, alpha):
    """M9: mean stress to 3 %, overshoot of at most 30 %."""
    solver, time, stress = impact(speed, viscosity=alpha)
    assert stress[(time > 0.2) & (time < 0.8)].mean() == pytest.approx(1.0, rel=0.03)
    assert stress.max() < 1.3
    momentum = solver.particles.masses() @ solver.particles.column("velocity")[:, 0]
    assert 0.9 < momentum / (solver.particles.mass * speed) < 1.0
    # The wall takes no energy that it did not give: a bar that leaves has what the viscosity left it
    assert abs(solver.contact_work) < 0.06 * 0.5 * solver.particles.mass * speed**2


@pytest.mark.slow
@pytest.mark.parametrize("scheme", [
    {}, {"smoothing": 2.0}, {"kernel": "cubic_spline"}, {"momentum": "corrected"}, {"disorder_damping": 1.0},
    {"quadratic_viscosity": 1.0}], ids=str)
def test_a_bar_rings_with_the_usual_viscosity(scheme):
    """By 40 %, and nothing but the viscosity does much about it: smoothing lengths from 1 to 2 give 45 to 38 %, other
    kernels, gradients and sums of forces 40 to 42 %, no viscosity 49 %. A quadratic part of 10 does what 0.3 does, at
    this speed alone, and lowers heaps more: the column of a = 2 (`test_columns`) by 13.9 %, where 0.3 has 12.5 and the
    usual one 11.9 %."""
    assert 1.35 < impact(1.0, **scheme)[2].max() < 1.45


def collide(**scheme):
    """Two rings (inner radius 3, outer 4, dx = 0.1; mu / K = 0.46) that meet at 0.059 of the sound speed (Gray et al.
    2001): -> pieces afterwards, mean velocity of the left one over that of before, least spacing [dx]."""
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    law, dx = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3), 0.1
    sound = np.sqrt(law.bulk_modulus / law.density)
    square, volumes = lattice([-4.0, -4.0], [4.0, 4.0], dx, 1)
    radius = np.hypot(*square.T)
    ring = (radius < 4.0) & (radius > 3.0)
    positions = np.concatenate([square[ring] - [4.3, 0.0], square[ring] + [4.3, 0.0]])
    speed = 0.0295 * sound * 2.0
    solver = solver_of(positions, np.concatenate([volumes[ring]] * 2), law, dx=dx, scheme=scheme,
                       velocity=lambda x: np.stack([-np.sign(x[:, 0]) * speed, 0.0 * x[:, 0]], axis=1))
    while solver.time < 80.0 / sound:
        solver.step(solver.stable_dt()[0])
    left = solver.particles.labels()[:, 1] < ring.sum()
    near = cKDTree(solver.particles.positions()).sparse_distance_matrix(cKDTree(solver.particles.positions()), 1.6 * dx)
    return (connected_components(near)[0], solver.particles.column("velocity")[left, 0].mean() / speed,
            float(nearest(solver).min()))


@pytest.mark.slow
def test_rings_that_collide_bounce_instead_of_breaking():
    """M18c: without artificial stress they break where they are bent. They part after the end of the run, when one
    piece by nearness is two rings that still touch."""
    pieces, velocity, spacing = collide(artificial_stress=0.8)
    assert pieces <= 2 and velocity < -0.4 and spacing > 0.8
    assert collide()[0] > 4
