"""A piston drives a row of finite elements of a law together: what a wave does without a grid under it.

Uniaxial strain, nodes of lumped mass, one element of length dx between two, leapfrog. The stress of an element that is
compressed by dv in a step's time has, over that of the law, rho dv (a c + b dv), von Neumann and Richtmyer's viscosity
(1950, J. Appl. Phys. 21, 232) with a linear part; a = b = 0 for none.
"""

import numpy as np

from snowmpm.materials import StressUpdate

CFL = 0.4


def drive(law, speed, length, dx, duration, linear, quadratic):
    """-> times [s] and ways [m] of the front (the last element compressed beyond half), stress [Pa] and density [kg/m3]
    of the elements at the end, from the piston on. linear, quadratic: a and b."""
    n = round(length / dx)
    update, h, J = StressUpdate(law), np.zeros((n, 6)), np.ones(n)
    state, v, stress = update.initial_state(n), np.zeros(n + 1), np.zeros(n)
    v[0] = speed
    c, dt = law.wave_speed(), CFL * dx / law.wave_speed()
    front, increments = [], np.zeros((n, 3, 3))
    for step in range(round(duration / dt)):
        dv = np.diff(v)
        increments[:, 0, 0] = dt * dv / (J * dx)
        found = update(h, state, increments)
        h, state, J = found.h, found.state, J * (1.0 + increments[:, 0, 0])
        stress, pushed = found.stress[:, 0] / J, np.maximum(-dv, 0.0)
        force = stress - law.density / J * pushed * (linear * c + quadratic * pushed)
        v[1:-1] += dt / (law.density * dx) * np.diff(force)
        front.append(((step + 1) * dt, dx * (1 + np.flatnonzero(0.5 * (1.0 + J.min()) > J).max(initial=-1))))
    return *np.array(front).T, -stress, law.density / J
