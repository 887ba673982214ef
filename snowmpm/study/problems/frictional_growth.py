"""How fast disturbances of a frictional sheet grow: the granular slab of M15, stirred.

The whole slab above the ground that shears stands at its yield stress: tau / sigma_n is the same at all heights. There
frictional plasticity without dilation is ill-posed (Schaeffer 1987, doi:10.1016/0022-0396(87)90038-6): a wave of number
k along the slope grows at a rate that rises with k, and the shortest that the grid has grows fastest.
"""

import numpy as np

from snowmpm.study.problems.granular_slab import pressed_slab
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC

STIR = 1e-6
"""Standard deviation of the random velocities at the start [m/s], as float32 would make them."""
DURATION = 0.4
"""How long they may grow [s]."""
SETTLED = 0.02
"""Time [s] before which waves of the start are seen."""
SMALL = (3e-6, 3e-3)
"""Spreads [m/s] between which a disturbance grows exponentially: above the noise of the start, below its saturation."""


def stirred_slab(law, cells, scheme=APIC):
    """-> solver, `ParticleStates`, and rows (heights, 16) of particles of one height each, of a slab of
    0.4 m, `cells` deep."""
    solver, volume_ratio, height = pressed_slab(law, scheme, cells)
    states = ParticleStates(solver)
    states.set(volume_ratio=volume_ratio)
    states.add(velocity=STIR * np.random.default_rng(1).standard_normal(states.reference.shape))
    return solver, states, np.argsort(height, kind="stable").reshape(-1, 16)


def spreads(law, cells, scheme=APIC, every=25):
    """Times [s] (n,) and, of each, the largest standard deviation of the velocity along a row, which should have none
    [m/s] (n,), until it saturates."""
    solver, states, rows = stirred_slab(law, cells, scheme)
    found = []
    while solver.time < DURATION:
        for _ in range(every):
            solver.step(solver.stable_dt()[0])
        found.append((solver.time, states.column("velocity")[rows].std(axis=1).max()))
        if found[-1][1] > 3.0 * SMALL[1]:
            break
    return np.array(found).T


def growth_rate(law, cells, scheme=APIC):
    """Rate [1/s] at which the spread grows, least squares of its logarithm; 0 where it does not grow out of the noise
    of the start."""
    time, spread = spreads(law, cells, scheme)
    small = (spread > SMALL[0]) & (spread < SMALL[1]) & (time > SETTLED)
    if small.sum() < 4:
        return 0.0
    return float(np.polyfit(time[small], np.log(spread[small]), 1)[0])
