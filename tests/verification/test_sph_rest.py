"""Columns at rest under SPH keep their stress (M18d), a cohesive one too, which tension instability would spoil."""

import numpy as np
import pytest

from snowmpm.materials import CohesiveCamClay, Elastic
from snowmpm.study.problems.particle_states import ParticleStates
from tests.sph.stage import lattice, solver_of

ICE = Elastic(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3)
SNOW = CohesiveCamClay(density=250.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2, cohesion=0.3,
                       hardening=1.0, p0=2e4)
G, DX, HEIGHT = 9.81, 0.05, 0.8


def column(law, free):
    """A column in its geostatic stress, damped until it rests; -> solver, states, exact vertical stress (n,) [Pa].

    free: it stands on rough ground, with nothing at its sides; else it lies between mirrors.
    """
    width = 8 * DX
    positions, volumes = lattice([0.0, 0.0], [width, HEIGHT], DX)
    vertical = -law.density * G * (HEIGHT - positions[:, 1])
    lateral = law.poisson_ratio * vertical if free else law.lateral_pressure * vertical
    stress = np.zeros((len(positions), 3, 3))
    stress[:, 1, 1], stress[:, 2, 2], stress[:, 0, 0] = vertical, lateral, 0.0 if free else lateral
    solver = solver_of(positions, volumes, law, dx=DX, stress=stress, gravity=[0.0, -G],
                       lower=[-1.0 if free else 0.0, 0.0], upper=[2.0 if free else width, 2 * HEIGHT],
                       sides=[["open", "open"] if free else ["slip", "slip"], ["stick" if free else "slip", "open"]])
    states, c = ParticleStates(solver), law.wave_speed()
    while solver.time < 40 * HEIGHT / c:
        dt = solver.stable_dt()[0]
        solver.keep = 1.0 - min(0.5, 0.1 * dt * c / DX)
        solver.step(dt)
    solver.keep = 1.0
    solver.restart_clock()
    return solver, states, vertical


def held(solver, states, time):
    """-> largest change of the vertical stress below three cells, way of the particle that went farthest [dx], kinetic
    over potential energy."""
    stress, places = states.column("stress")[:, 1], states.positions()
    deep = states.reference[:, 1] < HEIGHT - 3 * DX
    while solver.time < time:
        solver.step(solver.stable_dt()[0])
    change = np.abs(states.column("stress")[:, 1] / stress - 1.0)[deep].max()
    way = np.abs(states.positions() - places).max() / DX
    return change, way, 0.5 * (states.column("velocity") ** 2).sum(axis=1).mean() / (0.5 * G * HEIGHT)


def test_a_slab_on_rough_ground_carries_in_every_row_what_lies_above():
    """On a slope of 35 degrees: a tenth of rho g_t dx; with the shear stress of dummies that of the rows beside them,
    the rows lie 0.75 of it above and below in turns."""
    rows, slope = 12, np.radians(35.0)
    positions, volumes = lattice([0.0, 0.0], [8 * DX, rows * DX], DX)
    weight = ICE.density * G * (rows * DX - positions[:, 1])
    stress = np.zeros((len(positions), 3, 3))
    stress[:, 1, 1] = -weight * np.cos(slope)
    stress[:, 0, 0] = stress[:, 2, 2] = ICE.lateral_pressure * stress[:, 1, 1]
    stress[:, 0, 1] = stress[:, 1, 0] = weight * np.sin(slope)
    solver = solver_of(positions, volumes, ICE, dx=DX, stress=stress, gravity=[G * np.sin(slope), -G * np.cos(slope)],
                       lower=[0.0, 0.0], upper=[8 * DX, 2 * rows * DX],
                       sides=[["periodic", "periodic"], ["stick", "open"]])
    states, c = ParticleStates(solver), ICE.wave_speed()
    while solver.time < 40 * rows * DX / c:
        dt = solver.stable_dt()[0]
        solver.keep = 1.0 - min(0.5, 0.1 * dt * c / DX)
        solver.step(dt)
    found = states.column("stress")
    assert np.abs(found[:, 3] - stress[:, 0, 1]).max() < 0.1 * ICE.density * G * np.sin(slope) * DX
    assert np.abs(found[:, 1] - stress[:, 1, 1]).max() < 0.1 * ICE.density * G * np.cos(slope) * DX


@pytest.mark.parametrize(("time"), [0.3, pytest.param(10.0, marks=pytest.mark.slow)])
def test_elastic_column_between_mirrors(time):
    solver, states, exact = column(ICE, free=False)
    deep = states.reference[:, 1] < HEIGHT - 3 * DX
    assert (states.column("stress")[deep, 1] / exact[deep]).mean() == pytest.approx(1.0, abs=0.02)
    change, way, share = held(solver, states, time)
    assert change < 0.02 and way < 1e-3 and share < 1e-6


@pytest.mark.slow
def test_cohesive_column_that_stands_free():
    solver, states, _ = column(SNOW, free=True)
    change, way, share = held(solver, states, 10.0)
    assert change < 0.02 and way < 1e-3 and share < 1e-6
    assert solver.plastic_work == 0.0
