"""A pulse of pressure or shear that runs through an elastic strip (M8)."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.study.problems.particle_states import ParticleStates

LAW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
DX, TRAVEL, STRAIN = 0.01, 2.0, 1e-4
SPEEDS = {"pressure": 127.0978, "shear": 67.9366, "rayleigh": 63.0053}


def pulse(z, length):
    return np.where(np.abs(z) < length / 2, np.cos(np.pi * z / length) ** 4, 0.0)


def pulse_slope(z, length):
    a = np.pi * z / length
    return np.where(np.abs(z) < length / 2, -4.0 * np.pi / length * np.cos(a) ** 3 * np.sin(a), 0.0)


def set_off(solver, kind, length, start, dt):
    """A pulse to the right, its velocity half a step before its strain; -> states."""
    states, speed, axis = ParticleStates(solver), SPEEDS[kind], int(kind == "shear")
    z = states.reference[:, 0] - start
    n, mu, bulk = len(z), LAW.shear_modulus, LAW.bulk_modulus
    velocity, affine, elastic, stress = np.zeros((n, 2)), np.zeros((n, 4)), np.zeros((n, 4)), np.zeros((n, 4))
    early = z + 0.5 * speed * dt
    velocity[:, axis] = STRAIN * speed * pulse(early, length)
    affine[:, 2 * axis] = STRAIN * speed * pulse_slope(early, length)
    gradient, ratio = -STRAIN * pulse(z, length), np.ones(n)  # du/dx = -v / c
    if kind == "pressure":
        ratio += gradient
        elastic[:, 0] = ratio**2 - 1.0
        stress[:, :3] = ((bulk - 2.0 / 3.0 * mu) * np.log(ratio))[:, None]
        stress[:, 0] += 2.0 * mu * np.log(ratio)
    else:
        elastic[:, 3], elastic[:, 1], stress[:, 3] = gradient, gradient**2, mu * gradient
    states.set(velocity=velocity, affine=affine, elastic=elastic, stress=stress, volume_ratio=ratio)
    return states
