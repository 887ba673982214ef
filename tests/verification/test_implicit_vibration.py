"""A bar that swings along its axis, by the average acceleration (I2): its energy stays, its period is that of theory.

Uniaxial strain, one end held, the first mode; amplitude 1e-6 of the length, so that the bar is linear. A step of
theta = omega dt makes the period longer by theta / (2 atan(theta / 2)).
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.implicit_steps import implicit

LAW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
DX, CELLS = 0.1, 10


def swing(steps, periods, **options):
    """Energy after each step over that after the first [-], and the period over that of the exact bar."""
    length, speed = CELLS * DX, LAW.wave_speed()
    mode, period = 0.5 * np.pi / length, 4.0 * length / speed
    x, volumes = lattice([0.0, 0.0], [length, DX], DX)
    velocities = np.zeros_like(x)
    velocities[:, 0] = 1e-6 * speed * np.sin(mode * x[:, 0])
    bar = implicit(x, volumes, LAW, DX, upper=[1.2 * length, DX], velocities=velocities,
                   sides=[["slip", "open"], ["slip", "slip"]], **options)
    states, energy, speeds = ParticleStates(bar), [], []
    for _ in range(steps * periods):
        bar.step(period / steps)
        v = states.column("velocity")
        stored = bar.materials.elastic_energy(np.zeros(len(x), int), states.column("stress"), states.column("state"),
                                              states.column("volume")[:, 0])
        energy.append(0.5 * states.mass @ (v**2).sum(axis=1) + stored)
        speeds.append((states.mass * v[:, 0]) @ np.sin(mode * x[:, 0]))
    time, speeds = period / steps * np.arange(1, len(speeds) + 1), np.array(speeds)
    n = np.flatnonzero(speeds[:-1] * speeds[1:] < 0.0)
    crossings = time[n] - speeds[n] * (time[n + 1] - time[n]) / (speeds[n + 1] - speeds[n])
    return np.array(energy) / energy[0], 2.0 * np.polyfit(np.arange(len(crossings)), crossings, 1)[0] / period


def longer(steps):
    """The period of the average acceleration over the exact one."""
    half = np.pi / steps
    return half / np.arctan(half)


def test_energy_and_period():
    energy, period = swing(20, 3)
    assert np.abs(energy - 1.0).max() < 1e-6
    assert period == pytest.approx(longer(20), abs=5e-4)  # of the grid, 3e-4


@pytest.mark.slow
def test_the_period_is_of_second_order():
    grid = swing(80, 2)[1] - longer(80)
    errors = [swing(steps, 2)[1] - 1.0 - grid for steps in (12, 24)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("transfer", ["apic", "flip"])
def test_energy_of_a_hundred_periods(transfer):
    energy, _ = swing(20, 100, solver={"transfer": transfer})
    assert np.abs(energy - 1.0).max() < 1e-6


def test_damping_takes_what_the_step_does_not_follow():
    """Ten steps a period lose little of it, and one step a period nearly all."""
    kept = [swing(steps, periods, damping=0.2)[0][-1] for steps, periods in ((40, 2), (1, 10))]
    assert kept[0] > 0.6 and kept[1] < 0.05
