"""Axial vibration of a bar fixed at one end (M4): L = 25 m, E = 100 Pa, rho = 1 kg/m3, nu = 0, T = 4 L / c = 10 s."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice

LAW = Elastic(density=1.0, youngs_modulus=100.0, poisson_ratio=0.0)
LENGTH, PERIOD = 25.0, 10.0
PERIODS = 1.9
"""That are followed: four zeros of the mean velocity."""
SMALL = 0.01
"""Velocity [m/s] of `shape_error`: strains of 0.1 %, whose squares the exact solution leaves out."""


def bar(scheme, cells, offset=0.0, per_axis=2, dim=2, amplitude=0.1, across=3):
    """Solver of the bar in its first mode, `across` cells wide.

    offset: of the wall from a node [cells]; amplitude: of the velocity [m/s], over c the largest strain."""
    dx = LENGTH / cells
    positions, volumes = lattice([0.0] * dim, [LENGTH, *[across * dx] * (dim - 1)], dx, per_axis)
    wall = offset * dx
    velocities = np.zeros_like(positions)
    velocities[:, 0] = amplitude * np.sin(np.pi * positions[:, 0] / (2 * LENGTH))
    return scheme.solver(Population(positions + wall, volumes, 0, velocities), [LAW], dx=dx, origin=np.zeros(dim),
                         lower=np.full(dim, wall), upper=np.array([2 * LENGTH, *[across * dx + wall] * (dim - 1)]),
                         gravity=np.zeros(dim), sides=[["stick", "open"], *[["slip", "slip"]] * (dim - 1)])


def period(scheme, cells, offset=0.0, per_axis=2, dim=2, courant=0.2):
    """Period [s] of the first mode from the zeros of the mean velocity; courant: c dt / dx [-]."""
    solver = bar(scheme, cells, offset, per_axis, dim)
    dt, times, means = courant * LENGTH / cells / LAW.wave_speed(), [], []
    while solver.time < PERIODS * PERIOD:
        solver.step(dt)
        times.append(solver.time)
        means.append(solver.particles.column("velocity")[:, 0].mean())
    return 2.0 * np.diff(zeros(np.array(times), np.array(means))).mean()


def shape_error(scheme, cells, offset=0.0, per_axis=2, dim=2, courant=0.2):
    """Root mean square error of the velocity after PERIODS periods, over that of the start: phase and damping."""
    solver = bar(scheme, cells, offset, per_axis, dim, SMALL)
    states = ParticleStates(solver)
    x = states.reference[:, 0] - offset * LENGTH / cells
    steps = int(np.ceil(PERIODS * PERIOD * LAW.wave_speed() / (courant * solver.dx)))
    dt = PERIODS * PERIOD / steps
    mode = SMALL * np.sin(np.pi * x / (2 * LENGTH))
    # Symplectic Euler keeps v half a step behind
    states.set(velocity=np.concatenate([mode[:, None] * np.cos(np.pi * dt / PERIOD),
                                        np.zeros((len(x), dim - 1))], axis=1))
    for _ in range(steps):
        solver.step(dt)
    exact = mode * np.cos(2.0 * np.pi * (PERIODS * PERIOD - 0.5 * dt) / PERIOD)
    off = states.column("velocity")[:, 0] - exact
    return np.sqrt((off**2).mean() / (mode**2).mean())


def zeros(times, values):
    """Times at which a sampled quantity changes its sign, by straight lines between its samples."""
    k = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return times[k] - values[k] * (times[k + 1] - times[k]) / (values[k + 1] - values[k])
