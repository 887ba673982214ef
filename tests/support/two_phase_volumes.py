"""Grains and water in one dimension by finite volumes: Pelanti, Bouchut and Mangeney (2008, doi:10.1051/m2an:2008029).

    d h_s/dt + d(h_s v_s)/dx = 0,    d(h_s v_s)/dt + d(h_s v_s² + g/2 h_s² + (1 - gamma)/2 g h_s h_w)/dx
                                                    + gamma g h_s dh_w/dx = +h C (v_w - v_s) / rho_s
    d h_w/dt + d(h_w v_w)/dx = 0,    d(h_w v_w)/dt + d(h_w v_w² + g/2 h_w²)/dx
                                                    + g h_w dh_s/dx = -h C (v_w - v_s) / rho_w

Rusanov's fluxes, products by central differences, drag by a step backwards; first order, so with many cells. Walls at
both ends. It shares nothing with the columns of `snowmpm.depth`.
"""

import numpy as np

G = 9.81


def flow(h_s, h_w, dx, until, *, grains, water, drag):
    """h_s, h_w, v_s, v_w (n,) at the time `until` [s] of depths (n,) at rest; drag: function of the porosity -> C."""
    gamma = water / grains
    u = np.array([h_s, 0.0 * h_s, h_w, 0.0 * h_w], float)
    time = 0.0
    while time < until - 1e-12:
        a, b = u[0], u[2]
        v, w = u[1] / a, u[3] / b
        speed = np.sqrt(G * (a + b)) + np.maximum(np.abs(v), np.abs(w))
        dt = min(0.45 * dx / speed.max(), until - time)
        wide = np.concatenate([u[:, :1] * WALL, u, u[:, -1:] * WALL], axis=1)
        a, b = wide[0], wide[2]
        v, w = wide[1] / a, wide[3] / b
        flux = np.array([a * v, a * v**2 + 0.5 * G * a**2 + 0.5 * (1.0 - gamma) * G * a * b, b * w,
                         b * w**2 + 0.5 * G * b**2])
        s = np.concatenate([speed[:1], speed, speed[-1:]])
        face = 0.5 * (flux[:, 1:] + flux[:, :-1]) - 0.5 * np.maximum(s[1:], s[:-1]) * (wide[:, 1:] - wide[:, :-1])
        new = u - dt / dx * (face[:, 1:] - face[:, :-1])
        new[1] -= dt * gamma * G * u[0] * (b[2:] - b[:-2]) / (2.0 * dx)
        new[3] -= dt * G * u[2] * (a[2:] - a[:-2]) / (2.0 * dx)
        a, b = new[0], new[2]
        mass_s, mass_w = grains * a, water * b
        force = dt * (a + b) * drag(b / (a + b))
        slip = (new[3] / b - new[1] / a) / (1.0 + force * (1.0 / mass_s + 1.0 / mass_w))
        mean = (grains * new[1] + water * new[3]) / (mass_s + mass_w)
        new[1] = a * (mean - slip * mass_w / (mass_s + mass_w))
        new[3] = b * (mean + slip * mass_s / (mass_s + mass_w))
        u, time = new, time + dt
    return u[0], u[2], u[1] / u[0], u[3] / u[2]


WALL = np.array([[1.0], [-1.0], [1.0], [-1.0]])
