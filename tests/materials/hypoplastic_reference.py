"""Hypoplastic rates with full tensors, and an independent integration of them."""

import numpy as np
from scipy.integrate import solve_ivp

from snowmpm.materials.hypoplastic import Hypoplastic


def published_rate(law, sigma, D, void_ratio):
    """Right-hand side of the published law, written with full tensors."""
    c1, c2, c3, c4 = law.coefficients
    eta = sigma - law.tensile_apex * np.eye(3)
    total, size = np.trace(eta), np.sqrt((D * D).sum())
    deviator = eta - total / 3.0 * np.eye(3)
    if isinstance(law, Hypoplastic):
        scalar = c2 * np.trace(D) + c3 * (eta * D).sum() / total
        return c1 * total * D + scalar * eta + c4 * (eta + deviator) * size
    critical = law.critical_void_ratio(-total / 3.0)
    a = 1.0 - law.density_effect * np.exp(total / law.density_effect_scale)
    f_d = (a - 1.0) * (critical - void_ratio) / (critical - law.least_void_ratio) + 1.0
    friction = f_d * size / total * (c3 * eta @ eta + c4 * deviator @ deviator)
    return c1 * total * D + c2 * (eta * D).sum() / total * eta + friction


def jaumann(law, stress, L, time=1.0):
    """Cauchy stress after a constant velocity gradient, by an independent integrator with the Jaumann rate."""
    D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)

    def slope(t, y):
        sigma, e = y[:9].reshape(3, 3), y[9]
        return np.append((published_rate(law, sigma, D, e) + W @ sigma - sigma @ W).ravel(), (1.0 + e) * np.trace(D))

    start = np.append(stress.ravel(), law.void_ratio)
    solution = solve_ivp(slope, (0.0, time), start, method="DOP853", rtol=1e-12, atol=1e-9)
    return solution.y[:9, -1].reshape(3, 3), solution.y[9, -1]
